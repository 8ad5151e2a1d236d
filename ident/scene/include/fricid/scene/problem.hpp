// A resolved scene: its robot, its files, its checked names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/scene/scene.hpp"

namespace fricid::scene {

/// A scene that can be run.
struct Problem {
  /// With every default filled in (laws, methods, friction by effort, per-joint values, priors of
  /// [[robot.torque]]) and files named so that a copy of the scene in another folder finds them.
  const Scene scene;
  dynamics::RobotModel robot;  ///< from the URDF with mount, payload and linear torques
  /// Absolute; empty when not named.
  std::filesystem::path urdf_path{}, mjcf_path{}, contract_path{};
  std::vector<std::filesystem::path> inputs{};  ///< scenes, URDF, MJCF, contract, logs that exist
};

/// Finds the files of a scene beside the file that names them, then in the share folder, builds
/// its robot and checks its values. Depends only on the scene and the content of those files.
/// Log files need not exist: see `require_logs`.
/// @throws UserError "file:line: ..." on anything wrong
Problem resolve(Scene scene);

/// The problem of a scene file. @throws UserError
inline Problem load_problem(const std::filesystem::path& path) { return resolve(load_scene(path)); }

/// The problem with the load of [payload] on the arm, known: its simulation gives the recordings
/// with the load, of motion and noise of their own (the next seed), none of them held out.
Problem with_load(const Problem& problem);

/// Checks that the data of a scene with [friction] are long enough for its horizons.
/// @throws UserError "file:line: ..." when a horizon is longer than a simulated recording
void require_horizons(const Scene& scene);

/// Path of a log of the scene. @throws UserError when it is not there
std::filesystem::path find_log(const Problem& problem, const std::string& name);

/// Checks that every log file of the scene is there. @throws UserError "file:line: ..."
void require_logs(const Problem& problem);
/// @throws UserError where a model has a prior that is not there
void require_priors(const Problem& problem);
/// Whether every log file of the scene is there.
bool logs_are_there(const Problem& problem);

}  // namespace fricid::scene
