#include "rigid_body/gears.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "fricid/dynamics/algorithms.hpp"

namespace fricid::estimate {
namespace {

constexpr double kBeliefInGear = 1;        // gain
constexpr double kWorthTryingRatio = 0.3;  // the same of first order, ..
constexpr double kOfBestRatio = 0.2;       // .. and over that of the best joint
constexpr double kLeastRatio = 0.03;       // log of a ratio
constexpr double kCertainRatio = 4;        // standard errors of it
constexpr double kKnownRatio = 0.02;       // largest standard error of it
constexpr double kLargestStepOfRatio = 0.2, kFarthestRatio = 1.5;  // log of the ratio
constexpr double kUsualRatio = 0.5;                                // sd of a weak prior of its log
constexpr int kStepsOfRatio = 8, kHalvingsOfRatio = 3;
constexpr double kSettledRatio = 0.01;  // gain of a last step
constexpr double kDifferenceOfRatio = 1e-6;
constexpr Eigen::Index kRowsPerRatioUnknown = 5;

std::vector<signals::Recording> with_ratio(std::span<const signals::Recording> recordings,
                                           int joint, double ratio) {
  std::vector<signals::Recording> out(recordings.begin(), recordings.end());
  for (signals::Recording& r : out) {
    for (RowMatrix* x : {&r.log.q, &r.narrow.q, &r.narrow.v, &r.narrow.a, &r.wide.q, &r.wide.v})
      x->col(joint) *= ratio;
    for (RowMatrix* x : {&r.log.tau, &r.held_tau, &r.filtered_tau, &r.load}) x->col(joint) /= ratio;
    r.noise_sd[joint] *= ratio;
    r.step[joint] *= ratio;
  }
  return out;
}

/// A regression under a ratio of one joint.
struct UnderRatio {
  std::span<const signals::Recording> logged;  ///< outlive it
  std::vector<signals::Recording> moved;       ///< under the ratio; empty: as logged
  StackedByJoint all;
  Solution plain;

  std::span<const signals::Recording> recordings() const {
    return moved.empty() ? logged : std::span<const signals::Recording>(moved);
  }
  /// Of each joint, in the torque that was logged.
  Eigen::VectorXd sigma(int joint, double ratio) const {
    Eigen::VectorXd out = plain.sigma;
    out[joint] *= ratio;
    return out;
  }
};

UnderRatio under_ratio(std::span<const signals::Recording> logged,
                       std::vector<signals::Recording> moved, const StackedByJoint& stacked) {
  UnderRatio out{logged, std::move(moved), with_curves(stacked), {}};
  out.plain = solve(out.all, out.all.plain);
  return out;
}

/// What the torque of each row lacks per log of the ratio of each joint (N_j x n):
/// d(Y pi)/d(log s), and the torque itself in the rows of the joint.
std::vector<Eigen::MatrixXd> torque_of_ratios(const dynamics::RobotModel& robot,
                                              const UnderRatio& at) {
  const int n = robot.n();
  const auto size = static_cast<std::size_t>(n);
  const Eigen::VectorXd pi = at.all.standard(at.plain.x, robot.parameter_count());
  dynamics::Workspace<double> ws(robot);
  Eigen::RowVectorXd q(n), v(n), a(n), unmoved(n), torque(n);
  const auto torque_of = [&](Eigen::RowVectorXd& out) {
    dynamics::rnea<double>(robot, ws, {pi.data(), static_cast<std::size_t>(pi.size())},
                           {q.data(), size}, {v.data(), size}, {a.data(), size},
                           {out.data(), size});
  };
  std::vector<Eigen::MatrixXd> columns =
      rows_by_sample(at.all, n, [&](int sequence, int sample, RowMatrix& of_sample) {
        const signals::Motion& motion = at.recordings()[static_cast<std::size_t>(sequence)].narrow;
        q = motion.q.row(sample);
        v = motion.v.row(sample);
        a = motion.a.row(sample);
        torque_of(unmoved);
        for (int j = 0; j < n; ++j) {
          for (Eigen::RowVectorXd* x : {&q, &v, &a}) (*x)[j] *= 1 + kDifferenceOfRatio;
          torque_of(torque);
          for (Eigen::RowVectorXd* x : {&q, &v, &a}) (*x)[j] /= 1 + kDifferenceOfRatio;
          of_sample.row(j) = (torque - unmoved) / kDifferenceOfRatio;
        }
      });
  for (int j = 0; j < n; ++j) {
    const auto i = static_cast<std::size_t>(j);
    columns[i].col(j) += at.all.joints[i].y;
  }
  return columns;
}

/// The regression with one ratio beside its columns.
StackedByJoint beside(const StackedByJoint& all, const std::vector<Eigen::MatrixXd>& ratios,
                      int joint) {
  std::vector<Eigen::MatrixXd> column;
  for (const Eigen::MatrixXd& of_joint : ratios) column.emplace_back(of_joint.col(joint));
  return with_columns(all, column);
}

/// A step of the log of a ratio.
struct RatioStep {
  double size = 0, gain = 0;
};
RatioStep ratio_step(const UnderRatio& at, const std::vector<Eigen::MatrixXd>& ratios, int joint) {
  StackedByJoint with = beside(at.all, ratios, joint);
  // the weak prior counts as what joint 0 knows
  with.joints[0].XX(at.all.plain, at.all.plain) += std::pow(at.plain.sigma[0] / kUsualRatio, 2);
  const Solution found = solve(with, with.plain);
  return {found.x[at.all.plain], gain_of(at.plain.sigma, found.sigma)};
}

double error_of_ratio(const UnderRatio& at, const std::vector<Eigen::MatrixXd>& ratios, int joint) {
  const StackedByJoint with = beside(at.all, ratios, joint);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(with.size);
  x.head(at.all.plain) = at.plain.x;
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(with.size, with.size);
  prior(with.size - 1, with.size - 1) = std::pow(kUsualRatio, -2);
  return jackknife_root(with, x, at.plain.sigma, prior).bottomRows(1).norm();
}

}  // namespace

std::optional<OtherGear> find_other_gear(const dynamics::RobotModel& robot,
                                         const StackedByJoint& stacked,
                                         std::span<const signals::Recording> recordings,
                                         const RigidBodyOptions& options) {
  if (robot.coupled() || stacked.rows < kRowsPerRatioUnknown * (stacked.plain + 1)) return {};
  const UnderRatio as_logged = under_ratio(recordings, {}, stacked);
  const std::vector<Eigen::MatrixXd> ratios = torque_of_ratios(robot, as_logged);
  std::vector<double> gains;
  for (int j = 0; j < robot.n(); ++j) gains.push_back(ratio_step(as_logged, ratios, j).gain);
  const double most = std::ranges::max(gains);
  OtherGear best;
  for (int j = 0; j < robot.n(); ++j) {
    if (!(gains[static_cast<std::size_t>(j)] > std::max(kWorthTryingRatio, kOfBestRatio * most)))
      continue;
    double ratio = 1, gain = 0, error = HUGE_VAL;
    UnderRatio now = as_logged;
    for (int step = 0; step < kStepsOfRatio; ++step) {
      const std::vector<Eigen::MatrixXd> here = torque_of_ratios(robot, now);
      error = error_of_ratio(now, here, j);
      double by =
          std::clamp(ratio_step(now, here, j).size, -kLargestStepOfRatio, kLargestStepOfRatio);
      const double before = gain;
      for (int halving = 0; halving <= kHalvingsOfRatio && !(gain > before); ++halving, by /= 2) {
        const double tried = ratio * std::exp(by);
        if (!(std::abs(std::log(tried)) < kFarthestRatio)) continue;
        std::vector<signals::Recording> moved = with_ratio(recordings, j, tried);
        const StackedByJoint all = stack_by_joint(robot, moved, options);
        UnderRatio then = under_ratio(recordings, std::move(moved), all);
        const double gained = gain_of(as_logged.plain.sigma, then.sigma(j, tried));
        if (!(gained > gain)) continue;
        gain = gained;
        ratio = tried;
        now = std::move(then);
      }
      if (gain - before < kSettledRatio) break;
    }
    if (!(gain > std::max(best.gain, kBeliefInGear)) ||
        !(error < kKnownRatio &&
          std::abs(std::log(ratio)) > std::max(kLeastRatio, kCertainRatio * error)))
      continue;
    Eigen::VectorXd held_out = held_out_sigma(now.all, now.all.plain);
    held_out[j] *= ratio;
    if (gain_of(held_out_sigma(as_logged.all, as_logged.all.plain), held_out) > kBeliefInGear)
      best = {j, ratio, ratio * error, gain};
  }
  return best.gain > 0 ? std::optional(best) : std::nullopt;
}

}  // namespace fricid::estimate
