#include "fricid/estimate/torque/sum_start.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "support.hpp"

namespace fricid::estimate {
namespace {

using friction::Role;

constexpr double kStatic = 1.03;                       // Fs / Fc
constexpr double kPeak = 0.1;                          // Ts / Fc
constexpr double kStribeckSpeed = 0.06;                // [rad/s]
constexpr double kSlowest = 0.005, kFastest = 0.5;     // of the Stribeck velocity [rad/s]
constexpr double kFastestBeside = 1;                   // of a law beside the memory
constexpr double kAttraction = 30;                     // C / Fc [1/s]
constexpr double kSlowReturn = 5, kFastReturn = 300;   // bounds of C / Fc [1/s]
constexpr double kShortest = 1.5e-4, kLongest = 8e-3;  // lengths of the bank [rad]
constexpr double kCorner = 0.01, kLoadCorner = 0.03;  // v0 of the viscous and the load part [rad/s]
constexpr double kLoadFoot = 0.3;                     // l0 [N m]
constexpr double kCornerRange = 4;                    // of both of the load part
constexpr double kLevelRange = 10;                    // .. of the corner of Coulomb friction
constexpr double kLoadShare = 0.02;      // of the friction that load is taken to make at first
constexpr double kPowerFlow = 0.002;     // mu at first
constexpr double kCurvature = 0.1;       // nu load / mu at first
constexpr double kMostLoss = 0.3;        // of the load in friction
constexpr double kBristleLength = 1e-3;  // [rad]
constexpr double kFirstGap = 1e-6;       // half of it [rad]
constexpr std::uint64_t kSeedOfNetworks = 1;

/// Of one joint: the laws that hold what several could, -1: none.
struct Holders {
  int coulomb = -1, viscous = -1;
};

/// Parameters of a role that stand beside `p`.
int count_in_joint(const friction::RobotFriction& model, const friction::ParameterRef& p,
                   Role role) {
  return static_cast<int>(std::ranges::count_if(model.parameters(), [&](const auto& other) {
    return other.joint == p.joint && other.info.role == role;
  }));
}
int count_in_law(const friction::RobotFriction& model, const friction::ParameterRef& p, Role role) {
  return static_cast<int>(std::ranges::count_if(model.parameters(), [&](const auto& other) {
    return other.joint == p.joint && other.law == p.law && other.owner == p.owner &&
           other.info.role == role;
  }));
}

/// Growth with the load is of the law of the load itself, or of a law that a modifier scales.
bool is_of_load_law(const friction::RobotFriction& model, const friction::ParameterRef& p) {
  return count_in_law(model, p, Role::kLoadCoefficient) > 0;
}

/// The smoothing speed of a law with static friction that stands beside a memory.
bool is_corner_of_static(const friction::RobotFriction& model, const friction::ParameterRef& p,
                         const Holders& holders) {
  return p.info.role == Role::kSmoothingSpeed && p.law != holders.coulomb &&
         count_in_law(model, p, Role::kStatic) > 0;
}

/// The smoothing speed of Coulomb friction without memory.
bool is_corner_of_level(const friction::RobotFriction& model, const friction::ParameterRef& p,
                        const Holders& holders) {
  return p.info.role == Role::kSmoothingSpeed && p.law == holders.coulomb &&
         count_in_law(model, p, Role::kStiffness) == 0;
}

bool is_load_corner(const friction::RobotFriction& model, const friction::ParameterRef& p) {
  return p.info.role == Role::kLoadSmoothing ||
         (p.info.role == Role::kSmoothingSpeed && is_of_load_law(model, p));
}

/// Of the law that `p` belongs to, in one level or several [N m]; 0: it has none.
double coulomb_friction(const friction::Friction& friction, const friction::ParameterRef& p) {
  double sum = 0;
  for (std::size_t i = 0; i < friction.theta.size(); ++i) {
    const friction::ParameterRef& other = friction.model.parameters()[i];
    if (other.joint == p.joint && other.law == p.law &&
        (other.info.role == Role::kCoulomb || other.info.role == Role::kLevel))
      sum += friction.theta[i];
  }
  return sum;
}

/// Coulomb friction is held by the law with springs, viscous friction by one without Coulomb
/// friction or, where there is none, by the first without memory that is not of the load.
std::vector<Holders> holders_of(const friction::RobotFriction& model) {
  std::vector<Holders> of(static_cast<std::size_t>(model.joint_count()));
  const auto first = [&](int& holder, const friction::ParameterRef& p, bool holds) {
    if (holder < 0 && holds) holder = p.law;
  };
  for (const int choice : {1, 2, 3})
    for (const friction::ParameterRef& p : model.parameters()) {
      if (p.joint == friction::kWholeRobot) continue;
      Holders& joint = of[static_cast<std::size_t>(p.joint)];
      const auto& law = model.joints()[static_cast<std::size_t>(p.joint)]
                            .laws[static_cast<std::size_t>(p.law)]
                            .law;
      const bool alone = count_in_law(model, p, Role::kCoulomb) == 0;
      const bool memoryless =
          count_in_law(model, p, Role::kSmoothingSpeed) > 0 && !is_of_load_law(model, p);
      first(joint.coulomb, p, p.info.role == (choice == 1 ? Role::kStiffness : Role::kCoulomb));
      first(joint.viscous, p,
            p.info.role == Role::kViscous && p.owner == law &&
                (alone || (choice > 1 && memoryless) || choice > 2));
    }
  return of;
}

/// Laws of a joint that have Coulomb friction of their own, in one level or several; what grows
/// with the load has that of the others.
int count_coulomb_laws(const friction::RobotFriction& model, int joint) {
  const auto& laws = model.joints()[static_cast<std::size_t>(joint)].laws;
  int count = 0;
  for (int law = 0; law < static_cast<int>(std::size(laws)); ++law)
    count += std::ranges::any_of(model.parameters(), [&](const friction::ParameterRef& p) {
      return p.joint == joint && p.law == law &&
             (p.info.role == Role::kCoulomb || p.info.role == Role::kLevel) &&
             !is_of_load_law(model, p);
    });
  return std::max(1, count);
}

double start_value(const friction::RobotFriction& model, const friction::ParameterRef& p,
                   const Holders& holders, const friction::FrictionGuess& guess, double load,
                   double temperature, double scale) {
  const auto in_law = [&](Role role) { return count_in_law(model, p, role); };
  switch (p.info.role) {
    case Role::kNetworkTorque:
      return guess.Fc;
    case Role::kCoulomb:
      return is_of_load_law(model, p) && p.law != holders.coulomb ? p.info.lower : guess.Fc;
    case Role::kStatic:
      return (in_law(Role::kCoulomb) > 0 ? kStatic : kPeak) * guess.Fc;
    case Role::kLevel:
      return guess.Fc / in_law(Role::kLevel);
    case Role::kStribeckVelocity:
      return kStribeckSpeed * scale;
    case Role::kAttraction:
      return kAttraction * guess.Fc;
    case Role::kViscous:
      if (p.law != holders.viscous) return 0;
      return count_in_joint(model, p, Role::kPowerViscous) > 0 ? 0.5 * guess.Fv : guess.Fv;
    case Role::kPowerViscous:
      return holders.viscous < 0 ? guess.Fv : 0.5 * guess.Fv;
    case Role::kMotorViscous:
      return guess.Fv;
    case Role::kExponent:
      return 0.6;
    case Role::kDamping:
      return 0;
    case Role::kShare:
      return 1.0 / in_law(Role::kShare);
    case Role::kStiffness: {
      const int springs = in_law(Role::kStiffness);
      if (springs == 1) return guess.Fc / (kBristleLength * scale);
      const double at = static_cast<double>(p.info.element - 1) / (springs - 1);
      return kStatic * guess.Fc / springs /
             (scale * kShortest * std::pow(kLongest / kShortest, at));
    }
    case Role::kSmoothingSpeed:
      return scale * (is_of_load_law(model, p) ? kLoadCorner : kCorner);
    case Role::kLoadSmoothing:
      return kLoadFoot;
    case Role::kLoadCoefficient:
      return kPowerFlow;
    case Role::kLoadGrowth:
      return (is_of_load_law(model, p) ? kCurvature * kPowerFlow : kLoadShare) /
             std::max(load, 1e-3);
    case Role::kGap:
      return kFirstGap * scale;
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

Arm start_sum(const Arm& arm, std::vector<friction::JointSpec> joints, const SumStart& start) {
  Arm out = arm;
  out.friction.model = friction::RobotFriction(std::move(joints));
  out.friction.theta.clear();
  const std::vector<Holders> holders = holders_of(out.friction.model);
  for (const friction::ParameterRef& p : out.friction.model.parameters()) {
    const auto j = static_cast<std::size_t>(p.joint);
    friction::FrictionGuess guess = start.joints[j];
    guess.Fc /= count_coulomb_laws(out.friction.model, p.joint);
    out.friction.theta.push_back(
        std::clamp(start_value(out.friction.model, p, holders[j], guess, start.load[j],
                               start.temperature, dynamics::travel_scale(arm.robot.joints[j])),
                   p.info.lower, p.info.upper));
  }
  friction::initialise_weights(out.friction.model, kSeedOfNetworks, out.friction.theta);
  return out;
}

std::vector<Limit> sum_limits(const Arm& arm) {
  const friction::Friction& friction = arm.friction;
  const friction::RobotFriction& model = friction.model;
  const std::vector<Holders> holders = holders_of(model);
  std::vector<Limit> limits;
  for (std::size_t i = 0; i < model.parameters().size(); ++i) {
    const friction::ParameterRef& p = model.parameters()[i];
    if (p.joint == friction::kWholeRobot) continue;
    const Holders& joint = holders[static_cast<std::size_t>(p.joint)];
    const double value = friction.theta[i];
    const bool corner = is_corner_of_static(model, p, joint);
    const bool corner_of_level = is_corner_of_level(model, p, joint);
    const bool held =
        (p.info.role == Role::kSmoothingSpeed && !is_load_corner(model, p) && !corner &&
         !corner_of_level) ||
        p.info.role == Role::kTemperature ||
        (p.info.role == Role::kCoulomb && p.law != joint.coulomb && is_of_load_law(model, p));
    if (held) limits.push_back({i, value, value});
    if (p.info.role == Role::kViscous && p.law != joint.viscous) limits.push_back({i, 0, 0});
    const double scale =
        dynamics::travel_scale(arm.robot.joints[static_cast<std::size_t>(p.joint)]);
    const auto within = [&](double lower, double upper) {
      limits.push_back({i, std::min(value, lower), std::max(value, upper)});
    };
    if (corner_of_level) within(scale * kCorner / kLevelRange, scale * kCorner * kLevelRange);
    if (corner) within(scale * kCorner / kCornerRange, scale * kCorner * kCornerRange);
    if (is_load_corner(model, p)) {
      const double typical = p.info.role == Role::kLoadSmoothing ? kLoadFoot : scale * kLoadCorner;
      within(typical / kCornerRange, typical * kCornerRange);
    }
    if (p.info.role == Role::kLoadCoefficient) limits.push_back({i, p.info.lower, kMostLoss});
    if (p.info.role == Role::kStribeckVelocity)
      within(kSlowest * scale, (p.law == joint.coulomb ? kFastest : kFastestBeside) * scale);
    const double Fc = coulomb_friction(friction, p);
    if (p.info.role == Role::kAttraction) within(kSlowReturn * Fc, kFastReturn * Fc);
    if (p.info.role == Role::kLoadGrowth && !is_of_load_law(model, p))
      limits.push_back({i, p.info.lower,
                        Fc > 0 ? std::max(value, kMostLoss / std::max(Fc, 1e-3)) : p.info.upper});
  }
  return limits;
}

std::vector<std::size_t> slowest_stribeck_velocities(const Arm& arm) {
  constexpr double kRounding = 1e-9;
  std::vector<std::size_t> slowest;
  for (const Limit& limit : sum_limits(arm))
    if (arm.friction.model.parameters()[limit.parameter].info.role == Role::kStribeckVelocity &&
        arm.friction.theta[limit.parameter] <= (1 + kRounding) * limit.lower)
      slowest.push_back(limit.parameter);
  return slowest;
}

std::vector<std::size_t> load_corners(const friction::RobotFriction& model) {
  std::vector<std::size_t> corners;
  for (std::size_t i = 0; i < model.parameters().size(); ++i)
    if (model.parameters()[i].joint != friction::kWholeRobot &&
        is_load_corner(model, model.parameters()[i]))
      corners.push_back(i);
  return corners;
}

std::vector<Limit> held_networks(const friction::Friction& friction) {
  std::vector<Limit> held;
  for (std::size_t i = 0; i < friction.model.parameters().size(); ++i) {
    const friction::ParameterRef& p = friction.model.parameters()[i];
    if (p.joint != friction::kWholeRobot && count_in_law(friction.model, p, Role::kWeight) > 0)
      held.push_back({i, friction.theta[i], friction.theta[i]});
  }
  return held;
}

}  // namespace fricid::estimate
