// Runs other programs, without a shell.
#pragma once

#include <string>
#include <vector>

namespace fricid::render {

/// How a program ended.
struct ProgramResult {
  bool found = false;
  int exit_code = -1;  ///< if it exited; else -1
  int signal = 0;      ///< signal that killed it, or 0
  std::string errors;  ///< its output on stderr

  bool succeeded() const { return found && signal == 0 && exit_code == 0; }
};

/// Runs argv[0] from the PATH to its end, with empty stdin and discarded stdout. Ctrl-C and SIGTERM
/// end it too.
ProgramResult run_program(const std::vector<std::string>& argv);

}  // namespace fricid::render
