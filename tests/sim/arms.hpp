// Arms and scenes for the tests of sim.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "fricid/data/experiment.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/sim/plant.hpp"

namespace fricid::sim::test {

inline std::filesystem::path source(const std::string& path) {
  return std::filesystem::path(FRICID_SOURCE_DIR) / path;
}

inline data::Experiment scene(const std::string& name) {
  return data::load_experiment(source("scenes/" + name + ".toml"));
}

/// The scene with as few and as plain trajectories as its purpose allows.
inline data::Experiment small_scene(const std::string& name) {
  data::Experiment experiment = scene(name);
  experiment.excitation.train = 1;
  experiment.excitation.repeats = 1;
  experiment.excitation.validation = 1;
  experiment.excitation.criterion = "none";
  experiment.excitation.harmonics = 5;
  experiment.excitation.base_rad_s = 1;
  return experiment;
}

inline friction::Friction no_friction(int n) {
  return {friction::RobotFriction(std::vector<friction::JointSpec>(static_cast<std::size_t>(n))),
          {}};
}

/// Writes a file for one test; gone with the object.
class TempFile {
 public:
  TempFile(const std::string& name, const std::string& text)
      : path_(std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + "_" + name)) {
    std::ofstream(path_) << text;
  }
  ~TempFile() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace fricid::sim::test
