#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/workflow/check.hpp"

namespace fricid::cli {

/// Inputs are never outputs.
/// @param option  that names the output: "-o"
/// @param inputs  those that are empty are left out
/// @throws UserError when the output is one of the inputs
void require_not_input(std::string_view option, const std::filesystem::path& output,
                       const std::vector<std::filesystem::path>& inputs);

/// What is there under the name of an output is only replaced by its like.
/// @param format  of the output, "fricid.payload/1"
/// @throws UserError when the file is of another format
void require_like(std::string_view option, const std::filesystem::path& output,
                  std::string_view format);

/// A run has its robot in its scene.
/// @throws UserError when options name another
void require_no_robot(const workflow::RobotOfLog& robot, const std::filesystem::path& run);

/// Warns of a model that is not to be trusted.
void say_doubts(const data::ModelFile& model);

}  // namespace fricid::cli
