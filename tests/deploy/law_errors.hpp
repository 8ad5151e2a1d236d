// Every law and modifier of the tables as a model, and how far its exported header is from the
// engine along a motion.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "fricid/data/model_file.hpp"

namespace fricid::deploy::test {

/// A model of two joints for each law, each modifier (on a law with and one without state), a sum
/// of laws, and each law of the whole robot, parameters drawn within their bounds.
std::vector<data::ModelFile> all_models();

/// The same, with a flywheel at each joint and names that a model file may have.
std::vector<data::ModelFile> all_robots();

/// One of all_robots() by its name.
data::ModelFile robot_with(const std::string& name);

/// C compilers of this machine.
std::vector<std::string> c_compilers();

/// Position, velocity, load and temperature of the joints at 6000 instants 1 ms apart, joint by
/// joint: reversals from presliding to fast sliding, rests, load and heat.
std::vector<friction::Input<double>> motion();

/// Time between the instants of `motion` [s].
inline constexpr double kDt = 1e-3;

/// The engine's torque along a motion, after each step of dt (steps x joints) [N m].
std::vector<double> torques_after_steps(const data::ModelFile& model,
                                        const std::vector<friction::Input<double>>& motion,
                                        double dt);

/// The values as they are in memory. Not synced to the disk, unlike the program's own files.
template <class Values>
void write_binary(const std::filesystem::path& path, const Values& values) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(values.data()),
             static_cast<std::streamsize>(values.size() * sizeof(values[0])));
}

/// Compiles the headers of the models, whose joints are those of the motion, with a main program,
/// warnings as errors, and runs it in steps of dt: the error of the torque of each model as a share
/// of the largest that the engine says.
/// @throws std::runtime_error with what the compiler or the program said
std::vector<double> header_errors(const std::vector<data::ModelFile>& models,
                                  const std::vector<friction::Input<double>>& motion, double dt,
                                  const std::string& compiler, const std::string& options,
                                  const std::filesystem::path& folder);

}  // namespace fricid::deploy::test
