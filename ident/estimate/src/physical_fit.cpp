#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fricid/dynamics/physical_inertia.hpp"
#include "fricid/estimate/least_squares.hpp"

namespace fricid::estimate {
namespace {

constexpr double kSmallestArmature = 1e-9;  // [kg m^2]
constexpr int kMaxIterations = 200;
constexpr double kGradientTolerance =
    1e-10;  // decrease predicted by a step, relative to the cost scale

// pi as a function of free coordinates x: log-Cholesky (10 per link), log armature, linear torques.
struct Chart {
  int n, linear;

  Eigen::VectorXd to_physical(const Eigen::VectorXd& x, Eigen::MatrixXd* jacobian) const {
    Eigen::VectorXd pi = x;
    if (jacobian) jacobian->setIdentity(x.size(), x.size());
    for (int i = 0; i < n; ++i) {
      Eigen::Matrix<double, 10, 10> block;
      pi.segment<10>(10 * i) =
          dynamics::inertia_from_log_cholesky(x.segment<10>(10 * i), jacobian ? &block : nullptr);
      if (jacobian) jacobian->block<10, 10>(10 * i, 10 * i) = block;
      const int k = 10 * n + i;
      pi[k] = std::exp(x[k]);
      if (jacobian) (*jacobian)(k, k) = pi[k];
    }
    return pi;
  }

  Eigen::VectorXd from_physical(const Eigen::VectorXd& pi) const {
    Eigen::VectorXd x = pi;
    for (int i = 0; i < n; ++i) {
      x.segment<10>(10 * i) = dynamics::log_cholesky_from_inertia(pi.segment<10>(10 * i));
      x[10 * n + i] = std::log(std::max(pi[10 * n + i], kSmallestArmature));
    }
    return x;
  }
};

}  // namespace

Eigen::VectorXd fit_physical_inertia(const dynamics::RobotModel& robot, const Eigen::MatrixXd& A,
                                     const Eigen::VectorXd& b, const Eigen::VectorXd& start) {
  const Chart chart{robot.n(), static_cast<int>(robot.linear_torques.size())};
  const auto cost = [&](const Eigen::VectorXd& pi) { return pi.dot(0.5 * (A * pi) - b); };

  Eigen::VectorXd x = chart.from_physical(start);
  Eigen::MatrixXd J;
  Eigen::VectorXd pi = chart.to_physical(x, &J);
  double value = cost(pi), damping = 1e-6;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Eigen::VectorXd gradient = J.transpose() * (A * pi - b);
    const Eigen::MatrixXd H = J.transpose() * A * J;
    // Scale to a unit diagonal, damp, and accept the first step that lowers the cost.
    const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
    bool lowered = false;
    double predicted = 0;
    while (damping < 1e12) {
      Eigen::MatrixXd damped = scaled;
      damped.diagonal().array() += damping;
      const Eigen::VectorXd step = -(
          scale.asDiagonal() * damped.ldlt().solve(Eigen::VectorXd(scale.asDiagonal() * gradient)));
      predicted = -gradient.dot(step);
      Eigen::MatrixXd trial_jacobian;
      const Eigen::VectorXd trial = x + step;
      const Eigen::VectorXd trial_pi = chart.to_physical(trial, &trial_jacobian);
      const double trial_value = cost(trial_pi);
      if (trial_pi.allFinite() && trial_value < value) {
        x = trial, pi = trial_pi, J = trial_jacobian, value = trial_value;
        damping = std::max(damping / 10, 1e-15);
        lowered = true;
        break;
      }
      damping *= 10;
    }
    if (!lowered || predicted < kGradientTolerance * (1 + 1e-12 * std::abs(value))) break;
  }
  return pi;
}

}  // namespace fricid::estimate
