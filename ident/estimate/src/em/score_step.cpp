#include "em/score_step.hpp"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/optimise/damped_step.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPull = 1;  // to where a step starts, nat per unit of a coordinate

/// compute(model, observations) for every recording, one per task.
template <class Result, class Compute>
std::vector<Result> for_recordings(const Likelihood& of, const Arm& arm, Compute compute) {
  std::vector<Result> parts(of.recordings.size());
  parallel_for(static_cast<int>(parts.size()), of.jobs, [&](int i) {
    const auto r = static_cast<std::size_t>(i);
    LatentFrictionModel model(arm, of.recordings[r], of.noise, of.starts[r], of.step);
    parts[r] = compute(model, of.recordings[r].log.q.topRows(of.split.train_end[r]));
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

void climb_by_score(const Likelihood& likelihood, double& damping, ArmPoint& point) {
  const InnovationScore here = likelihood.score(point.arm());
  if (here.failed) return;
  const Eigen::MatrixXd to_c = point.jacobian();
  const optimise::Quadratic minus_log_likelihood{
      -here.log_likelihood, -(to_c.transpose() * here.score),
      to_c.transpose() * here.information.selfadjointView<Eigen::Lower>() * to_c};
  const auto at = [&](const Eigen::VectorXd& c) {
    ArmPoint trial = point;
    trial.move_to(c);
    return -likelihood.value(trial.arm());
  };
  Eigen::VectorXd c = point.c();
  double value = minus_log_likelihood.value;
  if (damped_step(minus_log_likelihood, point.coordinates().box(), {.ridge = kPull}, at, damping, c,
                  value)
          .lowered)
    point.move_to(c);
}

}  // namespace fricid::estimate
