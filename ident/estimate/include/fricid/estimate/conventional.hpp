// Conventional identification: one friction law, joint by joint, beside the rigid body.
#pragma once

#include <vector>

#include "fricid/estimate/fit_report.hpp"
#include "fricid/estimate/options/model.hpp"
#include "fricid/estimate/prepared.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::estimate {

/// Fits one friction law of the table, joint by joint, to the torque residual of the rigid body
/// over all rows; then re-estimates the rigid body over all rows with that friction removed, and
/// the friction once more (`passes`). Coulomb and viscous friction alone is linear: it is that of
/// the regression with the rigid body, with its standard errors, smoothed over `smoothing_speed`.
/// Joints run in parallel; the result does not depend on `jobs`.
/// @throws UserError on a model name that is not a law; Stopped on Ctrl-C
FitReport fit_conventional(const Prepared& prepared, const ModelOptions& options, int seed,
                           int jobs);

/// The conventional fits of one job: models that begin with the same one share it.
class ConventionalFits {
 public:
  explicit ConventionalFits(const Prepared& prepared) : prepared_(prepared) {}
  const Prepared& prepared() const { return prepared_; }
  /// `fit_conventional`, made at the first call.
  FitReport fit(const ModelOptions& options, int seed, int jobs);

 private:
  struct Kept {
    friction::RobotFriction law;  // of one joint
    int starts, seed;
    FitReport report;
  };
  const Prepared& prepared_;
  std::vector<Kept> kept_;
};

}  // namespace fricid::estimate
