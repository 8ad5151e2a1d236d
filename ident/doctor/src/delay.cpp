// The delay of the torque against the motion.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/system/transmission.hpp"
#include "sight.hpp"

namespace fricid::doctor {
namespace {

using data::RowMatrix;

// Regressors of the torque of joint j at given rows: rigid body, and friction as a smooth function
// of speed and load on either side.
Eigen::MatrixXd regressors(const dynamics::RobotModel& robot, const Sight& s, int j,
                           const std::vector<int>& columns, const std::vector<int>& rows) {
  constexpr Eigen::Index kOfMotor = 4, kOfJoint = 3;
  const auto n = static_cast<std::size_t>(robot.n());
  const auto b = static_cast<Eigen::Index>(columns.size());
  dynamics::Workspace<double> ws(robot);
  const Transmission motors(robot);
  const RowMatrix q = motors.to_motors(s.q), v = motors.to_motors(s.v), a = motors.to_motors(s.a);
  const Eigen::RowVectorXd acting = motors_on(&robot, robot.n(), j);
  Eigen::MatrixXd Y(robot.n(), robot.parameter_count());
  Eigen::MatrixXd X(static_cast<Eigen::Index>(rows.size()),
                    b + kOfJoint + kOfMotor * (acting.array() != 0).count());
  for (Eigen::Index r = 0; r < X.rows(); ++r) {
    const int k = rows[static_cast<std::size_t>(r)];
    dynamics::regressor(robot, ws, {q.row(k).data(), n}, {v.row(k).data(), n}, {a.row(k).data(), n},
                        Y);
    const Eigen::RowVectorXd at_joint = acting * Y;
    for (Eigen::Index c = 0; c < b; ++c) X(r, c) = at_joint[columns[static_cast<std::size_t>(c)]];
    const double load = at_joint * robot.pi;
    X.row(r).segment<kOfJoint>(b) << 1, (v(k, j) > 0 ? 1 : -1) * std::abs(load),
        load * std::abs(load);
    Eigen::Index next = b + kOfJoint;
    for (int m = 0; m < robot.n(); ++m) {
      if (acting[m] == 0) continue;
      const double speed = v(k, m), sign = speed > 0 ? 1 : -1;
      X.row(r).segment<kOfMotor>(next) << sign, speed, sign * std::sqrt(std::abs(speed)),
          speed * speed * speed;
      next += kOfMotor;
    }
  }
  return X;
}

/// What the regressions leave of the torque of each joint, moved back by each delay on a grid.
struct DelayCurves {
  static constexpr int kBlocks = 10;  // of the log, for the error of the delay
  double first, step;                 // of the grid [samples]
  // per joint: sum of squares, (delays, blocks of rows)
  std::vector<Eigen::ArrayXXd> rest;

  int size() const { return static_cast<int>(rest.front().rows()); }
  double delay_of(double i) const { return first + step * i; }

  // Sum over the joints of the log of what is left, without one block; -1: with all.
  Eigen::ArrayXd pooled(int without) const {
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(size());
    for (const Eigen::ArrayXXd& joint : rest) {
      Eigen::ArrayXd total = joint.rowwise().sum();
      if (without >= 0) total -= joint.col(without);
      sum += total.log();
    }
    return sum;
  }
};

/// Lowest point of a curve over a grid, by a parabola through it and its neighbours.
/// @return in steps of the grid; nothing at an end of it
std::optional<double> lowest(const Eigen::ArrayXd& x) {
  Eigen::Index at = 0;
  x.minCoeff(&at);
  if (at == 0 || at == x.size() - 1) return {};
  const double bend = x[at - 1] - 2 * x[at] + x[at + 1];
  return static_cast<double>(at) + (bend > 0 ? 0.5 * (x[at - 1] - x[at + 1]) / bend : 0);
}

DelayCurves delay_curves(const data::Dataset& d, const dynamics::RobotModel& robot,
                         const Motion& motion, const Sight& sight) {
  constexpr double kStep = 0.002, kFinest = 0.5;  // [s], [samples]
  const std::vector<int> columns = dynamics::base_parameters(robot).columns;
  DelayCurves curves{kEarliest / d.dt(), std::max(kStep / d.dt(), kFinest), {}};
  const int steps = static_cast<int>((kLatest - kEarliest) / d.dt() / curves.step) + 1;
  for (int j = 0; j < d.n(); ++j) {
    const std::vector<int>& rows = sight.rows[static_cast<std::size_t>(j)];
    const Eigen::MatrixXd X = regressors(robot, sight, j, columns, rows);
    if (X.rows() < 3 * X.cols()) continue;
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(X);
    const Eigen::MatrixXd Q = qr.householderQ() * Eigen::MatrixXd::Identity(X.rows(), qr.rank());
    Eigen::ArrayXXd rest = Eigen::ArrayXXd::Zero(steps, DelayCurves::kBlocks);
    Eigen::VectorXd tau(X.rows());
    for (int i = 0; i < steps; ++i) {
      const Eigen::VectorXd all = motion.torque(j, curves.delay_of(i));
      for (Eigen::Index r = 0; r < X.rows(); ++r) tau[r] = all[rows[static_cast<std::size_t>(r)]];
      const Eigen::VectorXd left = tau - Q * (Q.transpose() * tau);
      for (Eigen::Index r = 0; r < X.rows(); ++r)
        rest(i, r * DelayCurves::kBlocks / X.rows()) += left[r] * left[r] + 1e-12 * tau[r] * tau[r];
    }
    if (rest.allFinite() && (rest.rowwise().sum() > 0).all()) curves.rest.push_back(rest);
  }
  return curves;
}

}  // namespace

void check_delay(const data::Dataset& d, const dynamics::RobotModel& robot, const Motion& motion,
                 const Sight& sight, Findings& findings) {
  // A torque held from t_k on lags by 0, one measured at t_k seems to lag by half a sample.
  constexpr double kNone = 0.5;
  constexpr double kSmallest = 0.5;  // [samples] beyond that: worth a word
  constexpr double kCertain = 3;     // standard errors
  constexpr double kEarly = 0.01;    // [s] by which the torque of an elastic gear may lead
  constexpr double kClear = 0.035;   // log of the factor of the residuals' variance
  const DelayCurves curves = delay_curves(d, robot, motion, sight);
  if (curves.rest.empty()) return;
  const Eigen::ArrayXd pooled = curves.pooled(-1);
  double undelayed = std::numeric_limits<double>::infinity();
  for (int i = 0; i < curves.size(); ++i)
    if (std::abs(curves.delay_of(i) - kNone / 2) <= std::max(kNone / 2, curves.step / 2))
      undelayed = std::min(undelayed, pooled[i]);
  const double clear = (undelayed - pooled.minCoeff()) / static_cast<double>(curves.rest.size());
  if (clear < kClear) return;

  Finding finding{.name = "delay",
                  .signal = "tau",
                  .begin_s = d.t[0],
                  .end_s = d.t[d.length() - 1],
                  .unit = "samples"};
  const std::optional<double> best = lowest(pooled);
  if (!best) {
    finding.name = "delay_unknown";
    finding.size = 1e3 * (pooled[0] < pooled[pooled.size() - 1] ? kEarliest : kLatest);
    finding.unit = "ms, the end of the search";
    findings.push_back(finding);
    return;
  }
  // error by the jackknife over blocks of time
  double sum = 0, squares = 0;
  for (int block = 0; block < DelayCurves::kBlocks; ++block) {
    const double without = lowest(curves.pooled(block)).value_or(*best + curves.size());
    sum += without - *best;
    squares += (without - *best) * (without - *best);
  }
  const double mean = sum / DelayCurves::kBlocks;
  const double error =
      curves.step * std::sqrt((DelayCurves::kBlocks - 1) *
                              std::max(0.0, squares / DelayCurves::kBlocks - mean * mean));
  finding.size = curves.delay_of(*best);
  const double beyond = finding.size - std::clamp(finding.size, 0.0, kNone);
  const double least = beyond < 0 ? std::max(kSmallest, kEarly / d.dt()) : kSmallest;
  if (std::abs(beyond) < std::max(least, kCertain * error)) return;
  finding.unit = fmt::format("samples, {:.3g} ms, standard error {:.2g} ms",
                             1e3 * d.dt() * finding.size, 1e3 * d.dt() * error);
  findings.push_back(finding);
}

}  // namespace fricid::doctor
