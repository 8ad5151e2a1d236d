#include "fricid/evaluate/torque_error.hpp"

#include <algorithm>
#include <cmath>
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

/// Values of several rollouts each, [joint][horizon, as in Table].
using Samples = std::vector<std::vector<std::vector<double>>>;

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

/// Open loops of one arm on recordings, with and without a torque error.
class OpenLoops {
 public:
  /// @param first_stream  of the starts
  OpenLoops(data::ModelFile model, const dynamics::RobotModel& known,
            std::span<const Trajectory> recordings, const EvaluateOptions& options,
            std::size_t first_stream, int jobs)
      : model_(std::move(model)),
        recordings_(recordings),
        options_(options),
        first_stream_(first_stream),
        jobs_(jobs),
        plan_(make_plan(recordings, options)) {
    for (std::size_t i = 0; i < recordings.size(); ++i)
      driven_.push_back(drive(model_, known, recordings[i], plan_.by_trajectory[i]));
    undisturbed_ = roll_out({}, 0);
  }

  std::size_t starts() const { return plan_.starts.size(); }

  /// m [rad^2].
  Samples errors() const {
    return squares_of([&](std::size_t i, int steps) {
      return horizon_error(undisturbed_[i], recording_of(i), steps).q_mse_joint;
    });
  }

  /// S [rad^2].
  Samples spread(const TorqueError& error) const {
    std::vector<RowMatrix> disturbance;
    for (std::size_t i = 0; i < plan_.starts.size(); ++i)
      disturbance.push_back(draw_torque_error(
          error, recording_of(i).data.dt(), plan_.starts[i].steps + 1,
          static_cast<std::uint64_t>(model_.seed), stream_of(Purpose::kFit, first_stream_ + i, 0)));
    const std::vector<Rollout> disturbed = roll_out(disturbance, error.slow_gain);
    return squares_of([&](std::size_t i, int steps) {
      std::vector<double> squares(static_cast<std::size_t>(model_.arm.robot.n()));
      for (Eigen::Index k = 0; k <= steps; ++k)
        for (std::size_t j = 0; j < squares.size(); ++j) {
          const auto c = static_cast<Eigen::Index>(j);
          const double moved = disturbed[i].q(k, c) - undisturbed_[i].q(k, c);
          squares[j] += moved * moved / (steps + 1);
        }
      return squares;
    });
  }

 private:
  const Trajectory& recording_of(std::size_t start) const {
    return recordings_[static_cast<std::size_t>(plan_.starts[start].trajectory)];
  }

  std::vector<Rollout> roll_out(std::span<const RowMatrix> disturbance, double slow_gain) const {
    std::vector<Rollout> rollouts(plan_.starts.size());
    parallel_for(static_cast<int>(plan_.batches.size()), jobs_, [&](int b) {
      throw_if_stopped();
      const std::vector<int>& batch = plan_.batches[static_cast<std::size_t>(b)];
      std::vector<Rollout> made =
          roll_out_batch(model_.arm, recordings_, plan_, batch, driven_,
                         {{options_.substeps}, options_.diverged_rad, slow_gain}, disturbance);
      for (std::size_t l = 0; l < batch.size(); ++l)
        rollouts[static_cast<std::size_t>(batch[l])] = std::move(made[l]);
    });
    return rollouts;
  }

  /// Of the starts that reach a horizon, squares(start, steps) (n).
  template <class Squares>
  Samples squares_of(const Squares& squares) const {
    Samples table(static_cast<std::size_t>(model_.arm.robot.n()));
    for (const bool from_first : {true, false})
      for (const double h : options_.horizons_s) {
        for (auto& of_joint : table) of_joint.emplace_back();
        for (std::size_t i = 0; i < plan_.starts.size(); ++i) {
          const data::Dataset& data = recording_of(i).data;
          const int steps = horizon_steps(h, data.dt(), data.length());
          if ((plan_.starts[i].begin == 0) != from_first || steps > plan_.starts[i].steps) continue;
          const std::vector<double> of_start = squares(i, steps);
          for (std::size_t j = 0; j < table.size(); ++j) table[j].back().push_back(of_start[j]);
        }
      }
    return table;
  }

  data::ModelFile model_;
  std::span<const Trajectory> recordings_;
  const EvaluateOptions& options_;
  std::size_t first_stream_;
  int jobs_;
  Plan plan_;
  std::vector<Driven> driven_;
  std::vector<Rollout> undisturbed_;
};

/// Means over the rollouts of all `loops`.
template <class Part>
Table means(std::span<const OpenLoops> loops, const Part& part) {
  Samples all;
  for (const OpenLoops& one : loops) {
    const Samples own = part(one);
    all.resize(own.size());
    for (std::size_t j = 0; j < own.size(); ++j) {
      all[j].resize(own[j].size());
      for (std::size_t h = 0; h < own[j].size(); ++h)
        all[j][h].insert(all[j][h].end(), own[j][h].begin(), own[j][h].end());
    }
  }
  Table table(all.size());
  for (std::size_t j = 0; j < all.size(); ++j)
    for (const std::vector<double>& values : all[j]) table[j].push_back(mean(values));
  return table;
}

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
  std::vector<OpenLoops> loops;
  if (left_out.empty()) loops.emplace_back(model, known, training, options, 0, jobs);
  std::size_t starts = 0;
  for (const LeftOut& part : left_out) {
    data::ModelFile other = model;
    other.arm = part.arm;
    loops.emplace_back(std::move(other), known, part.recordings, options, starts, jobs);
    starts += loops.back().starts();
  }
  const double dt = training.front().data.dt();
  const std::vector<double> rms = torque_rms(training);
  const Table wanted = means(loops, [](const OpenLoops& one) { return one.errors(); });
  const auto spread = [&](const TorqueError& of) {
    return means(loops, [&](const OpenLoops& one) { return one.spread(of); });
  };
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
      left = log_ratio(wanted, spread(error));
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
