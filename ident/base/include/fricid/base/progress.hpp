#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace fricid {

/// Progress of one stage, written to stderr: on a terminal a bar with percent, rate and ETA,
/// otherwise a line every 10 s; nothing when quiet. Thread safe.
class Progress {
 public:
  /// @param total  the amount of work of the whole stage, in any unit
  Progress(std::string_view stage, double total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Adds finished work. @param figure  a result to show, e.g. "rmse 0.12 N m"; empty: none
  void advance(double amount, std::string_view figure = {});

  /// Switches all progress output of the program off or on (option --quiet).
  static void set_quiet(bool quiet);

  /// What is known of a stage at a moment.
  struct Report {
    std::string_view stage;
    double done, total;
    double seconds;           ///< since the stage began
    std::string_view figure;  ///< a result to show; may be empty
  };
  /// Takes reports in place of stderr, at most ten a second of each stage and one at its end; from
  /// any thread, one at a time for a stage. It must not throw. Empty: stderr again.
  /// @pre no stage is under way
  static void set_listener(std::function<void(const Report&)> listener);

 private:
  void show(double seconds, bool last);

  std::mutex mutex_;
  std::string stage_, figure_;
  double total_, done_ = 0;
  bool terminal_, shown_ = false;
  std::chrono::steady_clock::time_point start_;
  double last_shown_ = 0;  // [s] after start_
};

/// "stage  42 %  3.1/s  ETA 0:12  figure" after `seconds` of work.
std::string progress_line(std::string_view stage, double done, double total, double seconds,
                          std::string_view figure);

/// Thrown by a loop after a stop request. The program then exits with 130 and keeps all finished
/// results.
struct Stopped {};

/// Makes Ctrl-C and SIGTERM set a flag that long loops check between steps; a second signal ends
/// the process at once. Call once, in main.
void install_stop_handler();
/// The same request by the process itself, and its end.
void request_stop();
void forget_stop_request();
bool stop_requested();
/// @throws Stopped after a stop was requested
void throw_if_stopped();

}  // namespace fricid
