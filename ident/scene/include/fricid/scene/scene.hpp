// A scene file as plain data. Each section is the options struct of its user and names its fields,
// with meaning, unit and range, once in `visit`. Reading, writing with all defaults, the check for
// unknown keys and `fricid template scene` use it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/estimate/options/model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/evaluate/options.hpp"
#include "fricid/film/options.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/scene/origin.hpp"
#include "fricid/scene/payload.hpp"
#include "fricid/scene/robot.hpp"
#include "fricid/sim/options.hpp"

namespace fricid::scene {

/// [data]: logs instead of simulation.
struct DataSection {
  std::string contract;
  std::vector<std::string> train, validation;

  template <class Archive>
  void visit(Archive& archive) {
    archive("contract", contract, text("column contract (fricid template contract)"));
    archive("train", train,
            files_or_parts("training logs, or parts of them in seconds, \"FILE[FROM:TO]\"; may "
                           "start with $VARIABLE/"));
    archive("validation", validation,
            files_or_parts("validation logs, or parts of them in seconds, \"FILE[FROM:TO]\"; may "
                           "start with $VARIABLE/"));
  }
};

/// A scene file as plain data; `resolve` finds the files that it names.
struct Scene {
  std::string name;
  std::string description;
  std::uint64_t seed = 1;
  RobotSection robot;
  /// What is injected; absent for logs. Without a law for any joint: LuGre by the effort limits.
  std::optional<friction::Friction> friction;
  sim::PlantOptions plant;
  sim::ControllerOptions controller;
  sim::ExcitationOptions excitation;
  sim::SensorOptions sensors;
  DataSection data;
  estimate::RigidBodyOptions identify;
  std::vector<estimate::ModelOptions> models;
  evaluate::EvaluateOptions evaluate;
  PayloadSection payload;
  sim::CompensationOptions compensation;
  sim::ContactOptions contact;
  film::FilmOptions render;

  std::vector<std::string> joints;  ///< (n) of the robot, in the order of per-joint values
  SceneOrigin origin;

  bool simulates() const { return friction.has_value(); }

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name,
            text("name of the run; empty: that of the file; letters, digits, space, _ - . ( )"));
    archive("description", description, text("one line for reports"));
    archive("seed", seed, number("", 0, 9e15, "seed of every random draw"));
    archive.section("robot", robot, "the arm");
    archive.section("friction", friction, "friction injected by the simulator");
    archive.section("plant", plant, "the simulation");
    archive.section("controller", controller, "moves the simulated arm; unknown to the estimators");
    archive.section("excitation", excitation, "Fourier trajectories inside all limits");
    archive.section("sensors", sensors, "sensors of the simulated log");
    archive.section("data", data, "log files instead of a simulation");
    archive.section("identify", identify, "least squares on the rigid body, common to all models");
    archive.sections("model", models, "models to fit");
    archive.section("evaluate", evaluate, "open loop on held-out data");
    archive.section("payload", payload, "a load to find from recordings with it");
    archive.section("compensation", compensation, "friction fed forward to the simulated arm");
    archive.section("contact", contact, "pushes on the simulated arm, and who feels them");
    archive.section("render", render, "the film of the run");
  }
};

/// Reads a scene, following `extends = "file"` or an array of files of which the last wins
/// (relative to the file that says it; tables merge, values and arrays replace). Reads the joints
/// of its URDF too: friction and per-joint values are by joint.
/// @param path  where it is none, it is looked for in the share folder
/// @throws UserError "file:line: ..." on anything wrong
Scene load_scene(const std::filesystem::path& path);

/// The same of a text that no file holds: file names start in the current folder, places are
/// "<scene>".
Scene load_scene_text(const std::string& text);

/// The model that [[model]] with this name and no other key would be in a scene.
/// @throws UserError when it is no law, naming the models of the scene and the laws
estimate::ModelOptions model_of_law(Scene scene, const std::string& name);

/// The scene as a file; loading it gives the same scene.
std::string to_toml(const Scene& scene);

/// A commented scene with every key, its unit, range and default.
std::string scene_template();

}  // namespace fricid::scene
