#include "assumed_noise.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/estimate/em/em.hpp"
#include "fricid/signals/overview.hpp"
#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr double kLatentNoise = 1e-3;  // sd of w on z, share of their rms
constexpr double kPositionNoise = 1;   // sd of w on q, share of the encoder noise
constexpr double kVelocityNoise = 3;   // variance of w on v, of that of the torque
constexpr double kLeastError = 1e-3;   // of the torque, share of the friction
constexpr int kPoses = 100;            // samples from one M to the next

/// Variance of the white noise of the measured torque (n) [(N m)^2].
Eigen::VectorXd white_noise(std::span<const signals::Recording> recordings) {
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(recordings.front().n());
  for (Eigen::Index j = 0; j < variance.size(); ++j) {
    double samples = 0;
    for (const signals::Recording& r : recordings) {
      const double sd = signals::noise_of_differences(r.log.tau.col(j));
      if (!std::isfinite(sd)) continue;
      variance[j] += sd * sd * r.length();
      samples += r.length();
    }
    variance[j] /= std::max(samples, 1.0);
  }
  return variance;
}

/// Variance of v by that of the torque, held over a sample (n, n), the mean over poses [s^2 / (kg
/// m^2)^2].
Eigen::MatrixXd velocity_per_torque(const Arm& arm,
                                    std::span<const signals::Recording> recordings) {
  const int n = arm.robot.n();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
  double poses = 0;
  for (const signals::Recording& r : recordings)
    for (int k = 0; k < r.length(); k += kPoses, poses += 1)
      sum += (r.dt * mobility(arm.robot, r, k)).cwiseAbs2();
  return sum / poses;
}

/// Samples that the filter of a double integrator remembers, a time constant of its poles: sqrt(2)
/// over the square root of its tracking index sd_v dt / sd_q (Kalata, IEEE T-AES 20(2), 1984).
double remembered(double variance_v, double R, double dt) {
  return std::max(1.0, std::sqrt(2) * std::pow(R / (variance_v * dt * dt), 0.25));
}

}  // namespace

Eigen::VectorXd friction_left(std::span<const double> residual_rms) {
  return Eigen::Map<const Eigen::VectorXd>(residual_rms.data(), std::ssize(residual_rms))
      .cwiseAbs2();
}

LatentNoise assumed_noise(const Arm& arm, const Prepared& prepared,
                          std::span<const double> residual_rms) {
  EmOptions options;
  options.z_noise_first = kLatentNoise;
  options.torque_noise = kLeastError;
  LatentNoise noise = initial_noise(arm, prepared.recordings, options);
  noise.q = kPositionNoise * kPositionNoise * noise.R;
  noise.friction = friction_left(residual_rms);

  const Eigen::MatrixXd moved = velocity_per_torque(arm, prepared.recordings);
  const Eigen::VectorXd white = moved * white_noise(prepared.recordings),
                        left = moved * noise.friction;
  for (Eigen::Index j = 0; j < white.size(); ++j) {
    double variance = white[j] + left[j];
    for (int repeat = 0; repeat < 3; ++repeat)
      variance = white[j] + remembered(variance, noise.R[j], noise.dt) * left[j];
    noise.v[j] = std::max(kVelocityNoise * variance, noise.v[j]);
  }
  return noise;
}

}  // namespace fricid::estimate
