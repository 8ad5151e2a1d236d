// The command line of `fricid`, for the program and for the command of the Python package.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace fricid::cli {

struct ViewOptions {
  std::filesystem::path target;              ///< run folder, scene or model
  std::filesystem::path screenshot, script;  ///< both empty: interactive window
  std::optional<double> at;                  ///< time of the screenshot [s]
  std::string renderer;                      ///< off screen; empty: FRICID_GL or what is found
};

/// Runs a command line: results to stdout, messages to stderr. Handles Ctrl-C.
/// @param view  opens the viewer; empty if it is not built
/// @return the exit code
int run_command_line(int argc, char** argv, const std::function<void(const ViewOptions&)>& view);

}  // namespace fricid::cli
