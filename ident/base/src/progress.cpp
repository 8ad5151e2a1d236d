#include "fricid/base/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <utility>

#include "fricid/base/names.hpp"

namespace fricid {
namespace {

using Clock = std::chrono::steady_clock;

// Set while no stage is under way, so that its readers need no lock.
std::function<void(const Progress::Report&)>& listener() {
  static std::function<void(const Progress::Report&)> function;
  return function;
}

constexpr double kTerminalPeriod = 0.1, kLinePeriod = 10;  // [s]
constexpr int kBarWidth = 24;

std::atomic<bool> quiet = false;
std::atomic<bool> stop = false;
static_assert(std::atomic<bool>::is_always_lock_free);

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// 75 -> "1:15", 3700 -> "1:01:40".
std::string clock_time(double seconds) {
  const long s = std::lround(seconds);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

std::string progress_line(std::string_view stage, double done, double total, double seconds,
                          std::string_view figure) {
  const double share = total > 0 ? std::clamp(done / total, 0.0, 1.0) : 0;
  const double rate = seconds > 0 ? done / seconds : 0;
  std::string line = fmt::format("{} {:3.0f} %", stage, 100 * share);
  if (rate > 0)
    line += fmt::format("  {:.3g}/s  ETA {}", rate, clock_time(std::max(total - done, 0.0) / rate));
  if (!figure.empty()) line += fmt::format("  {}", figure);
  return printable(line);
}

Progress::Progress(std::string_view stage, double total)
    : stage_(stage), total_(total), terminal_(::isatty(STDERR_FILENO) != 0), start_(Clock::now()) {}

Progress::~Progress() {
  if (shown_ || listener()) show(seconds_since(start_), true);
}

void Progress::advance(double amount, std::string_view figure) {
  const std::lock_guard lock(mutex_);
  done_ += amount;
  if (!figure.empty()) figure_ = figure;
  const double seconds = seconds_since(start_);
  const double period = terminal_ || listener() ? kTerminalPeriod : kLinePeriod;
  if ((quiet && !listener()) || seconds - last_shown_ < period) return;
  last_shown_ = seconds;
  show(seconds, false);
}

void Progress::show(double seconds, bool last) {
  shown_ = true;
  if (listener()) return listener()({stage_, done_, total_, seconds, figure_});
  const std::string line = progress_line(stage_, done_, total_, seconds, figure_);
  if (!terminal_) {
    std::fputs((line + '\n').c_str(), stderr);
    return;
  }
  const double share = total_ > 0 ? std::clamp(done_ / total_, 0.0, 1.0) : 0;
  const int filled = static_cast<int>(share * kBarWidth);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(kBarWidth - filled), '.');
  // back to the start of the line, and clear what the last one left behind
  std::fputs(fmt::format("\r[{}] {}\x1b[K{}", bar, line, last ? "\n" : "").c_str(), stderr);
}

void Progress::set_quiet(bool value) { quiet = value; }

void Progress::set_listener(std::function<void(const Report&)> function) {
  listener() = std::move(function);
}

void install_stop_handler() {
  struct sigaction action = {};
  action.sa_handler = [](int) { stop = true; };
  // the second signal finds the default action and ends the process at once
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

void request_stop() { stop = true; }
void forget_stop_request() { stop = false; }
bool stop_requested() { return stop; }

void throw_if_stopped() {
  if (stop) throw Stopped{};
}

}  // namespace fricid
