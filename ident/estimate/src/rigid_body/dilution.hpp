// What noise in the measured motion takes from the parameters that it is multiplied with.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rigid_body/regression.hpp"

namespace fricid::estimate {

/// Rows N (.. x columns) that noise of the encoders adds to some rows of a regression: a draw.
struct NoiseRows {
  Eigen::MatrixXd rows;
  std::vector<Eigen::Index> of;  ///< row of the regression of each
  double share = 1;              ///< of the samples of the regression
};

/// The narrow motion of a recording with a draw of encoder noise, `signals::motion_of_noise`.
signals::Motion with_noise(const signals::Recording& recording, double cutoff_hz,
                           std::uint64_t seed);

/// Y(q + dq, v + dv, a + da) - Y(q, v, a) and dv beside it, (dq, dv, da) being what noise of the
/// encoders' resolution makes behind the filter; of every so many samples in a long log.
NoiseRows draw_noise_rows(const dynamics::RobotModel& robot,
                          std::span<const signals::Recording> sequences, const Regression& data,
                          double cutoff_hz);

/// N'WN of a regression. @param weight  (N) of its rows
Eigen::MatrixXd noise_information(const NoiseRows& noise, const std::vector<int>& columns,
                                  const Eigen::VectorXd& weight);

/// Root D of the square D D' of the error of weighted least squares whose rows X = X0 + N contain
/// noise N: x - x0 = -H^-1 N'WN x0 in the mean, parameters are pulled to zero, most where the
/// motion is hardly above the noise. With H = L L' and mu, V the eigenvalues and vectors of
/// L^-1 N'WN L^-T, y = V' L^-1 N'WN x,
///
///     D = L^-T V diag(sqrt(y^2 + mu^2) / (1 - mu)).
///
/// @param information  N'WN, in any coordinates of x
/// @param score        N'WN x in the same
/// Source: Fuller, Measurement Error Models, Wiley 1987, 2.2.
Eigen::MatrixXd dilution_root(const Eigen::MatrixXd& information, const Eigen::MatrixXd& H,
                              const Eigen::VectorXd& score);

}  // namespace fricid::estimate
