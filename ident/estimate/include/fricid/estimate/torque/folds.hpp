// What fits leave out in turn: how a model does on motion that it was not fitted to.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Samples [begin, end) of a recording.
struct Stretch {
  int recording = 0, begin = 0, end = 0;
};

/// What one fit of several leaves out.
struct Fold {
  std::vector<Stretch> left_out;  ///< each at most `kLongestStretch`

  /// All that is left out of a recording, if anything is.
  std::optional<Stretch> left_out_of(int recording) const;
};
inline constexpr double kLongestStretch = 10;  // [s]

/// At most four folds, each of which leaves out all recordings of some motions
/// (`signals::number_motions`), every recording once; of a single motion five fifths.
std::vector<Fold> folds_of(std::span<const signals::Recording> recordings);

/// The recordings without the rows that a fold leaves out: no fit uses them, while motion still
/// drives friction there.
std::vector<signals::Recording> without(const Fold& fold,
                                        std::span<const signals::Recording> recordings);

}  // namespace fricid::estimate
