// The part of long training data that fits use.
#pragma once

#include <span>
#include <vector>

#include "fricid/data/dataset.hpp"

namespace fricid::data {

/// Recordings to fit to, and how much of the given ones they are.
struct TrainingPart {
  std::vector<Dataset> recordings;
  double seconds = 0, of_seconds = 0;

  bool is_all() const { return seconds == of_seconds; }
};

/// Samples of all joints that a fit takes; more teach a friction law nothing.
inline constexpr int kMostSamples = 320'000;

/// The recordings themselves up to `most` samples. Of more, pieces of them, each a recording of its
/// own named as in a scene, "train_0[120:140]": the recordings are cut into pieces of 20 s (shorter
/// where `most` samples hold fewer than eight such), those that miss half of a signal or in which
/// no joint moves are passed over, and of each of as many equal shares of the rest as `most`
/// samples allow one is drawn at random. So the pieces cover the whole time, and no motion that
/// repeats is met at the same phase again and again. Deterministic.
TrainingPart training_part(std::span<const Dataset> recordings, int most = kMostSamples);

}  // namespace fricid::data
