// What a log shows of each joint without any model and without a filter.
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
/// differences: their variance is 70 times the noise's, smooth motion hardly moves them, and the
/// median leaves corners out. NaN without five finite samples in a row.
double noise_of_differences(const Eigen::VectorXd& x);

/// Slope of x over time between the neighbours of each sample, one-sided at the ends (T).
Eigen::VectorXd slope(const Eigen::VectorXd& x, const Eigen::VectorXd& t);

}  // namespace fricid::signals
