// Sums of laws with a name.
#pragma once

#include <string_view>

#include "fricid/base/enum_names.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::friction {

/// Name of the model that contains the laws, see `lvm_sum`.
inline constexpr std::string_view kLvm = "lvm";

/// The hysteretic part of the sum.
enum class Memory {
  kBank,     ///< gms: springs that slip one after the other
  kBristle,  ///< lugre: one bristle that yields smoothly
  kNone      ///< stribeck: none
};

/// Units of the network of a joint.
inline constexpr int kNetworkUnits = 8;

/// Parts of `lvm_sum`.
struct LvmParts {
  Memory memory = Memory::kBank;
  int elements = 8;                ///< of the bank
  bool temperature = false;        ///< of the memory, viscous torque and Stribeck part
  bool load = true;                ///< modifier of the memory
  bool gear_load = false;          ///< of what the gear hands on, instead of the motor's torque
  bool power_flow = true;          ///< load, differently when motoring and when back-driving
  bool asymmetry = true;           ///< of the memory and viscous torque
  int ripples = 1;                 ///< waves over the joint angle, of the memory
  bool viscous = true;             ///< linear viscous torque beside that of a power
  bool inner_viscous = false;      ///< the linear one under the memory's modifiers, not beside it
  bool loaded_viscous = false;     ///< load as a modifier of the viscous torques beside the memory
  bool stribeck = false;           ///< a Stribeck torque of the speed alone, beside the memory
  bool loaded_stribeck = false;    ///< load as a modifier of it
  bool further_modifiers = false;  ///< both of the load part, the Stribeck part and the cable too
  bool backlash = false;           ///< a gap before the memory
  bool cable = false;              ///< a soft spring that slips late, beside the memory
  int network = 0;                 ///< units of the network for what the laws leave; 0: none

  bool operator==(const LvmParts&) const = default;
};

/// What of `LvmParts` the data decide.
enum class SumPart {
  kTwoSprings,
  kFourSprings,
  kEightSprings,
  kBristle,
  kMemoryless,
  kBacklash,
  kLoad,
  kGearLoad,
  kPowerFlow,
  kAsymmetry,
  kRipple,
  kSecondRipple,
  kThirdRipple,
  kTemperature,
  kViscous,
  kInnerViscous,
  kLoadedViscous,
  kStribeck,
  kLoadedStribeck,
  kFurtherModifiers,
  kCable,
  kNetwork
};
constexpr std::string_view names(SumPart) {
  return "two_springs|four_springs|eight_springs|bristle|memoryless|backlash|load|gear_load|power_"
         "flow|asymmetry|ripple|second_ripple|"
         "third_ripple|"
         "temperature|"
         "viscous|inner_viscous|loaded_viscous|stribeck|loaded_stribeck|further_modifiers|cable|"
         "network";
}
/// Switches a part on or off; kTwoSprings to kEightSprings: a bank of at least as many, off half as
/// many where it has no more; kBristle, kMemoryless: on in the place of another memory, off back to
/// the bank; friction without memory has a Stribeck torque of its own and none beside it; kNetwork:
/// of `kNetworkUnits`.
void set(LvmParts& parts, SumPart part, bool on);
bool has(LvmParts parts, SumPart part);

/// The friction of one joint in which the laws of the table are special cases:
///
///     tau = memory + viscous torque + load part + Stribeck part + cable + network
///
///     memory          gms with `elements` springs, lugre or stribeck {load, ripple, temperature,
///     asymmetry,
///                     backlash}; gear_load instead of load with `gear_load`
///     viscous torque  viscous_power and, with `viscous`, viscous, each {load, temperature,
///                     asymmetry}; the linear one in the memory instead of beside it with
///                     `inner_viscous`
///     load part       load_dependent
///     Stribeck part   stribeck_peak {load, temperature}, which waits for no spring as that of the
///                     memory does
///     cable           maxwell_slip with one spring, of cables and hoses that a joint bends;
///                     these three {temperature, asymmetry} with `further_modifiers`
///     network         memory_network {temperature, asymmetry}, for what the laws leave
///
/// Only the memory and the cable are to have Coulomb friction and only one law linear viscous
/// friction, none without `viscous`: the caller keeps these parameters of the other laws at their
/// lower bounds. Maxwell slip is the bank with Fs = Fc, Coulomb friction its limit of short
/// springs; GMS and LuGre remain without the other parts.
JointSpec lvm_sum(const LvmParts& parts);

/// What a joint has of `lvm_sum`, whatever its laws. Linear viscous friction of the memory counts
/// as inner where it is not zero.
LvmParts parts_of(const Friction& friction, int joint);

}  // namespace fricid::friction
