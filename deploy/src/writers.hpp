// One function per format.
#pragma once

#include "fricid/deploy/export.hpp"

namespace fricid::deploy {

/// NAME_friction.csv: steady friction torque over speed, joint by joint.
Exported write_csv(const data::ModelFile& model);

/// NAME.urdf: the rigid body. @throws UserError when an inertia is not physical
Exported write_urdf(const data::ModelFile& model);

/// NAME.xml: the rigid body as MJCF. @throws UserError when an inertia is not physical
Exported write_mjcf(const data::ModelFile& model);

/// "the motor of joint_a6 turns by joint_a6 + joint_a5": motors that turn by more than one joint.
std::string motors_in_words(const dynamics::RobotModel& robot);

}  // namespace fricid::deploy
