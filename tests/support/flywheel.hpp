// The smallest arm: one wheel on a vertical axis, whose motion has a closed form.
#pragma once

#include "fricid/system/arm.hpp"

namespace fricid::test {

/// Inertia [kg m^2] about z, no gravity torque; friction Fv v [N m].
inline Arm flywheel(double inertia, double Fv) {
  Arm arm;
  arm.robot.name = "flywheel";
  arm.robot.joints.resize(1);
  arm.robot.joints[0].name = "joint";
  arm.robot.joints[0].link = "wheel";
  arm.robot.joints[0].continuous = true;
  arm.robot.pi = Eigen::VectorXd::Zero(arm.robot.parameter_count());
  arm.robot.pi[0] = 1;                                            // mass
  arm.robot.pi[4] = arm.robot.pi[6] = arm.robot.pi[9] = inertia;  // Ixx, Iyy, Izz
  arm.friction.model = friction::RobotFriction({{{{"coulomb_viscous", 0, {}}}}});
  for (const friction::ParameterRef& p : arm.friction.model.parameters())
    arm.friction.theta.push_back(p.symbol == "Fc" ? 0 : p.symbol == "Fv" ? Fv : p.info.typical);
  return arm;
}

}  // namespace fricid::test
