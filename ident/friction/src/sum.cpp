#include "fricid/friction/sum.hpp"

#include <algorithm>
#include <utility>

namespace fricid::friction {

JointSpec lvm_sum(const LvmParts& parts) {
  const auto warm_and_directed = [&](LawSpec law) {
    if (parts.temperature) law.modifiers.push_back({"temperature", 1});
    if (parts.asymmetry) law.modifiers.push_back({"asymmetry", 1});
    return law;
  };
  LawSpec memory{"gms", parts.elements, {}};
  if (parts.memory == Memory::kBristle) memory = {"lugre", 0, {}};
  if (parts.memory == Memory::kNone) memory = {"stribeck", 0, {}};
  if (parts.load) memory.modifiers.push_back({parts.gear_load ? "gear_load" : "load", 1});
  if (parts.ripples > 0) memory.modifiers.push_back({"ripple", parts.ripples});
  memory = warm_and_directed(std::move(memory));
  if (parts.backlash) memory.modifiers.push_back({"backlash", 1});
  JointSpec joint;
  joint.laws.push_back(std::move(memory));
  const auto viscous = [&](const char* law) {
    LawSpec spec{law, 0, {}};
    if (parts.loaded_viscous) spec.modifiers.push_back({"load", 1});
    joint.laws.push_back(warm_and_directed(std::move(spec)));
  };
  viscous("viscous_power");
  if (parts.viscous && !parts.inner_viscous) viscous("viscous");
  const auto further = [&](LawSpec law) {
    joint.laws.push_back(parts.further_modifiers ? warm_and_directed(std::move(law)) : law);
  };
  if (parts.power_flow) further({"load_dependent", 0, {}});
  if (parts.stribeck) {
    LawSpec peak{"stribeck_peak", 0, {}};
    if (parts.loaded_stribeck) peak.modifiers.push_back({"load", 1});
    if (parts.temperature && !parts.further_modifiers) peak.modifiers.push_back({"temperature", 1});
    further(std::move(peak));
  }
  if (parts.cable) further({"maxwell_slip", 1, {}});
  if (parts.network > 0)
    joint.laws.push_back(warm_and_directed({"memory_network", parts.network, {}}));
  return joint;
}

void set(LvmParts& parts, SumPart part, bool on) {
  switch (part) {
    case SumPart::kBristle:
    case SumPart::kMemoryless: {
      const Memory memory = part == SumPart::kBristle ? Memory::kBristle : Memory::kNone;
      if (on && memory == Memory::kNone) set(parts, SumPart::kStribeck, false);
      if (on)
        parts.memory = memory;
      else if (parts.memory == memory)
        parts.memory = Memory::kBank;
      return;
    }
    case SumPart::kBacklash:
      parts.backlash = on;
      return;
    case SumPart::kLoad:
      parts.load = on;
      parts.gear_load = parts.gear_load && on;
      return;
    case SumPart::kGearLoad:
      parts.load = parts.load || on;
      parts.gear_load = on;
      return;
    case SumPart::kPowerFlow:
      parts.power_flow = on;
      return;
    case SumPart::kAsymmetry:
      parts.asymmetry = on;
      return;
    case SumPart::kRipple:
      parts.ripples = on ? std::max(parts.ripples, 1) : 0;
      return;
    case SumPart::kSecondRipple:
      parts.ripples = on ? std::max(parts.ripples, 2) : std::min(parts.ripples, 1);
      return;
    case SumPart::kThirdRipple:
      parts.ripples = on ? 3 : std::min(parts.ripples, 2);
      return;
    case SumPart::kTemperature:
      parts.temperature = on;
      return;
    case SumPart::kViscous:
      parts.viscous = on || parts.inner_viscous;
      return;
    case SumPart::kInnerViscous:
      parts.inner_viscous = on;
      return;
    case SumPart::kLoadedViscous:
      parts.loaded_viscous = on;
      parts.inner_viscous = parts.inner_viscous && !on;
      return;
    case SumPart::kLoadedStribeck:
      if (on) set(parts, SumPart::kStribeck, true);
      parts.loaded_stribeck = on;
      return;
    case SumPart::kStribeck:
      if (on) set(parts, SumPart::kMemoryless, false);
      parts.stribeck = on;
      parts.loaded_stribeck = parts.loaded_stribeck && on;
      return;
    case SumPart::kFurtherModifiers:
      parts.further_modifiers = on;
      return;
    case SumPart::kCable:
      parts.cable = on;
      return;
    case SumPart::kNetwork:
      parts.network = on ? kNetworkUnits : 0;
      return;
  }
}

}  // namespace fricid::friction
