#include "em/score_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "fricid/base/parallel.hpp"

namespace fricid::estimate {
namespace {

constexpr int kAttempts = 5;
constexpr double kLongestStep = 0.3;  // of a coordinate
constexpr double kPull = 1;           // to where a step starts, nat per unit of a coordinate

/// compute(model, observations) for every recording, one per task.
template <class Result, class Compute>
std::vector<Result> for_recordings(const Likelihood& of, const Arm& arm, Compute compute) {
  std::vector<Result> parts(of.recordings.size());
  parallel_for(static_cast<int>(parts.size()), of.jobs, [&](int i) {
    const auto r = static_cast<std::size_t>(i);
    LatentFrictionModel model(arm, of.recordings[r], of.noise, of.starts[r], of.step);
    parts[r] = compute(model, of.recordings[r].q_measured.topRows(of.split.train_end[r]));
  });
  return parts;
}

}  // namespace

InnovationScore Likelihood::score(const Arm& arm) const {
  auto parts = for_recordings<InnovationScore>(*this, arm, innovation_score);
  InnovationScore& sum = parts[0];
  for (std::size_t r = 1; r < parts.size(); ++r) {
    sum.log_likelihood += parts[r].log_likelihood;
    sum.score += parts[r].score;
    sum.information += parts[r].information;
    sum.failed = sum.failed || parts[r].failed;
  }
  return std::move(sum);
}

double Likelihood::value(const Arm& arm) const {
  double sum = 0;
  for (const double part : for_recordings<double>(*this, arm, innovation_likelihood)) sum += part;
  return std::isfinite(sum) ? sum : -std::numeric_limits<double>::infinity();
}

void climb_by_score(const Likelihood& likelihood, const ArmCoordinates& coordinates,
                    double& damping, Arm& arm, Eigen::VectorXd& c) {
  const InnovationScore here = likelihood.score(arm);
  if (here.failed) return;
  const Eigen::MatrixXd to_c = coordinates.jacobian(
      c, arm.robot.pi.size(), static_cast<Eigen::Index>(arm.friction.theta.size()));
  const Eigen::MatrixXd information =
      to_c.transpose() * here.information.selfadjointView<Eigen::Lower>() * to_c;
  const Eigen::VectorXd score = to_c.transpose() * here.score;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Eigen::MatrixXd H = information;
    H.diagonal() *= 1 + damping;
    H.diagonal().array() += kPull;
    const Eigen::VectorXd step = H.ldlt().solve(score);
    Eigen::VectorXd trial = c + step.cwiseMax(-kLongestStep).cwiseMin(kLongestStep);
    trial = trial.cwiseMax(coordinates.lower()).cwiseMin(coordinates.upper());
    coordinates.apply(trial, arm);
    const bool risen = likelihood.value(arm) > here.log_likelihood;
    damping = std::clamp(risen ? damping / 5 : damping * 10, 1e-9, 1e6);
    if (risen) {
      c = trial;
      return;
    }
  }
  coordinates.apply(c, arm);
}

}  // namespace fricid::estimate
