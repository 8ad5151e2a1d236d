#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Dead zone in series with a law: the joint moves the law only through a gap.
///
/// The joint position is that of the law plus g, the position in the gap, |g| <= b. Let tau_0 be
/// the torque that the law has stored, that is its torque at v = 0. A motion that loads (tau_0 v >=
/// 0) crosses the gap first, with tau = tau_0, about zero, and the law gets what remains; a motion
/// that unloads moves the law first, until tau_0 = 0, and then crosses the gap:
///
///     v_law dt = v dt - (g' - g)
///
/// Contact, and crossing the gap from any point, are exact for held v. The moment when an unloading
/// law reaches tau_0 = 0 is found by one secant, so a law enters the gap with a stored torque of
/// second order in dt. In the one step in which contact is made or lost, the law sees the mean of
/// its velocity, which is exact for laws that do not depend on rate; there the composition is not a
/// semigroup. The gap creates no energy: in it tau_0 resists the motion, outside it the law acts
/// alone.
///
/// A law without state has tau_0 = 0: full torque in contact, none in the gap. State: g (1) [rad].
class Backlash {
 public:
  enum Index { kB, kSize };

  static constexpr std::string_view kName = "backlash";
  static constexpr std::string_view kEquation =
      "g' = clamp(g + v dt - unloading, +-b); law sees v - (g' - g)/dt";
  static constexpr std::string_view kSource = "Nordin & Gutman, Automatica 38(10), 2002";
  static constexpr Claims kClaims{.contracts = false, .semigroup = false};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;
  static constexpr std::string_view kStateUnit = "rad";

  static constexpr int state_size() { return 1; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  /// Input that the law sees when its torque is read.
  template <class Law, class S>
  static Input<S> seen(const Law& law, const S* theta_law, const S* theta, const Input<S>& in,
                       const S* z, const S& g) {
    Input<S> out = in;
    out.v = select(in_gap(law, theta_law, theta, in, z, g), S(0), in.v);
    return out;
  }

  /// True while v crosses the gap: without contact on either side, or away from a contact whose law
  /// stores nothing. Contact is exact, g = +-b; the stored torque of a law that unloaded is zero up
  /// to rounding, so its sign says nothing without contact.
  template <class Law, class S>
  static auto in_gap(const Law& law, const S* theta_law, const S* theta, const Input<S>& in,
                     const S* z, const S& g) {
    const S stored = law.torque(theta_law, at_rest(in), z);
    return (abs(g) < theta[kB]) | ((stored * in.v >= S(0)) & (room(theta, in.v, g) > S(0)));
  }

  /// Moves the gap and the law by dt [s].
  template <class Law, class S>
  static void step(const Law& law, const S* theta_law, const S* theta, const Input<S>& in,
                   double dt, S* z, S& g) {
    if (dt == 0) return;
    const Plan<S> plan = make_plan(law, theta_law, theta, in, dt, z, g);
    g = plan.g_next;
    Input<S> law_in = in;
    law_in.v = plan.v_law;
    law.step(theta_law, law_in, dt, z);
  }

  /// Vector-Jacobian product of `step`.
  template <class Law, class S>
  static void step_pullback(const Law& law, const S* theta_law, const S* theta, const Input<S>& in,
                            double dt, const S* z, const S& g, const S* z_next_bar,
                            const S& g_next_bar, S* theta_law_bar, S* theta_bar, Input<S>& in_bar,
                            S* z_bar, S& g_bar) {
    const int n = law.state_size();
    if (dt == 0) {
      for (int i = 0; i < n; ++i) z_bar[i] += z_next_bar[i];
      g_bar += g_next_bar;
      return;
    }
    const Plan<S> plan = make_plan(law, theta_law, theta, in, dt, z, g);
    Input<S> law_in = in, law_in_bar = zero_input<S>();
    law_in.v = plan.v_law;
    law.step_pullback(theta_law, law_in, dt, z, z_next_bar, theta_law_bar, law_in_bar, z_bar);
    in_bar.q += law_in_bar.q;
    in_bar.load += law_in_bar.load;
    in_bar.temperature += law_in_bar.temperature;

    // the gap closes within the step: g' = +-b, v_law = v -+ room/dt
    const S v_law_bar = law_in_bar.v;
    const S closes_g_bar = select(plan.closes, g_next_bar, S(0));
    const S closes_v_bar = select(plan.closes, v_law_bar, S(0));
    const S room_bar = -closes_v_bar * plan.direction / S(dt);
    theta_bar[kB] += closes_g_bar * plan.direction + room_bar;
    g_bar -= room_bar * plan.direction;

    // it stays open: g' = g + (1 - f) v dt, v_law = f v
    const S opens_g_bar = g_next_bar - closes_g_bar;
    const S opens_v_bar = v_law_bar - closes_v_bar;
    g_bar += opens_g_bar;
    in_bar.v += closes_v_bar + opens_g_bar * (S(1) - plan.f) * S(dt) + opens_v_bar * plan.f;
    const S f_bar = select(plan.crosses, opens_v_bar * in.v - opens_g_bar * in.v * S(dt), S(0));

    // f = tau_0 / (tau_0 - tau_1), both read at rest, tau_1 after a trial step
    if (!any(plan.crosses)) return;
    const S drop = select(plan.crosses, plan.stored - plan.trial, S(1));
    const S stored_bar = -f_bar * plan.trial / (drop * drop);
    const S trial_bar = f_bar * plan.stored / (drop * drop);
    std::array<S, kMaxElements> z_trial{}, z_trial_bar{};
    std::copy_n(z, n, z_trial.begin());
    law.step(theta_law, in, dt, z_trial.data());
    Input<S> rest_bar = zero_input<S>();
    law.torque_pullback(theta_law, at_rest(in), z_trial.data(), trial_bar, theta_law_bar, rest_bar,
                        z_trial_bar.data());
    law.torque_pullback(theta_law, at_rest(in), z, stored_bar, theta_law_bar, rest_bar, z_bar);
    in_bar.q += rest_bar.q;
    in_bar.load += rest_bar.load;
    in_bar.temperature += rest_bar.temperature;
    law.step_pullback(theta_law, in, dt, z, z_trial_bar.data(), theta_law_bar, in_bar, z_bar);
  }

  /// How a step divides between gap and law.
  template <class S>
  struct Plan {
    using Truth = decltype(S(0) < S(0));
    S direction;      ///< of v
    S stored, trial;  ///< torque at v = 0, before and after a trial step without a gap [N m]
    S f;              ///< part of the step during which the law unloads before the gap moves
    Truth crosses;    ///< 0 < f < 1: the law unloads within the step
    Truth closes;     ///< the gap closes within the step
    S g_next, v_law;
  };

  /// @pre dt > 0
  template <class Law, class S>
  static Plan<S> make_plan(const Law& law, const S* theta_law, const S* theta, const Input<S>& in,
                           double dt, const S* z, const S& g) {
    Plan<S> plan;
    plan.direction = select(in.v < S(0), S(-1), S(1));
    plan.stored = law.torque(theta_law, at_rest(in), z);
    plan.trial = plan.stored;
    const auto unloads = plan.stored * in.v < S(0);
    if (any(unloads)) {
      std::array<S, kMaxElements> z_trial;
      std::copy_n(z, law.state_size(), z_trial.begin());
      law.step(theta_law, in, dt, z_trial.data());
      plan.trial = law.torque(theta_law, at_rest(in), static_cast<const S*>(z_trial.data()));
    }
    plan.crosses = unloads & (plan.trial * in.v > S(0));
    const S secant = plan.stored / select(plan.crosses, plan.stored - plan.trial, S(1));
    plan.f = select(plan.crosses, secant, select(unloads, S(1), S(0)));

    const S gap_room = room(theta, in.v, g);
    const S wanted = abs(in.v) * S(dt) * (S(1) - plan.f);
    plan.closes = wanted >= gap_room;
    plan.g_next =
        select(plan.closes, plan.direction * theta[kB], g + in.v * S(dt) * (S(1) - plan.f));
    plan.v_law = select(plan.closes, in.v - plan.direction * gap_room / S(dt), in.v * plan.f);
    return plan;
  }

  /// What moves with a step.
  template <class S>
  struct Change {
    S v_law, g_next;
  };

  /// d(v_law, g') when a parameter moves b, g, and the torques before and after a trial step.
  template <class S>
  static Change<S> change(const Plan<S>& plan, const S& v, double dt, const S& b, const S& g,
                          const S& stored, const S& trial) {
    // f = tau_0 / (tau_0 - tau_1)
    const S drop = select(plan.crosses, plan.stored - plan.trial, S(1));
    const S f =
        select(plan.crosses, (plan.stored * trial - plan.trial * stored) / (drop * drop), S(0));
    return {select(plan.closes, (g - plan.direction * b) / S(dt), v * f),
            select(plan.closes, plan.direction * b, g - v * S(dt) * f)};
  }

  template <class S>
  static Input<S> at_rest(Input<S> in) {
    in.v = S(0);
    return in;
  }

 private:
  template <class S>  // what is left of the gap in the direction of v [rad]
  static S room(const S* theta, const S& v, const S& g) {
    return select(v < S(0), theta[kB] + g, theta[kB] - g);
  }

  template <class S>
  static Input<S> zero_input() {
    return {S(0), S(0), S(0), S(0)};
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"b", "rad", Role::kGap, 0, 0.1, 1.5e-4, Scale::kLinear, "half the width of the gap"},
  }};
};

}  // namespace fricid::friction
