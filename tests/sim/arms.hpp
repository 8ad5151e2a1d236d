// Arms and scenes for the tests of sim.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "fricid/scene/problem.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/sim/plant.hpp"
#include "source_dir.hpp"

namespace fricid::sim::test {

inline std::filesystem::path source(const std::string& path) { return source_dir() / path; }

inline scene::Scene scene(const std::string& name) {
  return scene::load_scene(source("scenes/" + name + ".toml"));
}

/// The scene with as few and as plain trajectories as its purpose allows.
inline scene::Scene small_scene(const std::string& name) {
  scene::Scene small = scene(name);
  small.excitation.train = 1;
  small.excitation.repeats = 1;
  small.excitation.validation = 1;
  small.excitation.criterion = Criterion::kNone;
  small.excitation.harmonics = 5;
  small.excitation.base_rad_s = 1;
  return small;
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
