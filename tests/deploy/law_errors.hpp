// Every law and modifier of the tables as a model, and how far its exported header is from the
// engine along a motion.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fricid/data/model_file.hpp"

namespace fricid::deploy::test {

/// A model of two joints for each law, each modifier (on a law with and one without state), a sum
/// of laws, and each law of the whole robot, parameters drawn within their bounds.
std::vector<data::ModelFile> all_models();

/// C compilers of this machine.
std::vector<std::string> c_compilers();

/// Compiles the headers of the models with a main program, warnings as errors, and runs it along a
/// motion with reversals, rests and fast sliding: the error of the torque of each model as a share
/// of the largest that the engine says.
/// @throws std::runtime_error with what the compiler or the program said
std::vector<double> header_errors(const std::vector<data::ModelFile>& models,
                                  const std::string& compiler, const std::string& options,
                                  const std::filesystem::path& folder);

}  // namespace fricid::deploy::test
