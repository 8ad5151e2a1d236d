#include "fricid/friction/sum.hpp"

#include <algorithm>
#include <utility>

namespace fricid::friction {

namespace {

void set_springs(LvmParts& parts, int springs, bool on) {
  if (on) parts.memory = Memory::kBank;
  if (parts.memory != Memory::kBank) return;
  if (on)
    parts.elements = std::max(parts.elements, springs);
  else if (parts.elements <= springs)
    parts.elements = std::min(parts.elements, springs / 2);
}

}  // namespace

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

LvmParts parts_of(const Friction& friction, int joint) {
  const std::vector<LawSpec>& laws = friction.model.joints()[static_cast<std::size_t>(joint)].laws;
  const auto law = [&](std::string_view name) {
    const auto found = std::ranges::find(laws, name, &LawSpec::law);
    return found == laws.end() ? nullptr : &*found;
  };
  const auto modifier = [](const LawSpec* of, std::string_view name) {
    if (!of) return 0;
    const auto found = std::ranges::find(of->modifiers, name, &ModifierSpec::name);
    return found == of->modifiers.end() ? 0 : found->order;
  };
  const LawSpec &memory = laws.front(), *const viscous = law("viscous"),
                *const peak = law("stribeck_peak"), *const network = law("memory_network");
  LvmParts parts;
  parts.memory = memory.law == "lugre"      ? Memory::kBristle
                 : memory.law == "stribeck" ? Memory::kNone
                                            : Memory::kBank;
  parts.elements = memory.elements;
  parts.temperature = modifier(&memory, "temperature") > 0;
  parts.gear_load = modifier(&memory, "gear_load") > 0;
  parts.load = parts.gear_load || modifier(&memory, "load") > 0;
  parts.power_flow = law("load_dependent") != nullptr;
  parts.asymmetry = modifier(&memory, "asymmetry") > 0;
  parts.ripples = modifier(&memory, "ripple");
  const int inner = find_parameter(friction.model, joint, Role::kViscous);
  parts.inner_viscous =
      !viscous && inner >= 0 && friction.theta[static_cast<std::size_t>(inner)] != 0;
  parts.viscous = viscous || parts.inner_viscous;
  parts.loaded_viscous = modifier(law("viscous_power"), "load") > 0;
  parts.stribeck = peak != nullptr;
  parts.loaded_stribeck = modifier(peak, "load") > 0;
  parts.further_modifiers = modifier(peak, "asymmetry") > 0 ||
                            modifier(law("load_dependent"), "temperature") > 0 ||
                            modifier(law("load_dependent"), "asymmetry") > 0 ||
                            modifier(law("maxwell_slip"), "temperature") > 0 ||
                            modifier(law("maxwell_slip"), "asymmetry") > 0;
  parts.backlash = modifier(&memory, "backlash") > 0;
  parts.cable = law("maxwell_slip") != nullptr;
  parts.network = network ? network->elements : 0;
  return parts;
}

bool has(LvmParts parts, SumPart part) {
  const LvmParts before = parts;
  set(parts, part, true);
  return parts == before;
}

void set(LvmParts& parts, SumPart part, bool on) {
  switch (part) {
    case SumPart::kTwoSprings:
      return set_springs(parts, 2, on);
    case SumPart::kFourSprings:
      return set_springs(parts, 4, on);
    case SumPart::kEightSprings:
      return set_springs(parts, 8, on);
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
