// Blocks of time whose residuals count as independent.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Residuals less than this apart are correlated: friction's memory leaves them so [s].
inline constexpr double kBlock = 1;

/// Blocks of the time of recordings. What a model leaves comes again with the motion: blocks of the
/// same stretch of it have the same passage.
class TimeBlocks {
 public:
  /// @param seconds  of a block  @param recordings  `signals::mark_repeats`
  TimeBlocks(std::span<const signals::Recording> recordings, double seconds) {
    struct Range {
      int first = 0, count = 0;
    };
    std::vector<Range> of_motions;
    for (const signals::Recording& r : recordings) {
      const int length = std::max(1, static_cast<int>(std::lround(seconds / r.dt)));
      const int period = std::max(1, r.period > 0 ? r.period : r.length());
      const int of_period = (period + length - 1) / length;
      const auto motion = static_cast<std::size_t>(std::max(0, r.motion_number));
      if (motion >= of_motions.size()) of_motions.resize(motion + 1);
      Range own{passages_, of_period};
      Range& passages = r.motion_number < 0 ? own : of_motions[motion];
      if (passages.count == 0) passages = own;
      if (passages.first == passages_) passages_ += of_period;
      at_.push_back({static_cast<int>(passage_.size()), length, period, of_period});
      const int periods = (r.length() + period - 1) / period;
      for (int i = 0; i < periods * of_period; ++i)  // one that lasts longer ends with the first
        passage_.push_back(passages.first + std::min(i % of_period, passages.count - 1));
    }
  }

  /// Block of a sample, ascending along a recording and from one to the next.
  int of(std::size_t recording, int sample) const {
    const At& at = at_[recording];
    return at.first + sample / at.period * at.of_period + sample % at.period / at.length;
  }
  int passage_of(std::size_t recording, int sample) const {
    return passage_[static_cast<std::size_t>(of(recording, sample))];
  }
  int passages() const { return passages_; }

 private:
  struct At {
    int first, length, period, of_period;
  };
  std::vector<At> at_;
  std::vector<int> passage_;  // of each block
  int passages_ = 0;
};

}  // namespace fricid::estimate
