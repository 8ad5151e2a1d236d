// The online estimator: one sample in, states and friction with their uncertainty out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>

#include "fricid/smc/model.hpp"
#include "fricid/system/arm.hpp"
#include "fricid/system/noise.hpp"

namespace fricid::estimate {

struct OnlineOptions {
  int particles = 200;
  StepOptions step{8, 4};
  std::uint64_t seed = 1;
};

/// Estimate after a sample: means, and standard deviations such that
///
///     mean - 1.645 sd .. mean + 1.645 sd
///
/// is a 90 % band of a normal distribution. tau_f is the law's; tau_f_sd is that of the friction
/// torque of the joint, which differs from it by what the law leaves, see LatentNoise::friction.
struct OnlineEstimate {
  Eigen::VectorXd q, v, z, tau_f;              ///< (n), (n), (n_z), (n)
  Eigen::VectorXd q_sd, v_sd, z_sd, tau_f_sd;  ///< likewise
  double log_likelihood = 0;                   ///< of all samples so far [nat]
  double ess = 0;                              ///< effective sample size of the last weights
  bool lost = false;  ///< no particle was within ten standard deviations of the sample: all were
                      ///< shifted to the measured motion
};

/// Where a filter over a motion begins: at rest or moving at (q, v), friction state z.
/// @param noise  gives the spread of q; that of v and z is `v_sd` and `z_sd`
smc::Gaussian online_start(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                           const Eigen::VectorXd& z, const LatentNoise& noise, double v_sd,
                           const Eigen::VectorXd& z_sd);

/// Fully adapted particle filter of one arm, a sample at a time. Does not allocate after it was
/// made.
class OnlineEstimator {
 public:
  /// A copy of the filter's complete state.
  struct State;

  /// @throws UserError when sizes do not agree
  OnlineEstimator(Arm arm, const LatentNoise& noise, const smc::Gaussian& start,
                  const OnlineOptions& options);
  ~OnlineEstimator();
  OnlineEstimator(OnlineEstimator&&) noexcept;

  /// Advances by one sample.
  /// @param tau          torque held since the last sample (n) [N m]
  /// @param y            positions now (n) [rad], NaN where missing; (2 n) with velocities
  /// @param temperature  (n) [K], or empty for room temperature
  const OnlineEstimate& step(std::span<const double> tau, std::span<const double> y,
                             std::span<const double> temperature = {});

  const OnlineEstimate& estimate() const;

  /// Restarts from the given start with the same random numbers.
  void reset();

  /// Saves the filter, and restores it to the last bit. Saving into a state saved before does not
  /// allocate.
  void save(State& state) const;
  void restore(const State& state);

 private:
  struct Filter;
  std::unique_ptr<Filter> filter_;
};

}  // namespace fricid::estimate
