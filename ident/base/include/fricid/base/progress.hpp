#pragma once

#include <string_view>

namespace fricid {

/// Progress of one stage, written to stderr: on a terminal a bar with percent, rate and ETA,
/// otherwise a line every 10 s; nothing when quiet. Thread safe.
class Progress {
 public:
  Progress(std::string_view stage, double total);
  ~Progress();
  void advance(double amount, std::string_view figure = {});
  static void set_quiet(bool quiet);
};

/// Ctrl-C: `install_stop_handler` once in main; long loops ask `stop_requested` between steps and
/// throw `Stopped`, which the program turns into exit code 130 with everything finished kept.
struct Stopped {};
void install_stop_handler();
bool stop_requested();
void throw_if_stopped();

}  // namespace fricid
