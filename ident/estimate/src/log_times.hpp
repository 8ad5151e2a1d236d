// Stretches of logs in words, and what is left of a log without them.
#pragma once

#include <string>
#include <vector>

#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// First and last sample.
struct Run {
  int first = 0, last = 0;
};

/// Runs of samples in the order of logs and time; those with less than two seconds between them are
/// one.
class LogTimes {
 public:
  void add(const signals::Recording& log, const Run& run);
  bool empty() const { return spans_.empty(); }
  /// "1.2 to 3.4 s of train", the first four.
  std::string words() const;
  /// What is left of the first log without them, as a scene says it, in the time of its file.
  std::string remedy() const;

 private:
  struct Span {
    const signals::Recording* log;
    Run run;
    double begin() const { return log->log.t[run.first]; }
    double end() const { return log->log.t[run.last]; }
  };
  std::vector<Span> spans_;
};

}  // namespace fricid::estimate
