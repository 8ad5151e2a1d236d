// The sum of laws: what of it is which law, to the last digits.
#include "fricid/friction/sum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace fricid::friction {
namespace {

/// The sum with the memory's parameters those of `law`, everything beside it at zero.
Friction sum_of(const LvmParts& parts, const Friction& law) {
  Friction out{RobotFriction({lvm_sum(parts)}), {}};
  for (const ParameterRef& p : out.model.parameters()) {
    const int same = find_parameter(law.model, 0, p.owner, p.symbol);
    const bool memory = p.law == 0 && same >= 0;
    const bool structure = p.info.role == Role::kSmoothingSpeed ||
                           p.info.role == Role::kLoadSmoothing || p.info.role == Role::kExponent ||
                           p.info.role == Role::kTemperature || p.info.role == Role::kWaveNumber ||
                           p.info.role == Role::kNetworkTorque || p.info.role == Role::kLag ||
                           p.info.role == Role::kLength || p.info.role == Role::kSaturationSpeed;
    out.theta.push_back(memory      ? law.theta[static_cast<std::size_t>(same)]
                        : structure ? p.info.typical
                                    : 0);
  }
  return out;
}

/// Largest difference of the torques along a motion with reversals, at changing load and grease.
double largest_difference(const Friction& a, const Friction& b) {
  std::vector<double> za(static_cast<std::size_t>(a.model.state_size()), 0.0),
      zb(static_cast<std::size_t>(b.model.state_size()), 0.0);
  double largest = 0;
  for (int k = 0; k < 2000; ++k) {
    const double t = 0.004 * k;
    const Input<double> in{std::sin(t), std::cos(3 * t) * std::cos(t), 30 * std::sin(2 * t),
                           293 + 5 * t};
    double tau_a = 0, tau_b = 0;
    a.model.step_torque<double>(a.theta, {&in, 1}, 0.004, za, {&tau_a, 1});
    b.model.step_torque<double>(b.theta, {&in, 1}, 0.004, zb, {&tau_b, 1});
    largest = std::max(largest, std::abs(tau_a - tau_b));
  }
  return largest;
}

TEST(LvmSum, WithoutTheOtherPartsIsTheLawOfItsMemory) {
  const std::pair<Memory, LawSpec> laws[] = {{Memory::kBank, {"gms", 4, {}}},
                                             {Memory::kBristle, {"lugre", 0, {}}},
                                             {Memory::kNone, {"stribeck", 0, {}}}};
  for (const auto& [memory, spec] : laws) {
    const LvmParts parts{
        .memory = memory, .elements = 4, .temperature = true, .ripples = 2, .network = 3};
    Friction law{RobotFriction({JointSpec{{spec}}}), {}};
    law.theta = default_theta(law.model);
    EXPECT_LT(largest_difference(sum_of(parts, law), law), 1e-12) << spec.law;
    law.theta[0] *= 1.01;
    Friction other = law;
    other.theta[0] /= 1.01;
    EXPECT_GT(largest_difference(sum_of(parts, law), other), 1e-3);
  }
}

TEST(LvmSum, HasThePartsItIsAskedFor) {
  const auto owners = [](const LvmParts& parts) {
    std::string text;
    for (const LawSpec& law : lvm_sum(parts).laws) {
      text += law.law + ":";
      for (const ModifierSpec& m : law.modifiers) text += m.name.substr(0, 1);
      text += " ";
    }
    return text;
  };
  EXPECT_EQ(owners({.temperature = true, .backlash = true}),
            "gms:lrtab viscous_power:ta viscous:ta load_dependent: ");
  EXPECT_EQ(owners({.memory = Memory::kBristle,
                    .load = false,
                    .power_flow = false,
                    .asymmetry = false,
                    .ripples = 0}),
            "lugre: viscous_power: viscous: ");
  EXPECT_EQ(owners({.asymmetry = false, .ripples = 0, .stribeck = true, .cable = true}),
            "gms:l viscous_power: viscous: load_dependent: stribeck_peak: maxwell_slip: ");
  EXPECT_EQ(owners({.temperature = true,
                    .ripples = 0,
                    .stribeck = true,
                    .loaded_stribeck = true,
                    .further_modifiers = true,
                    .cable = true}),
            "gms:lta viscous_power:ta viscous:ta load_dependent:ta stribeck_peak:lta "
            "maxwell_slip:ta ");
  EXPECT_EQ(owners({.memory = Memory::kNone, .load = false, .asymmetry = false, .network = 8}),
            "stribeck:r viscous_power: viscous: load_dependent: memory_network: ");
}

TEST(LvmSum, IsToldFromItsLaws) {
  const LvmParts of[] = {
      {},
      {.temperature = true, .load = false, .power_flow = false, .asymmetry = false, .ripples = 3},
      {.memory = Memory::kBristle, .elements = 0, .gear_load = true, .inner_viscous = true},
      {.memory = Memory::kNone, .elements = 0, .backlash = true, .network = 8},
      {.viscous = false, .stribeck = true, .loaded_stribeck = true, .cable = true},
      {.loaded_viscous = true, .stribeck = true, .further_modifiers = true},
  };
  for (const LvmParts& parts : of) {
    Friction friction{RobotFriction({lvm_sum(parts)}), {}};
    friction.theta = default_theta(friction.model);
    if (!parts.inner_viscous)
      friction.theta[static_cast<std::size_t>(find_parameter(friction.model, 0, Role::kViscous))] =
          0;
    EXPECT_EQ(parts_of(friction, 0), parts) << lvm_sum(parts).laws.size();
  }
  const Friction rival{RobotFriction({JointSpec{{{"dahl", 0, {}}}}}), {5, 3000, 0}};
  const LvmParts none = parts_of(rival, 0);
  for (const SumPart part : {SumPart::kBristle, SumPart::kMemoryless, SumPart::kLoad,
                             SumPart::kRipple, SumPart::kViscous, SumPart::kNetwork})
    EXPECT_FALSE(has(none, part)) << name_of(part);
}

TEST(LvmSum, HasOneStribeckTorqueWithoutMemory) {
  LvmParts parts{.stribeck = true, .loaded_stribeck = true};
  set(parts, SumPart::kMemoryless, true);
  EXPECT_TRUE(parts.memory == Memory::kNone && !parts.stribeck && !parts.loaded_stribeck);
  set(parts, SumPart::kBristle, false);
  EXPECT_EQ(parts.memory, Memory::kNone);
  set(parts, SumPart::kStribeck, true);
  EXPECT_EQ(parts.memory, Memory::kBank);
}

}  // namespace
}  // namespace fricid::friction
