#include "fricid/evaluate/torque_error.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "fricid/base/rng.hpp"
#include "fricid/evaluate/metrics.hpp"
#include "fricid/evaluate/statistics.hpp"
#include "planned_rollouts.hpp"
#include "streams.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kFirstShare = 0.01;     // first sd, share of the rms torque
constexpr double kLeastShare = 1e-6;     // least sd
constexpr int kFirst = 3, kFurther = 1;  // iterations for the first correlation time, the others
constexpr int kLeaps[] = {4, 2};
constexpr double kLeapShare = 0.1;

/// Root mean square of the measured torque per joint [N m].
std::vector<double> torque_rms(std::span<const Trajectory> recordings) {
  std::vector<double> rms(static_cast<std::size_t>(recordings.front().data.n()));
  for (std::size_t j = 0; j < rms.size(); ++j) {
    double squares = 0, rows = 0;
    for (const Trajectory& recording : recordings) {
      squares += held_torque(recording.data).col(static_cast<Eigen::Index>(j)).squaredNorm();
      rows += recording.data.length();
    }
    rms[j] = std::sqrt(squares / rows);
  }
  return rms;
}

/// An arm that was fitted, and recordings to judge it on.
struct Fitted {
  const Arm* arm;
  std::span<const Trajectory> recordings;
};

/// Values per joint, [joint][horizons from the first sample, then those of later starts]. NaN where
/// there is no such rollout.
using Table = std::vector<std::vector<double>>;

/// log(m / S), NaN where one of them is not known or 0.
Table log_ratio(const Table& m, const Table& S) {
  Table ratio = m;
  for (std::size_t j = 0; j < m.size(); ++j)
    for (std::size_t h = 0; h < m[j].size(); ++h) {
      const double value = std::log(m[j][h] / S[j][h]);
      ratio[j][h] = std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
    }
  return ratio;
}

/// Whether every value that is known is below a share of the other's.
bool is_below(const Table& small, double share, const Table& large) {
  for (std::size_t j = 0; j < small.size(); ++j)
    for (std::size_t h = 0; h < small[j].size(); ++h)
      if (small[j][h] > share * large[j][h]) return false;
  return true;
}

/// Open loops of fits on recordings, with and without a torque error. Fits that left recordings out
/// differ in parameters alone: their loops share lanes.
class OpenLoops {
 public:
  OpenLoops(const data::ModelFile& model, const dynamics::RobotModel& known,
            std::span<const Fitted> fits, const EvaluateOptions& options, int jobs)
      : options_(options),
        jobs_(jobs),
        seed_(static_cast<std::uint64_t>(model.seed)),
        step_{options.substeps, 1} {
    for (const Fitted& fit : fits) {
      const Plan plan = make_plan(fit.recordings, options);
      std::vector<Driven>& driven = driven_.emplace_back();
      data::ModelFile other = model;
      other.arm = *fit.arm;
      for (std::size_t i = 0; i < fit.recordings.size(); ++i)
        driven.push_back(drive(other, known, fit.recordings[i], plan.by_trajectory[i]));
      const std::vector<OpenLoop> loops = open_loops(*fit.arm, fit.recordings, plan, driven);
      loops_.insert(loops_.end(), loops.begin(), loops.end());
    }
    undisturbed_ = roll_out(loops_, 0);
    errors_ = means([&](std::size_t i, int steps) {
      return horizon_error(undisturbed_[i], *loops_[i].trajectory, steps).q_mse_joint;
    });
    choose_leap();
  }

  /// By which `spread` rolls out.
  int leap() const { return step_.leap; }

  /// m [rad^2].
  const Table& errors() const { return errors_; }

  /// S [rad^2].
  Table spread(const TorqueError& error) const {
    std::vector<RowMatrix> disturbance;
    for (std::size_t i = 0; i < loops_.size(); ++i)
      disturbance.push_back(draw_torque_error(error, loops_[i].trajectory->data.dt(),
                                              loops_[i].start.steps + 1, seed_,
                                              stream_of(Purpose::kFit, i, 0)));
    std::vector<OpenLoop> loops = loops_;
    for (std::size_t i = 0; i < loops.size(); ++i) loops[i].disturbance = &disturbance[i];
    return distance(roll_out(loops, error.slow_gain), undisturbed_);
  }

 private:
  /// Leaps instead of single steps, the longest that move the undisturbed loops by less than
  /// kLeapShare of their own errors: what a torque error moves them by, the difference of two such
  /// loops, changes less.
  void choose_leap() {
    for (const int leap : kLeaps) {
      if (step_.substeps % leap != 0) continue;
      step_.leap = leap;
      std::vector<Rollout> by_leaps = roll_out(loops_, 0);
      if (is_below(distance(by_leaps, undisturbed_), kLeapShare, errors_)) {
        undisturbed_ = std::move(by_leaps);
        return;
      }
    }
    step_.leap = 1;
  }

  std::vector<Rollout> roll_out(std::span<const OpenLoop> loops, double slow_gain) const {
    return roll_out_many(loops, {step_, options_.diverged_rad, slow_gain}, jobs_);
  }

  /// Mean squares of the distance of two sets of rollouts.
  Table distance(std::span<const Rollout> a, std::span<const Rollout> b) const {
    return means([&](std::size_t i, int steps) {
      std::vector<double> squares(static_cast<std::size_t>(a[i].q.cols()));
      for (Eigen::Index k = 0; k <= steps; ++k)
        for (std::size_t j = 0; j < squares.size(); ++j) {
          const auto c = static_cast<Eigen::Index>(j);
          const double apart = a[i].q(k, c) - b[i].q(k, c);
          squares[j] += apart * apart / (steps + 1);
        }
      return squares;
    });
  }

  /// Means of squares(start, steps) (n) over the starts that reach a horizon.
  template <class Squares>
  Table means(const Squares& squares) const {
    Table table(static_cast<std::size_t>(loops_.front().arm->robot.n()));
    for (const bool from_first : {true, false})
      for (const double h : options_.horizons_s) {
        std::vector<std::vector<double>> values(table.size());
        for (std::size_t i = 0; i < loops_.size(); ++i) {
          const data::Dataset& data = loops_[i].trajectory->data;
          const int steps = horizon_steps(h, data.dt(), data.length());
          if ((loops_[i].start.begin == 0) != from_first || steps > loops_[i].start.steps) continue;
          const std::vector<double> of_start = squares(i, steps);
          for (std::size_t j = 0; j < table.size(); ++j) values[j].push_back(of_start[j]);
        }
        for (std::size_t j = 0; j < table.size(); ++j) table[j].push_back(mean(values[j]));
      }
    return table;
  }

  const EvaluateOptions& options_;
  int jobs_;
  std::uint64_t seed_;
  std::deque<std::vector<Driven>> driven_;  // per fit; the loops refer to it
  std::vector<OpenLoop> loops_;
  StepOptions step_;
  std::vector<Rollout> undisturbed_;  // by step_
  Table errors_;
};

}  // namespace

RowMatrix draw_torque_error(const TorqueError& error, double dt, int rows, std::uint64_t seed,
                            std::uint64_t stream) {
  RowMatrix e(rows, std::ssize(error.sd));
  fill_normal(seed, stream, 0, {e.data(), static_cast<std::size_t>(e.size())});
  const double rho = error.time > 0 ? std::exp(-dt / error.time) : 0;
  for (Eigen::Index k = 1; k < rows; ++k)
    e.row(k) = rho * e.row(k - 1) + std::sqrt(1 - rho * rho) * e.row(k);
  return e * Eigen::VectorXd::Map(error.sd.data(), e.cols()).asDiagonal();
}

FittedTorqueError fit_torque_error(const data::ModelFile& model, const dynamics::RobotModel& known,
                                   std::span<const Trajectory> training,
                                   std::span<const LeftOut> left_out,
                                   const EvaluateOptions& options, int jobs) {
  std::vector<Fitted> fits;
  for (const LeftOut& part : left_out) fits.push_back({&part.arm, part.recordings});
  if (left_out.empty()) fits.push_back({&model.arm, training});
  const OpenLoops loops(model, known, fits, options, jobs);
  const double dt = training.front().data.dt();
  const std::vector<double> rms = torque_rms(training);
  TorqueError error{0, rms, kSlowGain}, best;
  for (double& sd : error.sd) sd *= kFirstShare;
  double least = std::numeric_limits<double>::infinity();
  for (const double time : kTimes) {
    // as much of it at low frequencies as of the last one
    if (time > 0)
      for (double& sd : error.sd) sd *= std::sqrt(std::max(error.time, dt / 2) / time);
    error.time = time;
    double unlike = 0;
    for (int i = 0; i < (time == kTimes[0] ? kFirst : kFurther); ++i) {
      const Table left = log_ratio(loops.errors(), loops.spread(error));
      unlike = 0;
      for (std::size_t j = 0; j < rms.size(); ++j) {
        const double step = mean(left[j]);
        if (std::isnan(step)) continue;
        error.sd[j] = std::clamp(error.sd[j] * std::exp(step / 2), kLeastShare * rms[j], rms[j]);
        for (const double value : left[j])
          if (!std::isnan(value)) unlike += (value - step) * (value - step);
      }
    }
    if (unlike >= least) break;
    least = unlike;
    best = error;
  }
  return {best, loops.leap()};
}

}  // namespace fricid::evaluate
