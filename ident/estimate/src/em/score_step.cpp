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

LatentFrictionModel model_of(const Likelihood& of, const Arm& arm, std::size_t r) {
  return {arm, of.recordings[r], of.noise, of.starts[r], of.step};
}

smc::RowMatrix observed(const Likelihood& of, std::size_t r) {
  return of.recordings[r].log.q.topRows(of.split.train_end[r]);
}

}  // namespace

InnovationScore Likelihood::score(const Arm& arm) const {
  std::vector<InnovationScore> parts(recordings.size());
  parallel_for(static_cast<int>(parts.size()), jobs, [&](int i) {
    const auto r = static_cast<std::size_t>(i);
    LatentFrictionModel model = model_of(*this, arm, r);
    parts[r] = innovation_score(model, observed(*this, r));
  });
  InnovationScore& sum = parts[0];
  for (std::size_t r = 1; r < parts.size(); ++r) {
    sum.log_likelihood += parts[r].log_likelihood;
    sum.score += parts[r].score;
    sum.information += parts[r].information;
    sum.failed = sum.failed || parts[r].failed;
  }
  return std::move(sum);
}

std::vector<Eigen::VectorXd> Likelihood::by_joint(std::span<const Arm> arms) const {
  const std::size_t count = recordings.size();
  std::vector<Eigen::VectorXd> parts(arms.size() * count);
  parallel_for(static_cast<int>(parts.size()), jobs, [&](int i) {
    const auto k = static_cast<std::size_t>(i), r = k % count;
    LatentFrictionModel model = model_of(*this, arms[k / count], r);
    parts[k] = innovation_likelihood(model, observed(*this, r));
  });
  std::vector<Eigen::VectorXd> sums;
  for (std::size_t a = 0; a < arms.size(); ++a) {
    sums.push_back(parts[a * count]);
    for (std::size_t r = 1; r < count; ++r) sums[a] += parts[a * count + r];
    if (!sums[a].allFinite()) sums[a].setConstant(-std::numeric_limits<double>::infinity());
  }
  return sums;
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
