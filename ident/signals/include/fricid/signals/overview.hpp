// Range, speed, torque and noise of each joint of a log, without any model or filter.
#pragma once

#include <Eigen/Core>

#include "fricid/signals/dataset.hpp"

namespace fricid::signals {

/// One joint of a log. Missing samples are left out.
struct JointOverview {
  double low, high;    ///< of q [rad]; infinite without a sample
  double fastest = 0;  ///< largest central difference of q [rad/s]
  double torque_rms;   ///< [N m], NaN without a sample
  double torque_peak = 0;
  double noise;       ///< standard deviation, see noise_of_differences [rad]
  int reversals = 0;  ///< turns by more than 20 times the noise
  int missing = 0;    ///< samples without q or tau
};
JointOverview overview(const Dataset& log, int joint);

/// Standard deviation of white noise on a smooth signal, from the median size of its fourth
/// differences: their variance is 70 times that of the noise, smooth motion hardly affects them,
/// and the median is robust to corners. NaN without five consecutive finite samples.
double noise_of_differences(const Eigen::VectorXd& x);

/// Slope of x over time between the neighbours of each sample, one-sided at the ends (T).
Eigen::VectorXd slope(const Eigen::VectorXd& x, const Eigen::VectorXd& t);

}  // namespace fricid::signals
