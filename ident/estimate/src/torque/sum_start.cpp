#include "fricid/estimate/torque/sum_start.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fricid::estimate {
namespace {

using friction::Role;

constexpr double kStatic = 1.03;                       // Fs / Fc
constexpr double kStribeckSpeed = 0.06;                // [rad/s]
constexpr double kSlowest = 0.02, kFastest = 0.5;      // of the Stribeck velocity [rad/s]
constexpr double kAttraction = 30;                     // C / Fc [1/s]
constexpr double kSlowReturn = 5, kFastReturn = 300;   // bounds of C / Fc [1/s]
constexpr double kShortest = 1.5e-4, kLongest = 8e-3;  // lengths of the bank [rad]
constexpr double kCorner = 0.01, kLoadCorner = 0.03;  // v0 of the viscous and the load part [rad/s]
constexpr double kLoadFoot = 0.3;                     // l0 [N m]
constexpr double kLoadShare = 0.02;      // of the friction that load is taken to make at first
constexpr double kPowerFlow = 0.002;     // mu at first
constexpr double kBristleLength = 1e-3;  // [rad]

double start_value(const friction::ParameterRef& p, const friction::LvmParts& parts,
                   const friction::FrictionGuess& guess, double load, double temperature) {
  const bool of_memory = p.law == 0;
  switch (p.info.role) {
    case Role::kCoulomb:
      return of_memory ? guess.Fc : p.info.lower;
    case Role::kStatic:
      return kStatic * guess.Fc;
    case Role::kStribeckVelocity:
      return kStribeckSpeed;
    case Role::kAttraction:
      return kAttraction * guess.Fc;
    case Role::kViscous:
      return p.owner == "coulomb_viscous" ? 0.5 * guess.Fv : 0;
    case Role::kPowerViscous:
      return 0.5 * guess.Fv;
    case Role::kExponent:
      return 0.6;
    case Role::kDamping:
      return 0;
    case Role::kShare:
      return 1.0 / parts.elements;
    case Role::kStiffness: {
      if (parts.memory == friction::Memory::kBristle) return guess.Fc / kBristleLength;
      const double at = parts.elements == 1
                            ? 0.5
                            : static_cast<double>(p.info.element - 1) / (parts.elements - 1);
      const double length = kShortest * std::pow(kLongest / kShortest, at);
      return kStatic * guess.Fc / parts.elements / length;
    }
    case Role::kSmoothingSpeed:
      return p.owner == "load_dependent" ? kLoadCorner : kCorner;
    case Role::kLoadSmoothing:
      return kLoadFoot;
    case Role::kLoadCoefficient:
      return kPowerFlow;
    case Role::kLoadGrowth:
      return p.owner == "load" ? kLoadShare / std::max(load, 1e-3) : 0;
    case Role::kTemperature:
      return temperature;
    case Role::kTemperatureCoefficient:
    case Role::kAsymmetry:
    case Role::kAmplitude:
      return 0;
    default:
      return p.info.typical;
  }
}

}  // namespace

Arm start_sum(const Arm& arm, const std::vector<friction::LvmParts>& parts, const SumStart& start) {
  std::vector<friction::JointSpec> joints;
  for (const friction::LvmParts& of_joint : parts) joints.push_back(friction::lvm_sum(of_joint));
  Arm out = arm;
  out.friction.model = friction::RobotFriction(std::move(joints));
  out.friction.theta.clear();
  for (const friction::ParameterRef& p : out.friction.model.parameters()) {
    const auto j = static_cast<std::size_t>(p.joint);
    out.friction.theta.push_back(
        std::clamp(start_value(p, parts[j], start.joints[j], start.load[j], start.temperature),
                   p.info.lower, p.info.upper));
  }
  return out;
}

std::vector<Limit> sum_limits(const friction::Friction& friction) {
  const friction::RobotFriction& model = friction.model;
  std::vector<Limit> limits;
  for (std::size_t i = 0; i < model.parameters().size(); ++i) {
    const friction::ParameterRef& p = model.parameters()[i];
    if (p.joint == friction::kWholeRobot) continue;
    const auto& laws = model.joints()[static_cast<std::size_t>(p.joint)].laws;
    const bool sum = laws.size() > 1;
    const bool beside = sum && p.law > 0;
    const bool linear_beside =
        sum && std::ranges::count(laws, "coulomb_viscous", &friction::LawSpec::law) > 0;
    const double value = friction.theta[i];
    const bool held =
        p.info.role == Role::kSmoothingSpeed || p.info.role == Role::kLoadSmoothing ||
        p.info.role == Role::kTemperature || (p.info.role == Role::kCoulomb && beside) ||
        (p.info.role == Role::kViscous && linear_beside && p.owner != "coulomb_viscous") ||
        (p.info.role == Role::kLoadGrowth && p.owner == "load_dependent" && beside);
    if (held) limits.push_back({i, value, value});
    if (p.info.role == Role::kStribeckVelocity)
      limits.push_back({i, std::min(kSlowest, value), std::max(kFastest, value)});
    if (p.info.role == Role::kAttraction) {
      const double Fc = friction.theta[static_cast<std::size_t>(
          friction::find_parameter(model, p.joint, Role::kCoulomb))];
      limits.push_back({i, std::min(value, kSlowReturn * Fc), std::max(value, kFastReturn * Fc)});
    }
  }
  return limits;
}

}  // namespace fricid::estimate
