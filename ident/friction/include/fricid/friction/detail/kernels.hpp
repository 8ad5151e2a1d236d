// Definitions of the templates of RobotFriction, for the sources that instantiate them: double,
// PackD and PackF in the library, dual numbers in the tests.
#pragma once

#include <array>
#include <cassert>

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

  // Applies the torque modifiers and keeps what each has seen; returns the last.
  static S modify(const Slot& slot, const S* theta, const Input<S>& in, const S& tau,
                  Stages& stages) {
    stages[0] = tau;
    std::size_t k = 0;
    for (const auto& m : slot.torque_modifiers) {
      visit_entry<Modifiers>(m.kind, m.order, [&](const auto modifier) {
        if constexpr (TorqueModifier<std::remove_cvref_t<decltype(modifier)>>)
          stages[k + 1] = modifier.apply(theta + m.theta, in, stages[k]);
      });
      ++k;
    }
    return stages[k];
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

  static Input<S> seen(const auto& law, const Slot& slot, const S* theta, const Input<S>& in,
                       const S* z) {
    if (slot.backlash.kind < 0) return in;
    return Backlash::seen(law, theta + slot.theta, theta + slot.backlash.theta, in, z + slot.z,
                          z[slot.backlash.z]);
  }

  // Adds the torque of one law to tau_f.
  static void add_torque(const Slot& slot, const S* theta, const Input<S>& in, const S* z,
                         S& tau_f) {
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      const S tau = law.torque(theta + slot.theta, seen(law, slot, theta, in, z), z + slot.z);
      if (slot.torque_modifiers.empty()) {
        tau_f += tau;
        return;
      }
      Stages stages;
      tau_f += modify(slot, theta, in, tau, stages);
    });
  }

  static void step(const Slot& slot, const S* theta, const Input<S>& in, double dt, S* z) {
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      if (slot.backlash.kind < 0)
        law.step(theta + slot.theta, in, dt, z + slot.z);
      else
        Backlash::step(law, theta + slot.theta, theta + slot.backlash.theta, in, dt, z + slot.z,
                       z[slot.backlash.z]);
    });
  }

  // Steps one law, then adds its torque to tau_f.
  static void step_add_torque(const Slot& slot, const S* theta, const Input<S>& in, double dt, S* z,
                              S& tau_f) {
    bool shared = false;
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      if constexpr (SharedStepLaw<std::remove_cvref_t<decltype(law)>, S>) {
        shared = slot.backlash.kind < 0;
        if (!shared) return;
        const S tau = law.step_torque(theta + slot.theta, in, dt, z + slot.z);
        Stages stages;
        tau_f += modify(slot, theta, in, tau, stages);
      }
    });
    if (shared) return;
    step(slot, theta, in, dt, z);
    add_torque(slot, theta, in, z, tau_f);
  }

  static void add_steady_torque(const Slot& slot, const S* theta, const Input<S>& in, S& tau_f) {
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      Stages stages;
      tau_f += modify(slot, theta, in, law.steady_torque(theta + slot.theta, in), stages);
    });
  }

  static void torque_pullback(const Slot& slot, const S* theta, const Input<S>& in, const S* z,
                              const S& tau_f_bar, S* theta_bar, Input<S>& in_bar, S* z_bar) {
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
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
    });
  }

  static void step_pullback(const Slot& slot, const S* theta, const Input<S>& in, double dt,
                            const S* z, const S* z_next_bar, S* theta_bar, Input<S>& in_bar,
                            S* z_bar) {
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      const auto& gap = slot.backlash;
      if (gap.kind < 0)
        law.step_pullback(theta + slot.theta, in, dt, z + slot.z, z_next_bar + slot.z,
                          theta_bar + slot.theta, in_bar, z_bar + slot.z);
      else
        Backlash::step_pullback(law, theta + slot.theta, theta + gap.theta, in, dt, z + slot.z,
                                z[gap.z], z_next_bar + slot.z, z_next_bar[gap.z],
                                theta_bar + slot.theta, theta_bar + gap.theta, in_bar,
                                z_bar + slot.z, z_bar[gap.z]);
    });
  }

  static std::span<const Slot> slots(const RobotFriction& model) { return model.slots_; }

  // tau_f (n): what add(slot, j, sum) adds up over the slots of each joint.
  template <class Add>
  static void sum_per_joint(std::span<const Slot> slots, std::span<S> tau_f, Add&& add) {
    auto slot = slots.begin();  // sorted by joint
    for (std::size_t j = 0; j < tau_f.size(); ++j) {
      S sum = S(0);
      for (; slot != slots.end() && slot->joint == static_cast<int>(j); ++slot) add(*slot, j, sum);
      tau_f[j] = sum;
    }
  }

  // Calls f(law) where there is a law of the whole robot.
  template <class F>
  static void visit_whole(const RobotFriction::RobotLawSlot& slot, F&& f) {
    if (slot.kind >= 0) visit_robot_law(slot.kind, slot.joints, slot.elements, f);
  }
};

template <class S>
void RobotFriction::torque(std::span<const S> theta, std::span<const Input<S>> in,
                           std::span<const S> z, std::span<S> tau_f) const {
  assert(static_cast<int>(theta.size()) == parameter_count() &&
         static_cast<int>(z.size()) == state_size() &&
         static_cast<int>(in.size()) == joint_count() && tau_f.size() == in.size());
  Kernels<S>::sum_per_joint(slots_, tau_f, [&](const LawSlot& slot, std::size_t j, S& sum) {
    Kernels<S>::add_torque(slot, theta.data(), in[j], z.data(), sum);
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
  for (const LawSlot& slot : slots_)
    Kernels<S>::step(slot, theta.data(), in[static_cast<std::size_t>(slot.joint)], dt, z.data());
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
  Kernels<S>::sum_per_joint(slots_, tau_f, [&](const LawSlot& slot, std::size_t j, S& sum) {
    Kernels<S>::step_add_torque(slot, theta.data(), in[j], dt, z.data(), sum);
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
  Kernels<S>::sum_per_joint(slots_, tau_f, [&](const LawSlot& slot, std::size_t j, S& sum) {
    Kernels<S>::add_steady_torque(slot, theta.data(), in[j], sum);
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
  for (const LawSlot& slot : slots_) {
    const auto j = static_cast<std::size_t>(slot.joint);
    Kernels<S>::torque_pullback(slot, theta.data(), in[j], z.data(), tau_f_bar[j], theta_bar.data(),
                                in_bar[j], z_bar.data());
  }
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
  for (const LawSlot& slot : slots_) {
    const auto j = static_cast<std::size_t>(slot.joint);
    Kernels<S>::step_pullback(slot, theta.data(), in[j], dt, z.data(), z_next_bar.data(),
                              theta_bar.data(), in_bar[j], z_bar.data());
  }
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
