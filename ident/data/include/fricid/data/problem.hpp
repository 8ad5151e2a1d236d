// What a scene makes: its robot, its files, its checked names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fricid/data/scene.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::data {

/// A scene that can be run.
struct Problem {
  /// With every default filled in (name, laws, methods, friction by effort, per-joint values) and
  /// files named so that a copy of the scene in another folder finds them.
  const Scene scene;
  dynamics::RobotModel robot;             ///< from the URDF with mount, payload and linear torques
  std::vector<double> torque_prior_sd{};  ///< of robot.linear_torques [N m]; infinity: none known
  /// Absolute; empty when not named.
  std::filesystem::path urdf_path{}, mjcf_path{}, contract_path{};
  std::vector<std::filesystem::path> inputs{};  ///< scenes, URDF, MJCF, contract, logs that exist
};

/// Finds the files of a scene beside the file that names them, then in the share folder, builds
/// its robot and checks what it says. Depends on the scene and the content of those files alone.
/// Log files need not exist: see `data_available`.
/// @throws UserError "file:line: ..." on anything wrong
Problem resolve(Scene scene);

/// The problem of a scene file. @throws UserError
inline Problem load_problem(const std::filesystem::path& path) { return resolve(load_scene(path)); }

/// Path of a log of the scene. @throws UserError when it is not there
std::filesystem::path find_log(const Problem& problem, const std::string& name);

/// Whether every log file of the scene is there; if not, `why` says in one line what is missing.
bool data_available(const Problem& problem, std::string* why);

/// Rotation that takes vectors of the base to the world (z up).
Eigen::Matrix3d mount_rotation(const RobotConfig& robot);

}  // namespace fricid::data
