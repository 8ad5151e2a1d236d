#include "fricid/estimate/windows/multi_step.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/adam.hpp"
#include "fricid/estimate/gauss_newton.hpp"
#include "support.hpp"
#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr double kShortRollout = 1;     // [s]
constexpr double kLeapTolerance = 0.2;  // share of the gradient that a leap may change
constexpr int kRefresh = 20;            // batches whose curvature is taken in at once
// A look that finds kLost times the best held-out error sends the training back there, with steps
// kShorter times as long.
constexpr double kLost = 3, kShorter = 0.3;
constexpr double kResolved = 0.5;       // [rad] phase per step of a spring that steps resolve
constexpr int kMostCoordinates = 8000;  // of Gauss-Newton steps: 256 MB per matrix

/// Loss and gradient of a batch of windows, packs of them in parallel, summed in their order.
class Batch {
 public:
  struct Gradient {
    Eigen::VectorXd pi, theta;
    double loss = 0;
  };

  Batch(const Arm& arm, std::span<const Recording> recordings, StepOptions step, int steps,
        const MultiStepOptions& options)
      : packs_((options.batch + kLanes - 1) / kLanes), parts_(static_cast<std::size_t>(packs_)) {
    for (int p = 0; p < packs_; ++p)
      rollouts_.emplace_back(arm, recordings, step, steps, options.scales);
  }

  /// Mean over the windows.
  Gradient run(const Arm& arm, std::span<const Window> windows, std::span<const data::RowMatrix> z,
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
  CurvatureSamples(const Arm& arm, const ArmCoordinates& coordinates,
                   const MultiStepOptions& options)
      : coordinates_(coordinates),
        seed_(options.seed),
        pi_(arm.robot.pi.size(), options.batch),
        theta_(static_cast<Eigen::Index>(arm.friction.theta.size()), options.batch),
        samples_(coordinates.size(), kRefresh * options.batch) {}

  /// Adds those of the last run of `batch` at c; true when kRefresh batches are complete.
  bool add(Batch& batch, const Eigen::VectorXd& c, int jobs) {
    batch.sample_curvature(seed_, calls_, pi_, theta_, jobs);
    const Eigen::Index first = calls_ % kRefresh * pi_.cols();
    for (Eigen::Index k = 0; k < pi_.cols(); ++k) {
      coordinates_.pull_back(c, pi_.col(k), theta_.col(k), column_);
      auto sample = samples_.col(first + k);
      sample = column_.cast<float>();
      if (!sample.allFinite()) sample.setZero();
    }
    return ++calls_ % kRefresh == 0;
  }
  const Eigen::MatrixXf& samples() const { return samples_; }

 private:
  const ArmCoordinates& coordinates_;
  std::uint64_t seed_;
  int calls_ = 0;
  Eigen::MatrixXd pi_, theta_;
  Eigen::MatrixXf samples_;
  Eigen::VectorXd column_;
};

/// Mean squares of rollouts of equal length, in the order of `windows`.
std::vector<double> mean_squares(const Arm& arm, std::span<const Recording> recordings,
                                 std::span<const data::RowMatrix> z,
                                 std::span<const Window> windows, int steps, StepOptions step,
                                 int jobs) {
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

/// (n) stiffness that steps of dt resolve [N m/rad]: sqrt(k/m) dt = kResolved, m = 1/(M^-1)_jj the
/// inertia that joint j shows while the others are free, at the first sample. Gradients through a
/// stiffer spring are those of its chatter.
std::vector<double> resolved_stiffness(const Arm& arm, const Recording& recording, double dt) {
  const Eigen::ArrayXd k = std::pow(kResolved / dt, 2) / mobility(arm.robot, recording, 0).array();
  return {k.begin(), k.end()};
}

/// What of the options follows from the others.
struct Descent {
  bool second_order;
  int iterations;
  double rate;
};
/// @param size  number of parameters
Descent descent_of(const MultiStepOptions& options, int size, std::string_view label) {
  const Optimiser optimiser = options.optimiser.value_or(
      size <= kMostCoordinates ? Optimiser::kGaussNewton : Optimiser::kAdam);
  const bool second_order = optimiser == Optimiser::kGaussNewton;
  if (second_order && size > kMostCoordinates)
    throw UserError(
        "{}: {} parameters are too many for train.optimiser = \"gauss_newton\"; allowed up "
        "to {}, or \"adam\"",
        label, size, kMostCoordinates);
  return {second_order, options.iterations > 0 ? options.iterations : (second_order ? 1000 : 2400),
          options.rate > 0 ? options.rate : (second_order ? 1 : 8e-3)};
}

}  // namespace

std::string_view to_string(Optimiser optimiser) {
  return optimiser == Optimiser::kAdam ? "adam" : "gauss_newton";
}

Split split_recordings(std::span<const Recording> recordings, double hold_out) {
  Split split;
  for (const Recording& r : recordings) {
    const int end = static_cast<int>(std::lround((1 - hold_out) * r.length()));
    split.train_end.push_back(end);
    split.test_begin.push_back(end);
  }
  return split;
}

double held_out_error(const Arm& arm, std::span<const Recording> recordings, const Split& split,
                      StepOptions step, int jobs) {
  const auto z = wash_out(arm, recordings, jobs);
  const int second = static_cast<int>(std::lround(kShortRollout / recordings.front().dt));
  int shortest = recordings.front().length();
  std::vector<Window> tiles, whole;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const int end = recordings[i].length() - 1;
    shortest = std::min(shortest, end - split.test_begin[i]);
    whole.push_back({static_cast<int>(i), split.test_begin[i]});
    for (int at = split.test_begin[i]; at + second <= end; at += second)
      tiles.push_back({static_cast<int>(i), at});
  }
  const auto mean_log = [&](std::span<const Window> windows, int steps) {
    double sum = 0;
    for (const double square : mean_squares(arm, recordings, z, windows, steps, step, jobs))
      sum += std::log(std::clamp(square, 1e-300, kFallenSquare));
    return sum / static_cast<double>(windows.size());
  };
  if (tiles.empty()) return std::exp(mean_log(whole, shortest));
  return std::exp(0.5 * (mean_log(tiles, second) + mean_log(whole, shortest)));
}

MultiStepReport train_multi_step(const Arm& start, std::span<const Recording> recordings,
                                 const MultiStepOptions& options, std::string_view label,
                                 int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const double dt = recordings.front().dt;
  const int steps = static_cast<int>(std::lround(options.window_s / dt));
  const Split split = split_recordings(recordings, options.hold_out);
  for (std::size_t i = 0; i < recordings.size(); ++i)
    if (split.train_end[i] < 2 * steps)
      throw UserError("{}: {} samples are too few for windows of {} s", recordings[i].name,
                      recordings[i].length(), options.window_s);

  MultiStepReport report;
  report.arm = start;
  CoordinateOptions bounded = options.coordinates;
  bounded.stiffest = resolved_stiffness(start, recordings.front(),
                                        dt * options.judge.leap / options.judge.substeps);
  const ArmCoordinates coordinates(start, bounded);
  Arm arm = start;
  Eigen::VectorXd c = coordinates.start(), c_bar;
  const Descent descent = descent_of(options, coordinates.size(), label);
  Adam adam(coordinates.size());
  std::optional<GaussNewton> gauss_newton;
  Rng rng(options.seed, 0);

  Eigen::VectorXd best_c = c;
  const auto look = [&](int iteration) {
    report.checked.push_back(iteration);
    report.held_out.push_back(held_out_error(arm, recordings, split, options.judge, jobs));
    if (report.held_out.back() < report.held_out[static_cast<std::size_t>(report.best)]) {
      report.best = static_cast<int>(report.held_out.size()) - 1;
      report.arm = arm;
      best_c = c;
    }
  };
  look(0);
  coordinates.apply(c, arm);

  // the longest leap whose gradient is that of the judge's steps: stiff friction makes long leaps
  // chatter, and gradients through chatter explode
  StepOptions step = options.step;
  const auto gradient = [&](Batch& batch, std::span<const Window> windows,
                            std::span<const data::RowMatrix> z) {
    const Batch::Gradient mean = batch.run(arm, windows, z, jobs);
    coordinates.pull_back(c, mean.pi, mean.theta, c_bar);
    return mean.loss;
  };
  std::vector<data::RowMatrix> z = wash_out(arm, recordings, jobs);
  {
    Rng trial(options.seed, 1);
    const auto windows =
        draw_windows(recordings, split, steps, options.batch, options.from_rest, trial);
    Batch fine(arm, recordings, options.judge, steps, options);
    gradient(fine, windows, z);
    const Eigen::VectorXd wanted = c_bar;
    for (; step.leap > 1; step.leap /= 2) {
      Batch coarse(arm, recordings, step, steps, options);
      gradient(coarse, windows, z);
      if ((c_bar - wanted).norm() < kLeapTolerance * wanted.norm()) break;
    }
    report.leap = step.leap;
  }

  Batch batch(arm, recordings, step, steps, options);
  std::optional<CurvatureSamples> curvature;
  const auto begin_descent = [&] {
    adam = Adam(coordinates.size());
    if (!descent.second_order) return;
    // a first matrix before the first step
    curvature.emplace(arm, coordinates, options);
    gauss_newton.emplace(coordinates.size());
    Rng first(options.seed, 2);
    const auto draw = [&] {
      return draw_windows(recordings, split, steps, options.batch, options.from_rest, first);
    };
    do batch.run(arm, draw(), z, jobs);
    while (!curvature->add(batch, c, jobs));
    gauss_newton->refresh(curvature->samples(), jobs);
  };
  begin_descent();
  double rate_share = 1;
  Progress progress(fmt::format("train {}", label), descent.iterations);
  for (int iteration = 0; iteration < descent.iterations; ++iteration) {
    throw_if_stopped();
    if (iteration % options.wash_out_every == 0) z = wash_out(arm, recordings, jobs);
    const auto windows =
        draw_windows(recordings, split, steps, options.batch, options.from_rest, rng);
    const double loss = gradient(batch, windows, z);
    report.loss.push_back(loss);
    const double rate =
        rate_share * descent.rate * training_schedule(iteration, descent.iterations);
    if (curvature && curvature->add(batch, c, jobs))
      gauss_newton->refresh(curvature->samples(), jobs);
    const bool moved =
        descent.second_order
            ? gauss_newton->step(c_bar, rate, coordinates.lower(), coordinates.upper(), c)
            : adam.step(c_bar, rate, coordinates.rate(), coordinates.lower(), coordinates.upper(),
                        c);
    if (!moved) ++report.skipped;
    coordinates.apply(c, arm);
    const int done = iteration + 1;
    if (done * options.checks / descent.iterations >
        iteration * options.checks / descent.iterations) {
      look(done);
      const double best = report.held_out[static_cast<std::size_t>(report.best)];
      if (done < descent.iterations && report.held_out.back() > kLost * best) {
        c = best_c;
        coordinates.apply(c, arm);
        z = wash_out(arm, recordings, jobs);
        rate_share *= kShorter;
        ++report.returns;
        begin_descent();
      }
    }
    progress.advance(1, fmt::format("loss {:.3g}, held out {:.2e} rad2", report.loss.back(),
                                    report.held_out.back()));
  }

  const double best = report.held_out[static_cast<std::size_t>(report.best)];
  report.outcome = std::isfinite(best) ? Outcome::kIterationLimit : Outcome::kFailed;
  report.message =
      fmt::format("held-out error {:.2e} rad2 after {} of {} iterations, {:.2e} before", best,
                  report.checked[static_cast<std::size_t>(report.best)], descent.iterations,
                  report.held_out.front());
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace fricid::estimate
