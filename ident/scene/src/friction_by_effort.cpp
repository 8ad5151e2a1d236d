#include "friction_by_effort.hpp"

#include <map>

#include "fricid/base/error.hpp"

namespace fricid::scene {

friction::Friction friction_by_effort(const dynamics::RobotModel& robot, const std::string& where) {
  constexpr double kCoulombShare = 0.06, kViscousShare = 0.2, kStaticShare = 1.25;
  constexpr double kUsualSpeed = 3;  // [rad/s] of a joint that states no limit
  friction::Friction friction;
  friction.model = friction::RobotFriction(
      std::vector<friction::JointSpec>(robot.joints.size(), {{{"lugre", 0, {}}}}));
  friction.theta = friction::default_theta(friction.model);
  for (std::size_t i = 0; i < friction.theta.size(); ++i) {
    const friction::ParameterRef& parameter = friction.model.parameters()[i];
    const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(parameter.joint)];
    if (joint.effort <= 0)
      throw UserError("{}: joint {} has no effort limit; allowed: [[friction.law]], or a limit",
                      where, joint.name);
    const double Fc = kCoulombShare * joint.effort, travel = 6e-4 * travel_scale(joint);
    const double sigma0 = kStaticShare * Fc / travel, vs = 0.05 * travel_scale(joint);
    using enum friction::Role;
    const std::map<friction::Role, double> values{
        {kCoulomb, Fc},
        {kStatic, kStaticShare * Fc},
        {kStribeckVelocity, vs},
        {kStiffness, sigma0},
        // so that the damping of a bristle fades with the Stribeck speed, as the law asks for
        {kDamping, 0.1 * Fc / vs},
        {kViscous,
         kViscousShare * joint.effort / (joint.velocity > 0 ? joint.velocity : kUsualSpeed)}};
    if (const auto value = values.find(parameter.info.role); value != values.end())
      friction.theta[i] = value->second;
  }
  return friction;
}

}  // namespace fricid::scene
