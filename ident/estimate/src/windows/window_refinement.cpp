#include "fricid/estimate/windows/window_refinement.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/wash_out.hpp"
#include "fricid/optimise/gauss_newton.hpp"
#include "friction/friction_search.hpp"
#include "rigid_body/joint_inertia.hpp"
#include "support.hpp"
#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr int kWindows = 512;
constexpr int kTasks = 8;  // each with a workspace of its own
constexpr int kIterations = 12;
constexpr double kKeep = 0.5;           // of the curvature, from step to step
constexpr double kSmallestGain = 5e-3;  // share of the loss; steps that lower it less are the last
constexpr double kFirstDamping = 1e-3;
constexpr float kExploded = 30;         // times the middle length of a gradient
constexpr double kMostExploded = 5e-3;  // share of the windows beyond which steps are halved
constexpr int kMostSubsteps = 64;       // of a sample
constexpr double kLeastLoss = 1e-12;    // noise-free data stay solvable
constexpr int kTrial = 32;              // windows on which leaps are compared
// Most times that an inertia grows or shrinks. Where friction is wrong or motion slow, a heavier
// arm drifts less.
constexpr double kMostInertia = 1.5;
const optimise::DampingOptions kDamping{.longest = 0.3,
                                        .keep_direction = true,
                                        .ridge = 1,
                                        .attempts = 5,
                                        .lessen = 10,
                                        .least = 1e-9,
                                        .most = 1e8,
                                        .hold_at_bounds = true};

/// Loss, gradient and sampled curvature of windows, some packs of them to a task, added in their
/// order.
class WindowSet {
 public:
  WindowSet(const Arm& arm, std::span<const signals::Recording> recordings, StepOptions step,
            int steps, ErrorScales scales, std::vector<Window> windows, int jobs)
      : windows_(std::move(windows)), jobs_(jobs) {
    const int packs = (static_cast<int>(windows_.size()) + kLanes - 1) / kLanes;
    for (int t = 0; t < std::min(kTasks, packs); ++t)
      rollouts_.emplace_back(arm, recordings, step, steps, scales);
    packs_ = packs;
  }

  /// Mean loss.
  double loss(const Arm& arm, std::span<const RowMatrix> z) {
    std::vector<double> sums(static_cast<std::size_t>(packs_));
    each_pack(arm, [&](WindowRollout<PackF>& rollout, int p) {
      sums[static_cast<std::size_t>(p)] = rollout.loss(of_pack(p), z);
    });
    double sum = 0;
    for (const double s : sums) sum += s;
    return sum / static_cast<double>(windows_.size());
  }

  struct Linear {
    double loss = 0;
    Eigen::VectorXd gradient;
    Eigen::MatrixXf samples;  // of the curvature, one column per window
  };
  /// At a point. @param call  0, 1, ..: of random signs
  int size() const { return static_cast<int>(windows_.size()); }

  /// Leaves out the windows whose gradients have exploded, which is chaos.
  void leave_out(const std::vector<bool>& exploded) {
    std::vector<Window> kept;
    for (std::size_t i = 0; i < windows_.size(); ++i)
      if (!exploded[i]) kept.push_back(windows_[i]);
    windows_ = std::move(kept);
    packs_ = (size() + kLanes - 1) / kLanes;
  }

  Linear linearise(const ArmPoint& point, std::span<const RowMatrix> z, std::uint64_t seed,
                   int call) {
    const auto packs = static_cast<std::size_t>(packs_);
    const Arm& arm = point.arm();
    std::vector<double> sums(packs);
    std::vector<Eigen::VectorXd> gradients(packs);
    Linear out;
    out.samples.resize(point.c().size(), std::ssize(windows_));
    each_pack(arm, [&](WindowRollout<PackF>& rollout, int p) {
      const auto i = static_cast<std::size_t>(p);
      const std::span<const Window> windows = of_pack(p);
      Eigen::VectorXd pi = Eigen::VectorXd::Zero(arm.robot.pi.size()),
                      theta = Eigen::VectorXd::Zero(std::ssize(arm.friction.theta));
      sums[i] = rollout.loss(windows, z);
      rollout.add_gradient(view(pi), view(theta));
      point.pull_back(pi, theta, gradients[i]);
      Rng rng(seed, kSigns + static_cast<std::uint64_t>(call * packs_ + p));
      Eigen::MatrixXd pi_bar(pi.size(), std::ssize(windows)),
          theta_bar(theta.size(), std::ssize(windows));
      rollout.curvature_samples(rng, pi_bar, theta_bar);
      Eigen::VectorXd column;
      for (Eigen::Index k = 0; k < pi_bar.cols(); ++k) {
        point.pull_back(pi_bar.col(k), theta_bar.col(k), column);
        out.samples.col(p * kLanes + k) = column.cast<float>();
      }
    });
    out.gradient = Eigen::VectorXd::Zero(point.c().size());
    for (std::size_t i = 0; i < packs; ++i) {
      out.loss += sums[i];
      out.gradient += gradients[i];
    }
    out.loss /= static_cast<double>(windows_.size());
    out.gradient /= static_cast<double>(windows_.size());
    return out;
  }

 private:
  static constexpr int kLanes = WindowRollout<PackF>::lanes();
  static constexpr std::uint64_t kSigns = 1 << 20;  // stream

  std::span<const Window> of_pack(int p) const {
    const auto first = static_cast<std::size_t>(p * kLanes);
    return std::span(windows_).subspan(first,
                                       std::min<std::size_t>(kLanes, windows_.size() - first));
  }
  template <class Body>
  void each_pack(const Arm& arm, Body body) {
    const int tasks = static_cast<int>(rollouts_.size());
    parallel_for(tasks, jobs_, [&](int t) {
      WindowRollout<PackF>& rollout = rollouts_[static_cast<std::size_t>(t)];
      rollout.set_parameters(view(arm.robot.pi), arm.friction.theta);
      for (int p = t; p < packs_; p += tasks) body(rollout, p);
    });
  }

  std::vector<Window> windows_;
  int jobs_, packs_ = 0;
  std::vector<WindowRollout<PackF>> rollouts_;
};

/// Mean of the squares of samples.
Eigen::MatrixXf curvature_of(const Eigen::MatrixXf& samples) {
  const Eigen::VectorXf weight =
      optimise::sample_weights(samples) / static_cast<float>(samples.cols());
  const Eigen::MatrixXf weighed = samples * weight.cwiseSqrt().asDiagonal();
  Eigen::MatrixXf F = Eigen::MatrixXf::Zero(samples.rows(), samples.rows());
  F.selfadjointView<Eigen::Lower>().rankUpdate(weighed);
  F.triangularView<Eigen::StrictlyUpper>() = F.transpose();
  return F;
}

}  // namespace

MultiStepReport refine_on_windows(const Arm& start, const TorquePull& torque,
                                  std::span<const signals::Recording> recordings,
                                  const MultiStepOptions& options, std::string_view label,
                                  int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const WindowSetup setup = set_up_windows(start, recordings, options);
  const int steps = setup.steps;
  const Split& split = setup.split;
  const ArmCoordinates coordinates(start, setup.coordinates);
  ArmPoint point(coordinates, start);
  const int iterations = options.iterations > 0 ? options.iterations : kIterations;

  MultiStepReport report;
  optimise::DescentHistory& history = report.history;
  ArmPoint best = point;
  const Eigen::VectorXd inertia = joint_inertia(start.robot, recordings);
  const auto look = [&](int iteration) {
    const Eigen::ArrayXd times =
        joint_inertia(point.arm().robot, recordings).array() / inertia.array();
    const bool plausible = times.maxCoeff() < kMostInertia && times.minCoeff() > 1 / kMostInertia;
    history.checked.push_back(iteration);
    history.held_out.push_back(held_out_error(point.arm(), recordings, split, options.judge, jobs));
    if (plausible && history.held_out.back() < history.best_held_out()) {
      history.best = static_cast<int>(history.held_out.size()) - 1;
      best = point;
    }
  };
  look(0);
  point.move_to(point.c());  // projects onto what the coordinates can represent

  Rng rng(options.seed, 0);
  const std::vector<Window> windows =
      draw_windows(recordings, split, steps, kWindows, options.from_rest, rng);
  std::vector<RowMatrix> z = wash_out(point.arm(), recordings, jobs);
  StepOptions step = longest_leap(options, [&](StepOptions how) {
    return WindowSet(point.arm(), recordings, how, steps, options.scales,
                     {windows.end() - kTrial, windows.end()}, jobs)
        .linearise(point, z, options.seed, 0)
        .gradient;
  });
  report.leap = step.leap;
  std::optional<WindowSet> set;
  const auto make_set = [&] {
    set.emplace(point.arm(), recordings, step, steps, options.scales, windows, jobs);
  };
  make_set();

  const auto pull = [&](const Eigen::VectorXd& c) {
    const Eigen::VectorXd s = c - torque.c;
    return s.dot(torque.about.g + 0.5 * (torque.about.H * s));
  };
  double samples = 0;
  for (const int end : split.train_end) samples += end;
  const double numbers = samples / steps * start.robot.n();
  Progress progress(fmt::format("train {}", label), iterations);
  Eigen::MatrixXf F;
  double mass = 0, weight = 0, lambda = kFirstDamping, last = 0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    throw_if_stopped();
    if (iteration > 0) z = wash_out(point.arm(), recordings, jobs);
    WindowSet::Linear at = set->linearise(point, z, options.seed, iteration);
    std::vector<bool> exploded = optimise::outliers(at.samples, kExploded);
    const auto count = [&] { return static_cast<double>(std::ranges::count(exploded, true)); };
    while (iteration == 0 && step.substeps < kMostSubsteps &&
           count() > kMostExploded * set->size()) {
      step.substeps *= 2;
      make_set();
      at = set->linearise(point, z, options.seed, iteration);
      exploded = optimise::outliers(at.samples, kExploded);
    }
    const bool fewer = count() > 0;
    if (fewer) {
      set->leave_out(exploded);
      at = set->linearise(point, z, options.seed, iteration);
    }
    history.loss.push_back(at.loss);
    if (!at.gradient.allFinite()) break;
    if (iteration == 0) {
      weight = numbers / std::max(at.loss, kLeastLoss);
      F = Eigen::MatrixXf::Zero(at.samples.rows(), at.samples.rows());
    }
    F = static_cast<float>(kKeep) * F + curvature_of(at.samples);
    mass = kKeep * mass + 1;
    const Eigen::VectorXd s = point.c() - torque.c;
    const optimise::Quadratic here{weight * at.loss + pull(point.c()),
                                   weight * at.gradient + torque.about.g + torque.about.H * s,
                                   weight / mass * F.cast<double>() + torque.about.H};
    const bool converged =
        iteration > 0 && !fewer && last - here.value < kSmallestGain * weight * at.loss;
    last = here.value;
    Eigen::VectorXd c = point.c();
    double value = here.value;
    const auto objective = [&](const Eigen::VectorXd& trial) {
      ArmPoint there = point;
      there.move_to(trial);
      const double found = weight * set->loss(there.arm(), z) + pull(trial);
      return std::isfinite(found) ? found : kBadValue;
    };
    if (converged ||
        !optimise::damped_step(here, coordinates.box(), kDamping, objective, lambda, c, value)
             .lowered) {
      report.outcome = Outcome::kConverged;
      break;
    }
    point.move_to(c);
    look(iteration + 1);
    progress.advance(
        1, fmt::format("loss {:.3g}, held out {:.2e} rad2", at.loss, history.held_out.back()));
  }
  report.arm = best.arm();
  if (!std::isfinite(history.best_held_out()))
    report.outcome = Outcome::kFailed;
  else if (report.outcome != Outcome::kConverged)
    report.outcome = Outcome::kIterationLimit;
  report.message = fmt::format("held-out error {:.2e} rad2 after {} of {} steps, {:.2e} before",
                               history.best_held_out(), history.best_iteration(),
                               history.loss.size(), history.held_out.front());
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace fricid::estimate
