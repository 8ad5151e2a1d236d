// Options of the evaluation.
#pragma once

#include <vector>

#include "fricid/base/field.hpp"

namespace fricid::evaluate {

/// [evaluate]
struct EvaluateOptions {
  std::vector<double> horizons_s{0.1, 1, 10, 0};
  int starts = 4;
  int substeps = 8;
  double diverged_rad = 10;
  double min_headroom = 10;
  int draws = 39;

  template <class Archive>
  void visit(Archive& archive) {
    archive("horizons_s", horizons_s,
            number("s", 0, 1e5, "lengths of the open-loop rollouts; 0: the full length"));
    archive("starts", starts,
            number("", 1, 1000, "start times per trajectory for horizons below full length"));
    archive("substeps", substeps, number("", 1, 1000, "steps of the engine per sample"));
    archive("diverged_rad", diverged_rad,
            number("rad", 1e-3, 1e6, "position error beyond which a rollout is flagged and held"));
    archive("min_headroom", min_headroom,
            number("1", 0, 1e9,
                   "best conventional error over the oracle's below which a horizon is "
                   "called meaningless"));
    archive("draws", draws,
            number("", 0, 10000,
                   "open-loop rollouts per model and trajectory whose quantiles are the 90 % band, "
                   "19 or more; 0: no bands"));
  }
};

}  // namespace fricid::evaluate
