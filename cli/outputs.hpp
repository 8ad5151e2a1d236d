#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace fricid::cli {

/// Inputs are never outputs.
/// @param option  that names the output: "-o"
/// @param inputs  those that are empty are left out
/// @throws UserError when the output is one of the inputs
void require_not_input(std::string_view option, const std::filesystem::path& output,
                       const std::vector<std::filesystem::path>& inputs);

}  // namespace fricid::cli
