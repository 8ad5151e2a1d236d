// Definitions of the templates of RobotFriction, for the sources that instantiate them: double,
// PackD and PackF in the library, dual numbers in the tests.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>

#include "fricid/base/group.hpp"
#include "fricid/friction/laws.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/friction/robot_laws.hpp"

namespace fricid::friction {

/// One law seen through its modifiers, at scalar type S.
template <class S>
struct Kernels {
  using Slot = RobotFriction::LawSlot;
  static constexpr std::size_t kMaxModifiers = std::tuple_size_v<Modifiers>;
  using Stages = std::array<S, kMaxModifiers + 1>;  // torque before, between and after modifiers

  // The torque behind the modifier `m`.
  [[gnu::always_inline]] static S behind(const auto& m, const S* theta, const Input<S>& in, S tau) {
    visit_entry<Modifiers>(m.kind, m.order, [&](const auto modifier) {
      if constexpr (TorqueModifier<std::remove_cvref_t<decltype(modifier)>>)
        tau = modifier.apply(theta + m.theta, in, tau);
    });
    return tau;
  }

  using Run = RobotFriction::Run;
  using RunTorque = std::array<S, RobotFriction::kLongestRun>;

  // Adds the torques of the laws of a run, behind all their modifiers, to tau_f.
  static void add_modified(const Slot* slots, std::size_t size, const S* theta,
                           std::span<const Input<S>> in, RunTorque& tau, std::span<S> tau_f) {
    for (std::size_t k = 0; k < slots->torque_modifiers.size(); ++k)
      visit_entry<Modifiers>(
          slots->torque_modifiers[k].kind, slots->torque_modifiers[k].order,
          [&](const auto modifier) {
            if constexpr (TorqueModifier<std::remove_cvref_t<decltype(modifier)>>)
              for (std::size_t i = 0; i < size; ++i)
                tau[i] = modifier.apply(theta + slots[i].torque_modifiers[k].theta,
                                        in[static_cast<std::size_t>(slots[i].joint)], tau[i]);
          });
    for (std::size_t i = 0; i < size; ++i)
      tau_f[static_cast<std::size_t>(slots[i].joint)] += tau[i];
  }

  // The same, keeping what each modifier has seen.
  static void modify(const Slot& slot, const S* theta, const Input<S>& in, const S& tau,
                     Stages& stages) {
    stages[0] = tau;
    std::size_t k = 0;
    for (const auto& m : slot.torque_modifiers) {
      stages[k + 1] = behind(m, theta, in, stages[k]);
      ++k;
    }
  }

  static S modify_pullback(const Slot& slot, const S* theta, const Input<S>& in,
                           const Stages& stages, S tau_bar, S* theta_bar, Input<S>& in_bar) {
    for (std::size_t k = slot.torque_modifiers.size(); k-- > 0;) {
      const auto& m = slot.torque_modifiers[k];
      S inner_bar = S(0);
      visit_entry<Modifiers>(m.kind, m.order, [&](const auto modifier) {
        if constexpr (TorqueModifier<std::remove_cvref_t<decltype(modifier)>>)
          modifier.apply_pullback(theta + m.theta, in, stages[k], tau_bar, theta_bar + m.theta,
                                  in_bar, inner_bar);
      });
      tau_bar = inner_bar;
    }
    return tau_bar;
  }

  [[gnu::always_inline]] static Input<S> seen(const auto& law, const Slot& slot, const S* theta,
                                              const Input<S>& in, const S* z) {
    if (slot.backlash.kind < 0) return in;
    return Backlash::seen(law, theta + slot.theta, theta + slot.backlash.theta, in, z + slot.z,
                          z[slot.backlash.z]);
  }

  [[gnu::always_inline]] static S torque(const auto& law, const Slot& slot, const S* theta,
                                         const Input<S>& in, const S* z) {
    return law.torque(theta + slot.theta, seen(law, slot, theta, in, z), z + slot.z);
  }

  [[gnu::always_inline]] static void step(const auto& law, const Slot& slot, const S* theta,
                                          const Input<S>& in, double dt, S* z) {
    if (slot.backlash.kind < 0)
      law.step(theta + slot.theta, in, dt, z + slot.z);
    else
      Backlash::step(law, theta + slot.theta, theta + slot.backlash.theta, in, dt, z + slot.z,
                     z[slot.backlash.z]);
  }

  // Steps one law; its torque after that.
  [[gnu::always_inline]] static S step_torque(const auto& law, const Slot& slot, const S* theta,
                                              const Input<S>& in, double dt, S* z) {
    if constexpr (SharedStepLaw<std::remove_cvref_t<decltype(law)>, S>)
      if (slot.backlash.kind < 0) return law.step_torque(theta + slot.theta, in, dt, z + slot.z);
    step(law, slot, theta, in, dt, z);
    return torque(law, slot, theta, in, z);
  }

  static void torque_pullback(const auto& law, const Slot& slot, const S* theta, const Input<S>& in,
                              const S* z, const S& tau_f_bar, S* theta_bar, Input<S>& in_bar,
                              S* z_bar) {
    const Input<S> law_in = seen(law, slot, theta, in, z);
    S tau_bar = tau_f_bar;
    if (!slot.torque_modifiers.empty()) {
      Stages stages;
      modify(slot, theta, in, law.torque(theta + slot.theta, law_in, z + slot.z), stages);
      tau_bar = modify_pullback(slot, theta, in, stages, tau_f_bar, theta_bar, in_bar);
    }
    const S v_bar = in_bar.v;
    law.torque_pullback(theta + slot.theta, law_in, z + slot.z, tau_bar, theta_bar + slot.theta,
                        in_bar, z_bar + slot.z);
    // in the gap the law does not see v
    if (slot.backlash.kind >= 0)
      in_bar.v = select(Backlash::in_gap(law, theta + slot.theta, theta + slot.backlash.theta, in,
                                         z + slot.z, z[slot.backlash.z]),
                        v_bar, in_bar.v);
  }

  static void step_pullback(const auto& law, const Slot& slot, const S* theta, const Input<S>& in,
                            double dt, const S* z, const S* z_next_bar, S* theta_bar,
                            Input<S>& in_bar, S* z_bar) {
    const auto& gap = slot.backlash;
    if (gap.kind < 0)
      law.step_pullback(theta + slot.theta, in, dt, z + slot.z, z_next_bar + slot.z,
                        theta_bar + slot.theta, in_bar, z_bar + slot.z);
    else
      Backlash::step_pullback(law, theta + slot.theta, theta + gap.theta, in, dt, z + slot.z,
                              z[gap.z], z_next_bar + slot.z, z_next_bar[gap.z],
                              theta_bar + slot.theta, theta_bar + gap.theta, in_bar, z_bar + slot.z,
                              z_bar[gap.z]);
  }

  static std::span<const Slot> slots(const RobotFriction& model) { return model.slots_; }

  // N joints side by side, under a law of one state without modifiers.
  template <class Law, int N>
  struct Joints {
    std::array<Group<S, N>, Law::parameters().size()> theta;
    Input<Group<S, N>> in;
    Group<S, N> z;
  };
  template <class Law, int N>
  [[gnu::always_inline]] static Joints<Law, N> gather(const Slot* slots, const S* theta,
                                                      std::span<const Input<S>> in, const S* z) {
    static_assert(Law::state_size() == 1);
    Joints<Law, N> joints;
#pragma GCC unroll 8
    for (int k = 0; k < N; ++k) {
      for (std::size_t i = 0; i < joints.theta.size(); ++i)
        joints.theta[i].x[k] = theta[static_cast<std::size_t>(slots[k].theta) + i];
      const Input<S>& input = in[static_cast<std::size_t>(slots[k].joint)];
      joints.in.q.x[k] = input.q;
      joints.in.v.x[k] = input.v;
      joints.in.load.x[k] = input.load;
      joints.in.temperature.x[k] = input.temperature;
      joints.z.x[k] = z[slots[k].z];
    }
    return joints;
  }
  template <int N>
  [[gnu::always_inline]] static void scatter_state(const Slot* slots, const Group<S, N>& from,
                                                   S* z) {
#pragma GCC unroll 8
    for (int k = 0; k < N; ++k) z[slots[k].z] = from.x[k];
  }
  template <int N>
  [[gnu::always_inline]] static void scatter_torque(const Group<S, N>& from, S* tau) {
#pragma GCC unroll 8
    for (int k = 0; k < N; ++k) tau[k] = from.x[k];
  }

  // Calls one(law, slot, i) for slot i of every run, one dispatch per run; several<N>(law, slots,
  // i) for N slots of a law that is one long chain of operations; and after(run, slots) behind
  // each.
  template <class One, class Several, class After>
  static void for_each(const RobotFriction& model, One&& one, Several&& several, After&& after) {
    for (const Run& run : model.runs_) {
      const Slot* slots = model.slots_.data() + run.begin;
      visit_entry<Laws>(run.kind, run.elements, [&](const auto law) {
        std::size_t i = 0;
        using Law = std::remove_cvref_t<decltype(law)>;
        if constexpr (kIsPack<S> && SharedStepLaw<Law, S> && !LearnedLaw<Law>) {
          const auto take = [&]<std::size_t N>(std::integral_constant<std::size_t, N>) {
            for (; slots->backlash.kind < 0 && run.size - i >= N; i += N)
              several.template operator()<static_cast<int>(N)>(law, slots + i, i);
          };
          take(std::integral_constant<std::size_t, 6>());
          take(std::integral_constant<std::size_t, 2>());
        }
        for (; i < run.size; ++i) one(law, slots[i], i);
      });
      after(slots, run.size);
    }
  }
  // Calls one(law, slot, j) for the laws of every joint j, in order.
  template <class One>
  static void for_each(const RobotFriction& model, One&& one) {
    for (const Run& run : model.runs_)
      visit_entry<Laws>(run.kind, run.elements, [&](const auto law) {
        for (std::size_t i = run.begin; i < run.begin + run.size; ++i)
          one(law, model.slots_[i], static_cast<std::size_t>(model.slots_[i].joint));
      });
  }

  // Calls f(law) where there is a law of the whole robot.
  template <class F>
  static void visit_whole(const RobotFriction::RobotLawSlot& slot, F&& f) {
    if (slot.kind >= 0) visit_robot_law(slot.kind, slot.size, f);
  }
};

template <class S>
void RobotFriction::torque(std::span<const S> theta, std::span<const Input<S>> in,
                           std::span<const S> z, std::span<S> tau_f) const {
  assert(static_cast<int>(theta.size()) == parameter_count() &&
         static_cast<int>(z.size()) == state_size() &&
         static_cast<int>(in.size()) == joint_count() && tau_f.size() == in.size());
  std::fill(tau_f.begin(), tau_f.end(), S(0));
  using K = Kernels<S>;
  typename K::RunTorque tau;
  K::for_each(
      *this,
      [&](const auto& law, const LawSlot& slot, std::size_t i) {
        tau[i] =
            K::torque(law, slot, theta.data(), in[static_cast<std::size_t>(slot.joint)], z.data());
      },
      [&]<int N, class Law>(const Law& law, const LawSlot* slots, std::size_t i) {
        const auto joints = K::template gather<Law, N>(slots, theta.data(), in, z.data());
        K::scatter_torque(law.torque(joints.theta.data(), joints.in, &joints.z), &tau[i]);
      },
      [&](const LawSlot* slots, std::size_t size) {
        K::add_modified(slots, size, theta.data(), in, tau, tau_f);
      });
  Kernels<S>::visit_whole(whole_slot_, [&](const auto law) {
    law.add_torque(theta.data() + whole_slot_.theta, in.data(), z.data() + whole_slot_.z,
                   tau_f.data());
  });
}

template <class S>
void RobotFriction::step(std::span<const S> theta, std::span<const Input<S>> in, double dt,
                         std::span<S> z) const {
  assert(static_cast<int>(theta.size()) == parameter_count() &&
         static_cast<int>(z.size()) == state_size() &&
         static_cast<int>(in.size()) == joint_count());
  using K = Kernels<S>;
  K::for_each(
      *this,
      [&](const auto& law, const LawSlot& slot, std::size_t) {
        K::step(law, slot, theta.data(), in[static_cast<std::size_t>(slot.joint)], dt, z.data());
      },
      [&]<int N, class Law>(const Law& law, const LawSlot* slots, std::size_t) {
        auto joints = K::template gather<Law, N>(slots, theta.data(), in, z.data());
        law.step(joints.theta.data(), joints.in, dt, &joints.z);
        K::scatter_state(slots, joints.z, z.data());
      },
      [](const LawSlot*, std::size_t) {});
  Kernels<S>::visit_whole(whole_slot_, [&](const auto law) {
    law.step(theta.data() + whole_slot_.theta, in.data(), dt, z.data() + whole_slot_.z);
  });
}

template <class S>
void RobotFriction::step_torque(std::span<const S> theta, std::span<const Input<S>> in, double dt,
                                std::span<S> z, std::span<S> tau_f) const {
  assert(static_cast<int>(theta.size()) == parameter_count() &&
         static_cast<int>(z.size()) == state_size() &&
         static_cast<int>(in.size()) == joint_count() && tau_f.size() == in.size());
  std::fill(tau_f.begin(), tau_f.end(), S(0));
  using K = Kernels<S>;
  typename K::RunTorque tau;
  K::for_each(
      *this,
      [&](const auto& law, const LawSlot& slot, std::size_t i) {
        tau[i] = K::step_torque(law, slot, theta.data(), in[static_cast<std::size_t>(slot.joint)],
                                dt, z.data());
      },
      [&]<int N, class Law>(const Law& law, const LawSlot* slots, std::size_t i) {
        auto joints = K::template gather<Law, N>(slots, theta.data(), in, z.data());
        const auto found = law.step_torque(joints.theta.data(), joints.in, dt, &joints.z);
        K::scatter_state(slots, joints.z, z.data());
        K::scatter_torque(found, &tau[i]);
      },
      [&](const LawSlot* slots, std::size_t size) {
        K::add_modified(slots, size, theta.data(), in, tau, tau_f);
      });
  Kernels<S>::visit_whole(whole_slot_, [&](const auto law) {
    law.step(theta.data() + whole_slot_.theta, in.data(), dt, z.data() + whole_slot_.z);
    law.add_torque(theta.data() + whole_slot_.theta, in.data(), z.data() + whole_slot_.z,
                   tau_f.data());
  });
}

template <class S>
void RobotFriction::steady_torque(std::span<const S> theta, std::span<const Input<S>> in,
                                  std::span<S> tau_f) const {
  assert(static_cast<int>(theta.size()) == parameter_count() &&
         static_cast<int>(in.size()) == joint_count() && tau_f.size() == in.size());
  std::fill(tau_f.begin(), tau_f.end(), S(0));
  using K = Kernels<S>;
  typename K::RunTorque tau;
  K::for_each(
      *this,
      [&](const auto& law, const LawSlot& slot, std::size_t i) {
        tau[i] =
            law.steady_torque(theta.data() + slot.theta, in[static_cast<std::size_t>(slot.joint)]);
      },
      [&]<int N, class Law>(const Law& law, const LawSlot* slots, std::size_t i) {
        for (std::size_t k = 0; k < N; ++k)
          tau[i + k] = law.steady_torque(theta.data() + slots[k].theta,
                                         in[static_cast<std::size_t>(slots[k].joint)]);
      },
      [&](const LawSlot* slots, std::size_t size) {
        K::add_modified(slots, size, theta.data(), in, tau, tau_f);
      });
  Kernels<S>::visit_whole(whole_slot_, [&](const auto law) {
    law.add_steady_torque(theta.data() + whole_slot_.theta, in.data(), tau_f.data());
  });
}

template <class S>
void RobotFriction::torque_pullback(std::span<const S> theta, std::span<const Input<S>> in,
                                    std::span<const S> z, std::span<const S> tau_f_bar,
                                    std::span<S> theta_bar, std::span<Input<S>> in_bar,
                                    std::span<S> z_bar) const {
  assert(theta_bar.size() == theta.size() && z_bar.size() == z.size() &&
         in_bar.size() == in.size() && tau_f_bar.size() == in.size());
  Kernels<S>::for_each(*this, [&](const auto& law, const LawSlot& slot, std::size_t j) {
    Kernels<S>::torque_pullback(law, slot, theta.data(), in[j], z.data(), tau_f_bar[j],
                                theta_bar.data(), in_bar[j], z_bar.data());
  });
  Kernels<S>::visit_whole(whole_slot_, [&](const auto law) {
    law.torque_pullback(theta.data() + whole_slot_.theta, in.data(), z.data() + whole_slot_.z,
                        tau_f_bar.data(), theta_bar.data() + whole_slot_.theta, in_bar.data(),
                        z_bar.data() + whole_slot_.z);
  });
}

template <class S>
void RobotFriction::step_pullback(std::span<const S> theta, std::span<const Input<S>> in, double dt,
                                  std::span<const S> z, std::span<const S> z_next_bar,
                                  std::span<S> theta_bar, std::span<Input<S>> in_bar,
                                  std::span<S> z_bar) const {
  assert(theta_bar.size() == theta.size() && z_bar.size() == z.size() &&
         in_bar.size() == in.size() && z_next_bar.size() == z.size());
  Kernels<S>::for_each(*this, [&](const auto& law, const LawSlot& slot, std::size_t j) {
    Kernels<S>::step_pullback(law, slot, theta.data(), in[j], dt, z.data(), z_next_bar.data(),
                              theta_bar.data(), in_bar[j], z_bar.data());
  });
  Kernels<S>::visit_whole(whole_slot_, [&](const auto law) {
    law.step_pullback(theta.data() + whole_slot_.theta, in.data(), dt, z.data() + whole_slot_.z,
                      z_next_bar.data() + whole_slot_.z, theta_bar.data() + whole_slot_.theta,
                      in_bar.data(), z_bar.data() + whole_slot_.z);
  });
}

/// Instantiates all templates of RobotFriction for one scalar type.
#define FRICID_INSTANTIATE_FRICTION(S)                                                         \
  template void RobotFriction::torque<S>(std::span<const S>, std::span<const Input<S>>,        \
                                         std::span<const S>, std::span<S>) const;              \
  template void RobotFriction::step<S>(std::span<const S>, std::span<const Input<S>>, double,  \
                                       std::span<S>) const;                                    \
  template void RobotFriction::step_torque<S>(std::span<const S>, std::span<const Input<S>>,   \
                                              double, std::span<S>, std::span<S>) const;       \
  template void RobotFriction::steady_torque<S>(std::span<const S>, std::span<const Input<S>>, \
                                                std::span<S>) const;                           \
  template void RobotFriction::torque_pullback<S>(                                             \
      std::span<const S>, std::span<const Input<S>>, std::span<const S>, std::span<const S>,   \
      std::span<S>, std::span<Input<S>>, std::span<S>) const;                                  \
  template void RobotFriction::step_pullback<S>(                                               \
      std::span<const S>, std::span<const Input<S>>, double, std::span<const S>,               \
      std::span<const S>, std::span<S>, std::span<Input<S>>, std::span<S>) const;

}  // namespace fricid::friction
