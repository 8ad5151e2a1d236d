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

/// NAME_extension.xml: the instance of the MuJoCo plugin, to be included in an MJCF;
/// NAME_plugin.xml: the rigid body with it. @throws UserError when an inertia is not physical
Exported write_plugin(const data::ModelFile& model);

/// NAME_friction.xml: the rigid body with friction as fixed tendons, dcmotors, frictionloss and
/// damping. Where these differ from the law, the error along a motion is a loss and a comment of
/// the file.
/// @throws UserError for a law of the whole robot, or when an inertia is not physical
Exported write_mjcf_friction(const data::ModelFile& model, const Motion* held_out);

/// NAME.fmu: the header as an FMU, compiled if there is a C compiler.
Exported write_fmu(const data::ModelFile& model);

/// NAME_friction.onnx: torque and next state as a function of inputs and state, for a batch.
Exported write_onnx(const data::ModelFile& model);

/// "lugre is NOT TO BE TRUSTED: ...", with the first of its doubts; empty: it has none.
std::string doubt_in_words(const data::ModelFile& model);
/// Its label and what it is, for the heads of files: "LuGre, robot kr6", and its doubt.
std::string title_of(const data::ModelFile& model);

/// "the motor of joint_a6 turns by joint_a6 + joint_a5": motors that turn by more than one joint.
std::string motors_in_words(const dynamics::RobotModel& robot);

/// That arrays of a friction are those of the motors, and how those of the joints follow: one
/// sentence for coupled motors, else empty.
std::string coordinates_in_words(const dynamics::RobotModel& robot);

/// One sentence for each torque of position that is not exported.
/// @param springs_said  linear springs are
std::vector<std::string> torques_left_out(const dynamics::RobotModel& robot, bool springs_said);

}  // namespace fricid::deploy
