// A joint's recorded motion, cut so that friction can be driven through many pieces at once.
#pragma once

#include <span>
#include <vector>

namespace fricid::estimate {

/// Samples [begin, end) of a sequence.
struct SampleRange {
  int begin, end;
  int size() const { return end - begin; }
};

/// Samples [begin, end) of a sequence, and the earlier sample from which friction is driven.
struct MotionPiece {
  int sequence;
  int start;  ///< at rest, or far enough ahead of `begin` that friction forgets how it started
  int begin, end;
};

/// Interval that a joint covers over a run-in: 0.1 rad (or m), at most a quarter of its travel. An
/// elastoplastic element whose travel to slip is below half of that slips whatever it held before
/// (the rule of wiping out).
/// @param q  per sequence, joint position [rad or m]
double run_in(std::span<const std::vector<double>> q, std::span<const SampleRange> ranges);

/// Cuts ranges of sequences into pieces for lanes that work side by side: as many as make the
/// longest lanes shortest, the run-in of each included, and 0.75 s beside, for what settles in
/// time.
/// @param grid  samples: every piece starts at a multiple, and ends at one unless its range ends
/// @return longest first
std::vector<MotionPiece> cut_motion(std::span<const std::vector<double>> q,
                                    std::span<const SampleRange> ranges, double dt, int lanes,
                                    int grid = 1);

}  // namespace fricid::estimate
