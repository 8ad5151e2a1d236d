#include "fricid/estimate/windows/multi_step.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/wash_out.hpp"
#include "fricid/optimise/adam.hpp"
#include "fricid/optimise/descent.hpp"
#include "fricid/optimise/gauss_newton.hpp"
#include "support.hpp"
#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr double kShortRollout = 1;     // [s]
constexpr int kRefresh = 20;            // batches whose curvature is taken in at once
constexpr double kLost = 3;             // times the best held-out error: back to the best
constexpr int kMostCoordinates = 8000;  // of Gauss-Newton steps: 256 MB per matrix

/// Loss and gradient of a batch of windows, packs of them in parallel, summed in their order.
class Batch {
 public:
  struct Gradient {
    Eigen::VectorXd pi, theta;
    double loss = 0;
  };

  Batch(const Arm& arm, std::span<const signals::Recording> recordings, StepOptions step, int steps,
        const MultiStepOptions& options)
      : packs_((options.batch + kLanes - 1) / kLanes), parts_(static_cast<std::size_t>(packs_)) {
    for (int p = 0; p < packs_; ++p)
      rollouts_.emplace_back(arm, recordings, step, steps, options.scales);
  }

  /// Mean over the windows.
  Gradient run(const Arm& arm, std::span<const Window> windows, std::span<const RowMatrix> z,
               int jobs) {
    parallel_for(packs_, jobs, [&](int p) {
      const auto i = static_cast<std::size_t>(p), first = i * kLanes;
      Gradient& part = parts_[i];
      part.pi.setZero(arm.robot.pi.size());
      part.theta.setZero(static_cast<Eigen::Index>(arm.friction.theta.size()));
      rollouts_[i].set_parameters(view(arm.robot.pi), arm.friction.theta);
      const auto count = std::min<std::size_t>(kLanes, windows.size() - first);
      part.loss = rollouts_[i].loss(windows.subspan(first, count), z);
      rollouts_[i].add_gradient(view(part.pi), view(part.theta));
    });
    Gradient mean = parts_[0];
    for (std::size_t i = 1; i < parts_.size(); ++i) {
      mean.pi += parts_[i].pi;
      mean.theta += parts_[i].theta;
      mean.loss += parts_[i].loss;
    }
    const double share = 1.0 / static_cast<double>(windows.size());
    mean.pi *= share;
    mean.theta *= share;
    mean.loss *= share;
    return mean;
  }

  /// A sample of the curvature of each window of the last run.
  /// @param pi, theta  one column per window
  void sample_curvature(std::uint64_t seed, int call, Eigen::MatrixXd& pi, Eigen::MatrixXd& theta,
                        int jobs) {
    parallel_for(packs_, jobs, [&](int p) {
      Rng rng(seed, kCurvatureStream + static_cast<std::uint64_t>(call * packs_ + p));
      const Eigen::Index first = p * kLanes;
      const auto count = std::min<Eigen::Index>(kLanes, pi.cols() - first);
      rollouts_[static_cast<std::size_t>(p)].curvature_samples(rng, pi.middleCols(first, count),
                                                               theta.middleCols(first, count));
    });
  }

 private:
  static constexpr int kLanes = WindowRollout<PackF>::lanes();
  static constexpr std::uint64_t kCurvatureStream = 16;
  int packs_;
  std::vector<WindowRollout<PackF>> rollouts_;
  std::vector<Gradient> parts_;
};

/// Collects the curvature of kRefresh batches in coordinates.
class CurvatureSamples {
 public:
  CurvatureSamples(const ArmPoint& point, const MultiStepOptions& options)
      : seed_(options.seed),
        pi_(point.arm().robot.pi.size(), options.batch),
        theta_(static_cast<Eigen::Index>(point.arm().friction.theta.size()), options.batch),
        samples_(point.c().size(), kRefresh * options.batch) {}

  /// Adds those of the last run of `batch` at the point; true when kRefresh batches are complete.
  bool add(Batch& batch, const ArmPoint& point, int jobs) {
    batch.sample_curvature(seed_, calls_, pi_, theta_, jobs);
    const Eigen::Index first = calls_ % kRefresh * pi_.cols();
    for (Eigen::Index k = 0; k < pi_.cols(); ++k) {
      point.pull_back(pi_.col(k), theta_.col(k), column_);
      auto sample = samples_.col(first + k);
      sample = column_.cast<float>();
      if (!sample.allFinite()) sample.setZero();
    }
    return ++calls_ % kRefresh == 0;
  }
  const Eigen::MatrixXf& samples() const { return samples_; }

 private:
  std::uint64_t seed_;
  int calls_ = 0;
  Eigen::MatrixXd pi_, theta_;
  Eigen::MatrixXf samples_;
  Eigen::VectorXd column_;
};

/// Mean squares of rollouts of equal length, in the order of `windows`.
std::vector<double> mean_squares(const Arm& arm, std::span<const signals::Recording> recordings,
                                 std::span<const RowMatrix> z, std::span<const Window> windows,
                                 int steps, StepOptions step, int jobs) {
  constexpr int kLanes = PackD::kLanes;
  std::vector<double> squares(windows.size());
  const int groups = (static_cast<int>(windows.size()) + kLanes - 1) / kLanes;
  parallel_for(groups, jobs, [&](int g) {
    const auto first = static_cast<std::size_t>(g * kLanes);
    const auto count = std::min<std::size_t>(kLanes, windows.size() - first);
    WindowRollout<PackD> rollout(arm, recordings, step, steps);
    rollout.set_parameters(view(arm.robot.pi), arm.friction.theta);
    rollout.loss(windows.subspan(first, count), z);
    for (std::size_t k = 0; k < count; ++k)
      squares[first + k] = rollout.mean_square(static_cast<int>(k));
  });
  return squares;
}

/// What of the options follows from the others.
struct Steps {
  bool second_order;
  int iterations;
  double rate;
};
/// @param size  number of parameters
Steps steps_of(const MultiStepOptions& options, int size, std::string_view label) {
  const bool second_order = options.optimiser == Optimiser::kGaussNewton ||
                            (options.optimiser == Optimiser::kAuto && size <= kMostCoordinates);
  if (second_order && size > kMostCoordinates)
    throw UserError(
        "{}: {} parameters are too many for train.optimiser = \"gauss_newton\"; allowed up "
        "to {}, or \"adam\"",
        label, size, kMostCoordinates);
  return {second_order, options.iterations > 0 ? options.iterations : (second_order ? 1000 : 2400),
          options.rate > 0 ? options.rate : (second_order ? 1 : 8e-3)};
}

/// What a descent on windows needs, see optimise::descend.
class WindowProblem {
 public:
  WindowProblem(const ArmPoint& start, std::span<const signals::Recording> recordings,
                const MultiStepOptions& options, const WindowSetup& setup, bool second_order,
                int jobs)
      : recordings_(recordings),
        options_(options),
        second_order_(second_order),
        jobs_(jobs),
        steps_(setup.steps),
        split_(setup.split),
        rng_(options.seed, 0),
        z_(wash_out(start.arm(), recordings, jobs)),
        step_(longest_leap(start)),
        batch_(start.arm(), recordings, step_, steps_, options),
        adam_(start.c().size()) {}

  int leap() const { return step_.leap; }

  void begin(const ArmPoint& point) {
    z_ = wash_out(point.arm(), recordings_, jobs_);
    adam_ = optimise::Adam(point.c().size());
    if (!second_order_) return;
    // a first matrix before the first step
    curvature_.emplace(point, options_);
    gauss_newton_.emplace(point.c().size());
    Rng first(options_.seed, 2);
    do batch_.run(point.arm(), draw(first), z_, jobs_);
    while (!curvature_->add(batch_, point, jobs_));
    gauss_newton_->refresh(curvature_->samples(), jobs_);
  }

  void prepare(int iteration, const ArmPoint& point) {
    if (iteration % options_.wash_out_every == 0) z_ = wash_out(point.arm(), recordings_, jobs_);
  }

  double loss(const ArmPoint& point, Eigen::VectorXd& gradient) {
    return run(batch_, point, draw(rng_), gradient);
  }

  std::pair<Eigen::VectorXd, bool> step(const ArmPoint& point, const Eigen::VectorXd& gradient,
                                        double rate) {
    const ArmCoordinates& coordinates = point.coordinates();
    Eigen::VectorXd c = point.c();
    if (!second_order_) {
      const bool moved = adam_.step(gradient, rate, coordinates.rate(), coordinates.box(), c);
      return {std::move(c), moved};
    }
    if (curvature_->add(batch_, point, jobs_)) gauss_newton_->refresh(curvature_->samples(), jobs_);
    const bool moved = gauss_newton_->step(gradient, rate, coordinates.box(), c);
    return {std::move(c), moved};
  }

  double held_out(const ArmPoint& point) {
    return held_out_error(point.arm(), recordings_, split_, options_.judge, jobs_);
  }

  std::string describe(double loss, double held_out) const {
    return fmt::format("loss {:.3g}, held out {:.2e} rad2", loss, held_out);
  }

 private:
  std::vector<Window> draw(Rng& rng) const {
    return draw_windows(recordings_, split_, steps_, options_.batch, options_.from_rest, rng);
  }

  double run(Batch& batch, const ArmPoint& point, std::span<const Window> windows,
             Eigen::VectorXd& gradient) const {
    const Batch::Gradient mean = batch.run(point.arm(), windows, z_, jobs_);
    point.pull_back(mean.pi, mean.theta, gradient);
    return mean.loss;
  }

  /// Steps with the longest leap whose gradient is that of the judge's: stiff friction makes long
  /// leaps chatter, and gradients through chatter explode.
  StepOptions longest_leap(const ArmPoint& point) const {
    Rng trial(options_.seed, 1);
    const auto windows = draw(trial);
    return estimate::longest_leap(options_, [&](StepOptions how) {
      Eigen::VectorXd gradient;
      Batch batch(point.arm(), recordings_, how, steps_, options_);
      run(batch, point, windows, gradient);
      return gradient;
    });
  }

  std::span<const signals::Recording> recordings_;
  const MultiStepOptions& options_;
  bool second_order_;
  int jobs_, steps_;
  Split split_;
  Rng rng_;
  std::vector<RowMatrix> z_;
  StepOptions step_;
  Batch batch_;
  optimise::Adam adam_;
  std::optional<optimise::GaussNewton> gauss_newton_;
  std::optional<CurvatureSamples> curvature_;
};

}  // namespace

Split split_recordings(std::span<const signals::Recording> recordings, double hold_out) {
  Split split;
  for (const signals::Recording& r : recordings) {
    const int end = static_cast<int>(std::lround((1 - hold_out) * r.length()));
    split.train_end.push_back(end);
    split.test_begin.push_back(end);
  }
  return split;
}

double RolloutErrors::mean() const {
  const auto mean_of = [](const std::vector<double>& x) {
    return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
  };
  return seconds.empty() ? mean_of(whole) : 0.5 * (mean_of(seconds) + mean_of(whole));
}

Rollouts held_out_rollouts(std::span<const signals::Recording> recordings, const Split& split) {
  Rollouts out;
  out.second = static_cast<int>(std::lround(kShortRollout / recordings.front().dt));
  out.length = recordings.front().length();
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const int recording = static_cast<int>(i), first = split.test_begin[i],
              last = recordings[i].length() - 1;
    out.length = std::min(out.length, last - first);
    out.whole.push_back({recording, first});
    for (int at = first; at + out.second <= last; at += out.second)
      out.seconds.push_back({recording, at});
  }
  return out;
}

RolloutErrors rollout_errors(const Arm& arm, std::span<const signals::Recording> recordings,
                             const Rollouts& rollouts, StepOptions step, int jobs) {
  const auto z = wash_out(arm, recordings, jobs);
  const auto logs = [&](std::span<const Window> windows, int steps) {
    std::vector<double> out = mean_squares(arm, recordings, z, windows, steps, step, jobs);
    for (double& square : out) square = std::log(std::clamp(square, 1e-300, kFallenSquare));
    return out;
  };
  return {logs(rollouts.seconds, rollouts.second), logs(rollouts.whole, rollouts.length)};
}

double held_out_error(const Arm& arm, std::span<const signals::Recording> recordings,
                      const Split& split, StepOptions step, int jobs) {
  return std::exp(
      rollout_errors(arm, recordings, held_out_rollouts(recordings, split), step, jobs).mean());
}

MultiStepReport train_multi_step(const Arm& start, std::span<const signals::Recording> recordings,
                                 const MultiStepOptions& options, std::string_view label,
                                 int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const WindowSetup setup = set_up_windows(start, recordings, options);
  const ArmCoordinates coordinates(start, setup.coordinates);
  const Steps kind = steps_of(options, coordinates.size(), label);
  ArmPoint point(coordinates, start), first = point;
  first.move_to(first.c());
  WindowProblem problem(first, recordings, options, setup, kind.second_order, jobs);

  MultiStepReport report;
  report.leap = problem.leap();
  report.history = optimise::descend(
      problem, point,
      {.iterations = kind.iterations, .rate = kind.rate, .checks = options.checks, .lost = kLost},
      fmt::format("train {}", label));
  report.arm = point.arm();
  const double best = report.history.best_held_out();
  report.outcome = std::isfinite(best) ? Outcome::kIterationLimit : Outcome::kFailed;
  report.message = fmt::format(
      "held-out error {:.2e} rad2 after {} of {} iterations, {:.2e} before", best,
      report.history.best_iteration(), kind.iterations, report.history.held_out.front());
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace fricid::estimate
