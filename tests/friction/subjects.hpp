// What the law suite runs over: every law of the table, and compositions through RobotFriction.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/friction/detail/kernels.hpp"
#include "fricid/friction/laws.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/friction/sum.hpp"

namespace fricid::friction::test {

// Largest |z_i| that theta allows at the speeds of the suite.
constexpr double kFastest = 1e3;  // [rad/s]
template <class Law>
std::vector<double> state_bound(const Law& law, const double* theta) {
  std::vector<double> bound(static_cast<std::size_t>(law.state_size()));
  if constexpr (requires { law.state_bound(theta, kFastest, bound.data()); })
    law.state_bound(theta, kFastest, bound.data());
  return bound;
}

/// One law by itself.
template <class Law>
struct LawSubject {
  Law law;
  std::string name;
  Claims claims = Law::kClaims;

  explicit LawSubject(Law l) : law(l), name(Law::kName) {
    if (Law::kMostElements > 0)
      name += ", " + std::to_string(law.parameters().size()) + " parameters";
  }
  std::vector<ParameterInfo> parameters() const {
    return {law.parameters().begin(), law.parameters().end()};
  }
  int state_size() const { return law.state_size(); }
  std::vector<double> bound(const double* theta) const { return state_bound(law, theta); }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S* z) const {
    return law.torque(theta, in, z);
  }
  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* z) const {
    law.step(theta, in, dt, z);
  }
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return law.steady_torque(theta, in);
  }
  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S* z, const S& tau_bar,
                       S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    law.torque_pullback(theta, in, z, tau_bar, theta_bar, in_bar, z_bar);
  }
  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    law.step_pullback(theta, in, dt, z, z_next_bar, theta_bar, in_bar, z_bar);
  }
};

/// The friction of a joint through RobotFriction.
struct JointSubject {
  RobotFriction model;
  std::string name;
  Claims claims;

  explicit JointSubject(const JointSpec& joint) : model({joint}) {
    for (const LawSpec& spec : joint.laws) {
      name += (name.empty() ? "" : " + ") + spec.law;
      restrict_claims(law_table(), spec.law);
      for (const ModifierSpec& m : spec.modifiers) {
        name += "." + m.name;
        restrict_claims(modifier_table(), m.name);
      }
    }
  }
  std::vector<ParameterInfo> parameters() const {
    std::vector<ParameterInfo> infos;
    for (const ParameterRef& p : model.parameters()) infos.push_back(p.info);
    return infos;
  }
  int state_size() const { return model.state_size(); }
  std::vector<double> bound(const double* theta) const {
    std::vector<double> all;
    for (const auto& slot : Kernels<double>::slots(model))
      visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
        for (const double b : state_bound(law, theta + slot.theta)) all.push_back(b);
        if (slot.backlash.kind >= 0) all.push_back(theta[slot.backlash.theta]);
      });
    return all;
  }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S* z) const {
    S tau;
    model.torque<S>({theta, n_theta()}, {&in, 1}, {z, n_z()}, {&tau, 1});
    return tau;
  }
  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* z) const {
    model.step<S>({theta, n_theta()}, {&in, 1}, dt, {z, n_z()});
  }
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    S tau;
    model.steady_torque<S>({theta, n_theta()}, {&in, 1}, {&tau, 1});
    return tau;
  }
  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S* z, const S& tau_bar,
                       S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    model.torque_pullback<S>({theta, n_theta()}, {&in, 1}, {z, n_z()}, {&tau_bar, 1},
                             {theta_bar, n_theta()}, {&in_bar, 1}, {z_bar, n_z()});
  }
  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    model.step_pullback<S>({theta, n_theta()}, {&in, 1}, dt, {z, n_z()}, {z_next_bar, n_z()},
                           {theta_bar, n_theta()}, {&in_bar, 1}, {z_bar, n_z()});
  }

 private:
  std::size_t n_theta() const { return static_cast<std::size_t>(model.parameter_count()); }
  std::size_t n_z() const { return static_cast<std::size_t>(model.state_size()); }

  void restrict_claims(std::span<const LawInfo> table, const std::string& entry) {
    for (const LawInfo& info : table) {
      if (info.name != entry) continue;
      claims.odd &= info.claims.odd;
      claims.dissipative &= info.claims.dissipative;
      claims.contracts &= info.claims.contracts;
      claims.semigroup &= info.claims.semigroup;
      claims.settles &= info.claims.settles;
    }
  }
};

/// Compositions: every modifier on laws of each kind, and what the ground-truth scenes inject.
inline std::vector<JointSpec> compositions() {
  const ModifierSpec load{"load"}, gear_load{"gear_load"}, ripple{"ripple", 3},
      temperature{"temperature"}, asymmetry{"asymmetry"}, backlash{"backlash"};
  return {
      {},
      {{{"coulomb_viscous", 0, {load, temperature}}}},
      {{{"stribeck", 0, {asymmetry, ripple}}}},
      {{{"coulomb_viscous", 0, {backlash}}}},
      {{{"coulomb_viscous", 0, {gear_load}}}},
      {{{"lugre", 0, {gear_load, asymmetry}}}},
      {{{"dahl", 0, {load, ripple, temperature, asymmetry}}}},
      {{{"dahl", 0, {backlash}}}},
      {{{"lugre", 0, {backlash, load}}, {"viscous_power", 0, {temperature}}}},
      {{{"gms", 4, {asymmetry, backlash, ripple}}, {"load_dependent", 0, {}}}},
      {{{"maxwell_slip", 10, {load, ripple, asymmetry}}, {"viscous_power", 0, {}}}},
      {{{"maxwell_slip", 3, {temperature, backlash}}}},
      {{{"lvm_bristles", 6, {ripple, backlash}}, {"neural", 3, {temperature}}}},
      lvm_sum({.temperature = true, .ripples = 2}),
      lvm_sum({.memory = Memory::kBristle, .temperature = true}),
      lvm_sum({.memory = Memory::kNone, .network = 5}),
  };
}

/// Calls f(subject) for all laws (those with elements at 1, 4 and the most) and compositions.
template <class F>
void for_each_subject(F&& f) {
  const auto one = [&]<class Law>(std::type_identity<Law>) {
    if constexpr (Law::kMostElements > 0)
      for (const int n : {1, 4, Law::kMostElements}) f(LawSubject<Law>(Law(n)));
    else
      f(LawSubject<Law>(Law{}));
  };
  [&]<class... L>(std::tuple<L...>*) {
    (one(std::type_identity<L>{}), ...);
  }(static_cast<Laws*>(nullptr));
  for (const JointSpec& joint : compositions()) f(JointSubject(joint));
}

/// Random draws for one subject: parameters within a factor 3 of typical, inputs and states over
/// all that a joint may meet.
class Draw {
 public:
  explicit Draw(std::uint64_t stream) : rng_(20240711, stream) {}

  double uniform(double low, double high) { return low + (high - low) * rng_.uniform(); }
  double log_uniform(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }
  double sign() { return rng_.uniform() < 0.5 ? -1 : 1; }

  std::vector<double> theta(const std::vector<ParameterInfo>& parameters) {
    std::vector<double> values;
    for (const ParameterInfo& p : parameters) {
      double x = p.typical * log_uniform(1.0 / 3, 3);
      if (p.typical == 0) x = uniform(std::max(p.lower, -kLarge), std::min(p.upper, kLarge));
      values.push_back(std::clamp(x, p.lower, p.upper));
    }
    return values;
  }
  double speed(double most = kFastest) { return sign() * log_uniform(1e-6, most); }
  Input<double> input(double most = kFastest) {
    return {uniform(-3, 3), speed(most), uniform(-60, 60), uniform(280, 340)};
  }
  std::vector<double> state(const std::vector<double>& bound) {
    std::vector<double> z;
    for (const double b : bound) z.push_back(uniform(-b, b));
    return z;
  }

 private:
  static constexpr double kLarge = 1;  // parameters around 0: phases, weights
  Rng rng_;
};

}  // namespace fricid::friction::test
