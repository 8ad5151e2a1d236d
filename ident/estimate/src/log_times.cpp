#include "log_times.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fricid::estimate {
namespace {

constexpr double kMargin = 0.3;      // [s] about a run, in which a brake closes
constexpr double kBetween = 2;       // [s] of runs that are one
constexpr double kShortestPart = 1;  // [s] of a log that is worth a line of a scene
constexpr std::size_t kNamed = 4;

}  // namespace

void LogTimes::add(const signals::Recording& log, const Run& run) {
  const bool goes_on = !spans_.empty() && spans_.back().log == &log &&
                       (run.first - spans_.back().run.last) * log.dt < kBetween;
  if (goes_on)
    spans_.back().run.last = std::max(spans_.back().run.last, run.last);
  else
    spans_.push_back({&log, run});
}

std::string LogTimes::words() const {
  std::vector<std::string> named;
  for (std::size_t i = 0; i < std::min(kNamed, spans_.size()); ++i)
    named.push_back(fmt::format("{:.4g} to {:.4g} s of {}", spans_[i].begin(), spans_[i].end(),
                                spans_[i].log->log.name));
  return fmt::format(
      "{}{}", fmt::join(named, ", "),
      spans_.size() > kNamed ? fmt::format(" and {} times more", spans_.size() - kNamed) : "");
}

std::string LogTimes::remedy() const {
  const signals::Recording& log = *spans_.front().log;
  const double first = log.log.t[0], last = log.log.t[log.length() - 1];
  std::vector<std::string> parts;
  double from = first;
  const auto add_part = [&](double to) {
    if (to - from < kShortestPart) return;
    parts.push_back(
        fmt::format("\"LOG[{}:{:.4g}]\"", from > 0 ? fmt::format("{:.4g}", from) : "", to));
  };
  for (const Span& span : spans_) {
    if (span.log != &log) break;
    add_part(std::max(first, span.begin() - kMargin));
    from = span.end() + kMargin;
  }
  add_part(last);
  if (parts.empty()) return "leave that log out";
  return fmt::format("leave that time out: train = [{}] in [data]", fmt::join(parts, ", "));
}

}  // namespace fricid::estimate
