// The role of a parameter: starting values, bounds, reports and plots depend on it, never on the
// symbol or unit.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace fricid::friction {

/// Physical meaning of a parameter of a law or modifier. Its unit is that of the role, see
/// role_unit.
enum class Role {
  kNone,  ///< none stated; the law suite refuses it
  // torque levels
  kCoulomb,        ///< torque of slow sliding, the size of a joint's friction
  kStatic,         ///< torque at which sliding begins
  kMemoryless,     ///< Coulomb torque of a law in parallel with its bristles
  kLevel,          ///< torque at which one element slides
  kNetworkTorque,  ///< scale of a network's torque
  // torque over speed
  kViscous,
  kPowerViscous,      ///< torque at 1 rad/s of a power law
  kExponent,          ///< of a power law
  kStribeckVelocity,  ///< over which static falls to Coulomb friction
  kSmoothingSpeed,    ///< over which a step at v = 0 is smoothed
  // presliding
  kStiffness,
  kDamping,     ///< of a bristle
  kLength,      ///< travel over which a bristle settles
  kShare,       ///< of one element, relative to the sum of all
  kAttraction,  ///< rate at which a sliding element returns to the Stribeck curve
  kStiffening,  ///< relative growth of a stiffness with the deflection
  kLag,         ///< time by which friction lags behind speed
  // load
  kLoadCoefficient,  ///< torque per torque of load
  kLoadGrowth,       ///< relative growth per torque of load
  kLoadSmoothing,    ///< over which |load| is smoothed
  kMotorViscous,     ///< viscous friction that the load does not contain
  // temperature, direction, angle, play
  kTemperatureCoefficient,
  kTemperature,
  kAsymmetry,
  kWaveNumber,  ///< of a wave over the joint angle; its amplitude and phase follow it
  kAmplitude,
  kPhase,
  kGap,
  // networks
  kSpeedScale,
  kSaturationSpeed,  ///< at which an input of a network saturates
  kLoadScale,
  kPositionMean,
  kPositionScale,
  kTorqueScale,
  kSampleTime,
  kWeight,
  kOutputWeight,  ///< of a unit in the output of a network that is pulled towards zero
  kCrossWeights,  ///< 1 where weights between joints act, 0 where there are none
  kCount
};

namespace detail {
inline constexpr auto kRoleUnits = [] {
  std::array<std::string_view, static_cast<std::size_t>(Role::kCount)> unit{};
  const auto set = [&](std::string_view text, auto... roles) {
    ((unit[static_cast<std::size_t>(roles)] = text), ...);
  };
  using enum Role;
  set("N m", kCoulomb, kStatic, kMemoryless, kLevel, kNetworkTorque, kLoadSmoothing, kLoadScale,
      kTorqueScale);
  set("N m s/rad", kViscous, kDamping, kMotorViscous);
  set("N m (s/rad)^p", kPowerViscous);
  set("N m/rad", kStiffness);
  set("N m/s", kAttraction);
  set("rad/s", kStribeckVelocity, kSmoothingSpeed, kSpeedScale, kSaturationSpeed);
  set("rad", kLength, kPhase, kGap, kPositionMean, kPositionScale);
  set("1/rad", kWaveNumber);
  set("1/(N m)", kLoadGrowth);
  set("1/K", kTemperatureCoefficient);
  set("K", kTemperature);
  set("s", kLag, kSampleTime);
  set("1", kExponent, kShare, kStiffening, kLoadCoefficient, kAsymmetry, kAmplitude, kWeight,
      kOutputWeight, kCrossWeights);
  return unit;
}();
}  // namespace detail

/// Unit of the parameters of a role; empty for kNone.
constexpr std::string_view role_unit(Role role) {
  return detail::kRoleUnits[static_cast<std::size_t>(role)];
}

/// Whether a parameter of the role is a weight of a network.
constexpr bool is_weight(Role role) { return role == Role::kWeight || role == Role::kOutputWeight; }

/// Whether a parameter of the role grows with the size of a joint: a torque, or a torque per unit
/// of something.
constexpr bool is_torque(Role role) { return role_unit(role).starts_with("N m"); }

}  // namespace fricid::friction
