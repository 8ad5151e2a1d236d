// The delay of the torque against the motion.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/lowest_point.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/signals/periods.hpp"
#include "fricid/signals/speed_range.hpp"
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

constexpr double kChance = 2.5;  // [s^2] over the square of those of sliding: gains of friction
constexpr int kFolds = 10;       // stretches of the log, each left out in turn

/// Squares that regressions leave of the torque of each joint, moved back by each delay on a grid.
struct DelayCurves {
  double first, step;  // of the grid [samples]
  double seconds = 0;  // of motion that does not repeat in which a joint slides, of the longest
  /// Per joint (delays, stretches): of regressions on the whole log, and on the other stretches.
  std::vector<Eigen::ArrayXXd> fitted, held_out;
  std::vector<int> joint;  ///< of each curve

  int joints() const { return static_cast<int>(fitted.size()); }
  int size() const { return static_cast<int>(fitted.front().rows()); }
  double delay_of(double i) const { return first + step * i; }
};

// Mean over the joints of the log of what is left, without one stretch; -1: of all.
Eigen::ArrayXd pooled(const std::vector<Eigen::ArrayXXd>& curves, int without) {
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(curves.front().rows());
  for (const Eigen::ArrayXXd& joint : curves) {
    Eigen::ArrayXd total = joint.rowwise().sum();
    if (without >= 0) total -= joint.col(without);
    sum += total.log();
  }
  return sum / static_cast<double>(curves.size());
}

// Standard error of a number that is computed without one stretch at a time, by the jackknife.
template <class Number>
double jackknife(const Number& without) {
  double sum = 0, squares = 0;
  for (int fold = 0; fold < kFolds; ++fold) {
    const double x = without(fold);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kFolds;
  return std::sqrt((kFolds - 1) * std::max(0.0, squares / kFolds - mean * mean));
}

/// Squares (columns of T, stretches) that regressions of T on X leave.
struct Left {
  Eigen::ArrayXXd fitted, held_out;  ///< of regressions on all rows, and on the other stretches

  bool is_usable() const {
    return fitted.allFinite() && held_out.allFinite() && (fitted.rowwise().sum() > 0).all();
  }
};

Left left_by(Eigen::MatrixXd X, const Eigen::MatrixXd& T) {
  constexpr double kRidge = 1e-6;  // of columns of unit length: what the rest of a log leaves open
  const Eigen::VectorXd size = X.colwise().norm().transpose().cwiseMax(1e-300);
  X = (X * size.cwiseInverse().asDiagonal()).eval();
  Eigen::MatrixXd H = X.transpose() * X;
  H.diagonal().array() += kRidge;
  const Eigen::MatrixXd G = X.transpose() * T;
  const Eigen::MatrixXd of_all = H.ldlt().solve(G);
  Left left{Eigen::ArrayXXd(T.cols(), kFolds), Eigen::ArrayXXd(T.cols(), kFolds)};
  for (int fold = 0; fold < kFolds; ++fold) {
    const Eigen::Index begin = X.rows() * fold / kFolds,
                       count = X.rows() * (fold + 1) / kFolds - begin;
    const Eigen::MatrixXd Xf = X.middleRows(begin, count), Tf = T.middleRows(begin, count);
    const Eigen::MatrixXd others = H - Xf.transpose() * Xf;
    const Eigen::MatrixXd of_others = others.ldlt().solve(Eigen::MatrixXd(G - Xf.transpose() * Tf));
    const auto squares = [&](const Eigen::MatrixXd& x) {
      const Eigen::MatrixXd rest = Tf - Xf * x;
      return Eigen::ArrayXd(
          (rest.colwise().squaredNorm() + 1e-12 * Tf.colwise().squaredNorm()).transpose().array());
    };
    left.fitted.col(fold) = squares(of_all);
    left.held_out.col(fold) = squares(of_others);
  }
  return left;
}

/// Lowest point of a curve over a grid (`lowest_point`).
/// @return in steps of the grid; nothing at an end of it
std::optional<double> lowest(const Eigen::ArrayXd& x) {
  const double at = lowest_point({x.data(), static_cast<std::size_t>(x.size())});
  if (at == 0 || at == static_cast<double>(x.size() - 1)) return {};
  return at;
}

// Standard error of the lowest point `best` of pooled curves, from stretches of the log.
double error_of_lowest(const std::vector<Eigen::ArrayXXd>& curves, double best) {
  return jackknife([&](int fold) {
    return lowest(pooled(curves, fold)).value_or(best + static_cast<double>(curves[0].rows()));
  });
}

// Whether a curve of all joints but one has its lowest point inside the grid.
bool is_of_one_joint(const DelayCurves& curves) {
  for (int j = 0; curves.joints() > 2 && j < curves.joints(); ++j) {
    std::vector<Eigen::ArrayXXd> others = curves.fitted;
    others.erase(others.begin() + j);
    if (lowest(pooled(others, -1))) return true;
  }
  return false;
}

/// A number and its standard error.
struct Estimate {
  double value, error;
};

/// The delay that the joints have in common, in steps of the grid: the mean of their own, weighted
/// by their standard errors. Its error is that of the mean times the root of chi^2 per degree of
/// freedom (Birge, Phys. Rev. 40, 1932), since friction lags by another time in each joint.
/// @return nothing where fewer than two joints have one
std::optional<Estimate> common_delay(const DelayCurves& curves) {
  double weight = 0, sum = 0, squares = 0;
  int count = 0;
  for (const Eigen::ArrayXXd& joint : curves.fitted) {
    const std::vector<Eigen::ArrayXXd> one{joint};
    const std::optional<double> own = lowest(pooled(one, -1));
    if (!own) continue;
    const double error = error_of_lowest(one, *own);
    const double w = 1 / std::max(error * error, 1e-12);
    weight += w;
    sum += w * *own;
    squares += w * *own * *own;
    ++count;
  }
  if (count < 2) return {};
  const double chi_squared = std::max(0.0, squares - sum * sum / weight);
  return Estimate{sum / weight, std::sqrt(chi_squared / (count - 1) / weight)};
}

/// The only joint whose torque is late, or leads, by far while those of all others agree.
struct LateJoint {
  int joint = 0;
  Estimate delay;  ///< in steps of the grid
};

/// @param undelayed  point of the grid that is no delay
std::optional<LateJoint> late_joint(const DelayCurves& curves, Eigen::Index undelayed, double dt) {
  constexpr double kApart = 0.016;  // [s] from the mean of the others: friction lags by up to 0.015
  constexpr double kAgree = 0.005;  // [s] by which these differ from their mean
  constexpr double kLongest =
      0.1;  // [s] periodic motion shifts by more where friction is all there is
  constexpr double kCertainOfOne = 5;
  constexpr double kClearOfOne = 0.5;  // log of the factor of its residuals' variance
  const double step_s = curves.step * dt;
  struct Own {
    std::size_t curve;
    double delay;
  };
  std::vector<Own> own;  // of joints that have one inside the search
  for (std::size_t i = 0; i < curves.fitted.size(); ++i)
    if (const auto lowest_of_one = lowest(pooled({curves.fitted[i]}, -1)))
      own.push_back({i, *lowest_of_one});
  if (own.size() < 3 || 2 * own.size() < curves.fitted.size()) return {};
  for (const Own& one : own) {
    double mean = 0, apart = 0;
    for (const Own& other : own)
      if (other.curve != one.curve) mean += other.delay / static_cast<double>(own.size() - 1);
    for (const Own& other : own)
      if (other.curve != one.curve) apart = std::max(apart, std::abs(other.delay - mean));
    const double error = error_of_lowest({curves.fitted[one.curve]}, one.delay);
    const Eigen::ArrayXd held_out = curves.held_out[one.curve].rowwise().sum();
    const double gain = std::log(held_out[undelayed] / held_out.minCoeff());
    if (std::abs(kEarliest + one.delay * step_s) < kLongest && apart * step_s < kAgree &&
        gain > std::max(kClearOfOne, kChance / (curves.seconds * curves.seconds)) &&
        std::abs(one.delay - mean) > std::max(kApart / step_s, kCertainOfOne * error))
      return LateJoint{curves.joint[one.curve], {one.delay, error}};
  }
  return {};
}

/// Whether joint j slides at several speeds, without which there is no delay to be found.
bool has_speeds(const Sight& sight, int j) {
  std::vector<double> speeds;
  for (const int r : sight.rows[static_cast<std::size_t>(j)])
    speeds.push_back(std::abs(sight.v(r, j)));
  return !signals::speed_range(speeds).is_one();
}

DelayCurves delay_curves(const data::Dataset& d, const dynamics::RobotModel& robot,
                         const Motion& motion, const Sight& sight) {
  constexpr double kStep = 0.002, kFinest = 0.5;  // [s], [samples]
  const std::vector<int> columns = dynamics::base_parameters(robot).columns;
  DelayCurves curves{.first = kEarliest / d.dt(),
                     .step = std::max(kStep / d.dt(), kFinest),
                     .fitted = {},
                     .held_out = {},
                     .joint = {}};
  const int steps = static_cast<int>((kLatest - kEarliest) / d.dt() / curves.step) + 1;
  const int period = signals::period_of(d.q, d.dt());
  const int whole = period > 0 ? period : d.length();
  const auto phase = [&](int row) { return motion.samples[static_cast<std::size_t>(row)] % whole; };
  for (int j = 0; j < d.n(); ++j) {
    // of a cycle that repeats a stretch is left out in every pass
    std::vector<int> rows = sight.rows[static_cast<std::size_t>(j)];
    std::ranges::stable_sort(rows, {}, phase);
    const Eigen::MatrixXd X = regressors(robot, sight, j, columns, rows);
    if (X.rows() < 3 * X.cols() || !has_speeds(sight, j)) continue;
    Eigen::MatrixXd T(X.rows(), steps);
    for (int i = 0; i < steps; ++i) {
      const Eigen::VectorXd all = motion.torque(j, curves.delay_of(i));
      for (Eigen::Index r = 0; r < X.rows(); ++r) T(r, i) = all[rows[static_cast<std::size_t>(r)]];
    }
    curves.seconds =
        std::max(curves.seconds, whole * d.dt() * static_cast<double>(X.rows()) / motion.length());
    Left left = left_by(X, T);
    if (!left.is_usable()) continue;
    curves.joint.push_back(j);
    curves.fitted.push_back(std::move(left.fitted));
    curves.held_out.push_back(std::move(left.held_out));
  }
  return curves;
}

/// The corner [Hz] of a filter through which the torque went, nothing where a delay explains as
/// much. A filter T + a T' + b T'' = p is late by a where motion is slow, and takes fast torque
/// besides. Of regressions that have T' and T'' of the late torque beside the motion, those of a
/// filtered one explain most with no delay, those of one that is only late with all of it.
/// @param late  samples by which the torque seems to be late
std::optional<double> corner_of_filter(const data::Dataset& d, const dynamics::RobotModel& robot,
                                       const Motion& motion, const Sight& sight, double late) {
  constexpr int kSteps = 10;          // delays that are tried, up to `late`
  constexpr double kOfFilter = 0.35;  // of `late`: more is a delay
  constexpr double kClear = 0.5;      // log of the factor of the residuals' variance
  constexpr double kCertain = 2;      // standard errors of it
  const std::vector<int> columns = dynamics::base_parameters(robot).columns;
  std::vector<Eigen::ArrayXXd> held_out;
  for (int j = 0; j < d.n(); ++j) {
    const std::vector<int>& rows = sight.rows[static_cast<std::size_t>(j)];
    Eigen::MatrixXd X = regressors(robot, sight, j, columns, rows);
    const Eigen::Index own = X.cols();
    if (X.rows() < 3 * (own + 2) || !has_speeds(sight, j)) continue;
    X.conservativeResize(Eigen::NoChange, own + 2);
    Eigen::ArrayXXd of_joint(kSteps + 1, kFolds);
    bool is_usable = true;
    for (int i = 0; i <= kSteps; ++i) {
      const Eigen::MatrixX3d all = motion.torque_and_rates(j, late * i / kSteps);
      Eigen::VectorXd T(X.rows());
      for (Eigen::Index r = 0; r < X.rows(); ++r) {
        const auto row = all.row(rows[static_cast<std::size_t>(r)]);
        T[r] = row[0];
        X.row(r).tail<2>() = row.tail<2>();
      }
      const Left left = left_by(X, T);
      is_usable = is_usable && left.is_usable();
      of_joint.row(i) = left.held_out.row(0);
    }
    if (is_usable) held_out.push_back(of_joint);
  }
  if (held_out.empty()) return {};
  const Eigen::ArrayXd left = pooled(held_out, -1);
  Eigen::Index least = 0;
  left.minCoeff(&least);
  const auto gain = [&](const Eigen::ArrayXd& x) { return x[kSteps] - x[least]; };
  if (static_cast<double>(least) > kOfFilter * kSteps || gain(left) < kClear ||
      gain(left) < kCertain * jackknife([&](int fold) { return gain(pooled(held_out, fold)); }))
    return {};
  return 1 / (2 * std::numbers::pi * late * d.dt());
}

}  // namespace

void check_delay(const data::Dataset& d, const dynamics::RobotModel& robot, const Motion& motion,
                 const Sight& sight, Findings& findings) {
  // A torque held from t_k on lags by 0, one measured at t_k seems to lag by half a sample.
  constexpr double kNone = 0.5;
  // beyond that, worth a word: in samples, and in seconds by which friction shifts the estimate,
  // at most and by its standard deviation
  constexpr double kSmallest = 0.5, kFriction = 0.002, kShift = 0.001;
  // standard errors; ripples, and filters without phase, make a torque seem to lead
  constexpr double kCertain = 3, kCertainLead = 4;
  constexpr double kBetter = 1;     // standard errors of what held-out stretches gain
  constexpr double kBeyond = 5;     // the same, where the best shift is an end of the search
  constexpr double kEarly = 0.01;   // [s] by which the torque of an elastic gear may lead
  constexpr double kClear = 0.035;  // log of the factor of the residuals' variance
  // the same of a torque that leads: that of one joint after the other seems to, from break-away on
  constexpr double kChanceOfLead = 30;
  constexpr double kOfSize = 3;  // [1/s] gain by a delay of a second: ripples gain a little by any
  const DelayCurves curves = delay_curves(d, robot, motion, sight);
  if (curves.joints() == 0) return;
  const Eigen::ArrayXd judged = pooled(curves.held_out, -1);
  Eigen::Index least_left = 0, undelayed = -1;
  judged.minCoeff(&least_left);
  for (int i = 0; i < curves.size(); ++i)
    if (std::abs(curves.delay_of(i) - kNone / 2) <= std::max(kNone / 2, curves.step / 2) &&
        (undelayed < 0 || judged[i] < judged[undelayed]))
      undelayed = i;
  if (undelayed < 0) return;  // a sample is longer than the search
  Finding finding{.kind = FindingKind::kDelay,
                  .signal = "tau",
                  .begin_s = d.t[0],
                  .end_s = d.t[d.length() - 1],
                  .unit = "samples"};
  const auto say = [&](double samples, double error_s) {
    finding.size = samples;
    finding.unit = fmt::format("samples, {:.3g} ms, standard error {:.2g} ms",
                               1e3 * d.dt() * samples, 1e3 * std::hypot(error_s, kShift));
    findings.push_back(finding);
  };
  if (const std::optional<LateJoint> late = late_joint(curves, undelayed, d.dt())) {
    finding.joint = late->joint;
    say(curves.delay_of(late->delay.value), curves.step * d.dt() * late->delay.error);
    return;
  }
  const double gain = judged[undelayed] - judged[least_left];
  const double gain_error = jackknife([&](int fold) {
    const Eigen::ArrayXd without = pooled(curves.held_out, fold);
    return without[undelayed] - without[least_left];
  });
  if (gain < std::max(kClear, kBetter * gain_error)) return;

  const Eigen::ArrayXd left = pooled(curves.fitted, -1);
  const std::optional<double> best = lowest(left);
  const double gained = left[undelayed] - left.minCoeff();
  if (best && gained < std::max(kChance / (curves.seconds * curves.seconds),
                                kOfSize * d.dt() * std::abs(curves.delay_of(*best))))
    return;
  if (!best) {
    if (gain < kBeyond * gain_error || is_of_one_joint(curves)) return;
    const bool leads = left[0] < left[left.size() - 1];
    if (leads && gain < kChanceOfLead / (curves.seconds * curves.seconds)) return;
    finding.kind = FindingKind::kDelayUnknown;
    finding.size = 1e3 * (leads ? kEarliest : kLatest);
    finding.unit = "ms, the end of the search";
    findings.push_back(finding);
    return;
  }
  const Estimate common = common_delay(curves).value_or(Estimate{*best, 0});
  const double error = curves.step * std::max(error_of_lowest(curves.fitted, *best), common.error);
  const double samples = curves.delay_of(common.value);
  const double beyond = samples - std::clamp(samples, 0.0, kNone);
  const double least = std::max(kSmallest, (beyond < 0 ? kEarly : kFriction) / d.dt());
  const double certain = beyond < 0 ? kCertainLead : kCertain;
  if (std::abs(beyond) < std::max(least, certain * error)) return;
  if (beyond > 0)
    if (const auto corner = corner_of_filter(d, robot, motion, sight, samples)) {
      finding.kind = FindingKind::kLowPass;
      finding.size = *corner;
      finding.unit = "Hz, about: the corner";
      findings.push_back(finding);
      return;
    }
  say(samples, d.dt() * error);
}

}  // namespace fricid::doctor
