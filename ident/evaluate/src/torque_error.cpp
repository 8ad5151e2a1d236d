#include "fricid/evaluate/torque_error.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
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

double sum_of_squares(const Table& table) {
  double sum = 0;
  for (const std::vector<double>& row : table)
    for (const double value : row)
      if (!std::isnan(value)) sum += value * value;
  return sum;
}

/// Open loops of fits on recordings, with and without a torque error. Fits that left recordings out
/// differ in parameters alone: their loops share lanes.
class OpenLoops {
 public:
  OpenLoops(const data::ModelFile& model, const dynamics::RobotModel& known,
            std::span<const Fitted> fits, const EvaluateOptions& options, int jobs)
      : options_(options), jobs_(jobs), seed_(static_cast<std::uint64_t>(model.seed)) {
    for (const Fitted& fit : fits) {
      const Plan plan = make_plan(fit.recordings, options);
      std::vector<Driven>& driven = driven_.emplace_back();
      data::ModelFile other = model;
      other.arm = *fit.arm;
      for (std::size_t i = 0; i < fit.recordings.size(); ++i)
        driven.push_back(drive(other, known, fit.recordings[i], plan.by_trajectory[i]));
      const std::vector<OpenLoop> loops = open_loops(*fit.arm, fit.recordings, plan, driven);
      loops_.insert(loops_.end(), loops.begin(), loops.end());
      starts_.insert(starts_.end(), plan.starts.begin(), plan.starts.end());
    }
    batches_ = batches_of(starts_);
    undisturbed_ = roll_out(loops_, 0);
  }

  /// m [rad^2].
  Table errors() const {
    return means([&](std::size_t i, int steps) {
      return horizon_error(undisturbed_[i], *loops_[i].trajectory, steps).q_mse_joint;
    });
  }

  /// S [rad^2].
  Table spread(const TorqueError& error) const {
    std::vector<RowMatrix> disturbance;
    for (std::size_t i = 0; i < loops_.size(); ++i)
      disturbance.push_back(draw_torque_error(error, loops_[i].trajectory->data.dt(),
                                              starts_[i].steps + 1, seed_,
                                              stream_of(Purpose::kFit, i, 0)));
    std::vector<OpenLoop> loops = loops_;
    for (std::size_t i = 0; i < loops.size(); ++i) loops[i].disturbance = &disturbance[i];
    const std::vector<Rollout> disturbed = roll_out(loops, error.slow_gain);
    return means([&](std::size_t i, int steps) {
      const RowMatrix& moved = disturbed[i].q;
      std::vector<double> squares(static_cast<std::size_t>(moved.cols()));
      for (Eigen::Index k = 0; k <= steps; ++k)
        for (std::size_t j = 0; j < squares.size(); ++j) {
          const auto c = static_cast<Eigen::Index>(j);
          const double by = moved(k, c) - undisturbed_[i].q(k, c);
          squares[j] += by * by / (steps + 1);
        }
      return squares;
    });
  }

 private:
  std::vector<Rollout> roll_out(std::span<const OpenLoop> loops, double slow_gain) const {
    std::vector<Rollout> rollouts(loops.size());
    parallel_for(static_cast<int>(batches_.size()), jobs_, [&](int b) {
      throw_if_stopped();
      const std::vector<int>& batch = batches_[static_cast<std::size_t>(b)];
      std::vector<Rollout> made =
          roll_out_batch(loops, batch, {{options_.substeps}, options_.diverged_rad, slow_gain});
      for (std::size_t l = 0; l < batch.size(); ++l)
        rollouts[static_cast<std::size_t>(batch[l])] = std::move(made[l]);
    });
    return rollouts;
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
          if ((starts_[i].begin == 0) != from_first || steps > starts_[i].steps) continue;
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
  std::vector<Start> starts_;
  std::vector<std::vector<int>> batches_;
  std::vector<Rollout> undisturbed_;
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

TorqueError fit_torque_error(const data::ModelFile& model, const dynamics::RobotModel& known,
                             std::span<const Trajectory> training,
                             std::span<const LeftOut> left_out, const EvaluateOptions& options,
                             int jobs) {
  std::vector<Fitted> fits;
  for (const LeftOut& part : left_out) fits.push_back({&part.arm, part.recordings});
  if (left_out.empty()) fits.push_back({&model.arm, training});
  const OpenLoops loops(model, known, fits, options, jobs);
  const double dt = training.front().data.dt();
  const std::vector<double> rms = torque_rms(training);
  const Table wanted = loops.errors();
  TorqueError error{0, rms, kSlowGain}, best;
  for (double& sd : error.sd) sd *= kFirstShare;
  double least = std::numeric_limits<double>::infinity();
  for (const double time : kTimes) {
    // as much of it at low frequencies as of the last one
    if (time > 0)
      for (double& sd : error.sd) sd *= std::sqrt(std::max(error.time, dt / 2) / time);
    error.time = time;
    Table left;
    for (int i = 0;; ++i) {
      left = log_ratio(wanted, loops.spread(error));
      if (i == (time == kTimes[0] ? kFirst : kFurther)) break;
      for (std::size_t j = 0; j < rms.size(); ++j) {
        const double step = mean(left[j]);
        if (!std::isnan(step))
          error.sd[j] = std::clamp(error.sd[j] * std::exp(step / 2), kLeastShare * rms[j], rms[j]);
      }
    }
    if (sum_of_squares(left) >= least) break;
    least = sum_of_squares(left);
    best = error;
  }
  return best;
}

}  // namespace fricid::evaluate
