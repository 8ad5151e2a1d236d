// The E-step: smoothed paths of one recording under given parameters.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fricid/estimate/em/latent_friction_model.hpp"
#include "fricid/estimate/em/transitions.hpp"
#include "fricid/estimate/options/em.hpp"
#include "fricid/smc/report.hpp"

namespace fricid::estimate {

struct EStepOptions {
  EStep method = EStep::kEkf;
  int particles = 200;
  int paths = 4;
  std::uint64_t seed = 1;
  std::uint32_t sequence = 0;  ///< tells recordings and iterations with one seed apart, < 2^29
};

/// Smoothed paths and how far to trust them.
struct EStepResult {
  Paths paths;
  double log_likelihood = 0;  ///< [nat]; the linearised model's for kEkf, an estimate otherwise
  double nis = 0;             ///< mean per channel: 1 if the noise is as large as the model's
  double roots = 1;           ///< distinct roots per particle; 1 for kEkf
  double backward_ess = 0;    ///< median; 0: not used
  bool failed = true;         ///< no paths: weights vanished or the filter became infinite
  std::vector<std::string> warnings;
};

/// Runs filter and smoother over the observed positions q of the first `steps` samples.
EStepResult smooth(LatentFrictionModel& model, const signals::Recording& recording, int steps,
                   const EStepOptions& options);

}  // namespace fricid::estimate
