#pragma once

#include <filesystem>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/scene/scene.hpp"

// What [robot] adds to the body of the URDF. All throw UserError, naming the key.
namespace fricid::scene {

/// Adds [[robot.torque]]: torques of a joint that are linear in unknown coefficients.
/// @return prior standard deviation of each coefficient [N m]; infinite: no prior
std::vector<double> add_torques(const Scene& scene, dynamics::RobotModel& robot);

/// Takes the coupled motors of the contract if the scene has none. @throws UserError when
/// both name some and they differ
void take_couplings(Scene& scene, const std::filesystem::path& contract_path);

/// Adds [[robot.coupling]]: motors that turn more than one joint.
void add_couplings(const Scene& scene, dynamics::RobotModel& robot);

/// Sets the armatures of robot.armature and those that robot.guess_armature asks for.
void add_armatures(const Scene& scene, dynamics::RobotModel& robot);

/// Adds robot.payload_kg to the link of robot.payload_frame.
void add_payload(const Scene& scene, dynamics::RobotModel& model);

/// Adds the load of [payload], which has no mass where it is in logs.
void add_unknown_load(const Scene& scene, dynamics::RobotModel& model);

}  // namespace fricid::scene
