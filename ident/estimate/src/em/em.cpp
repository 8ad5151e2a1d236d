#include "fricid/estimate/em/em.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "em/length_step.hpp"
#include "em/score_step.hpp"
#include "em/transition_step.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/online/online.hpp"
#include "fricid/estimate/wash_out.hpp"
#include "fricid/optimise/damped_step.hpp"
#include "fricid/system/driven_friction.hpp"
#include "support.hpp"
#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPositionNoise = 2;     // sd of w on q, share of the encoder noise
constexpr double kVelocityStart = 0.02;  // sd of the first velocity [rad/s]
constexpr double kFallingShare = 0.7;    // of the iterations, in which the noise of z falls
constexpr double kSmallestR = 1e-14;     // [rad^2]
constexpr double kShortest = 1;          // recording [s]

/// Size of the friction torque per joint, what one N m does to v in a sample, size of the latents.
struct Sizes {
  Eigen::VectorXd friction;  // rms [N m]
  Eigen::VectorXd mobility;  // dt mean (M^-1)_jj [rad/s per N m]
  Eigen::VectorXd z;         // rms

  /// Variance of v under a torque noise of this share of the friction torque.
  Eigen::VectorXd variance_v(double share) const {
    return (share * friction.cwiseProduct(mobility)).cwiseAbs2();
  }
};

Sizes sizes_of(const Arm& arm, std::span<const signals::Recording> recordings, int jobs) {
  const int n = arm.robot.n();
  Sizes sizes{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n),
              latent_sizes(wash_out(arm, recordings, jobs))};
  double rows = 0, poses = 0;
  for (const signals::Recording& r : recordings) {
    const auto driven =
        drive_friction(arm.friction, r.dt, r.wide.q, r.wide.v, r.held_tau, r.temperature);
    sizes.friction += driven.tau_f.cwiseAbs2().colwise().sum().transpose();
    rows += r.length();
    for (int k = 0; k < r.length(); k += 100, poses += 1)
      sizes.mobility += r.dt * mobility(arm.robot, r, k).diagonal();
  }
  sizes.friction = (sizes.friction / rows).cwiseSqrt();
  // networks of the whole robot start without torque, but have its scale
  for (std::size_t p = 0; p < arm.friction.theta.size(); ++p) {
    const friction::ParameterInfo& info = arm.friction.model.parameters()[p].info;
    if (info.role == friction::Role::kTorqueScale) {
      double& size = sizes.friction[info.element - 1];
      size = std::max(size, arm.friction.theta[p]);
    }
  }
  sizes.mobility /= poses;
  return sizes;
}

LatentNoise noise_of(const Sizes& sizes, std::span<const signals::Recording> recordings,
                     const EmOptions& options) {
  LatentNoise noise;
  noise.dt = recordings.front().dt;
  noise.R = Eigen::VectorXd::Zero(sizes.friction.size());
  for (const signals::Recording& r : recordings)
    noise.R += r.noise_sd.cwiseAbs2() / static_cast<double>(recordings.size());
  noise.R = noise.R.cwiseMax(kSmallestR);
  noise.q = kPositionNoise * kPositionNoise * noise.R;
  noise.v = sizes.variance_v(options.torque_noise);
  noise.z = (options.z_noise_first * sizes.z).cwiseAbs2();
  return noise;
}

/// State carried from one iteration to the next.
struct State {
  ArmPoint point, best_point;
  optimise::Adam adam;
  LatentNoise noise, best_noise;
  int iteration = 0, best_iteration = -1;
  double best = 0, z_noise = 0, damping = optimise::DampingOptions().first, seconds = 0;
  std::uint64_t draw = 0;         // of the random numbers
  Eigen::VectorXd length_step{};  // see climb_by_lengths
  std::vector<EmIteration> history{};
  std::vector<std::string> warnings{};

  template <class Archive>
  void visit(Archive& archive) {
    archive("iteration", iteration);
    archive("best_iteration", best_iteration);
    archive("best", best);
    archive("z_noise", z_noise);
    archive("damping", damping);
    archive("length_step", length_step);
    archive("seconds", seconds);
    archive("draw", draw);
    visit_point(archive, "c", point);
    visit_point(archive, "best_c", best_point);
    adam.visit(archive);
    archive("Q_v", noise.v);
    archive("R", noise.R);
    archive("best_Q_v", best_noise.v);
    archive("best_Q_z", best_noise.z);
    archive("best_R", best_noise.R);
    archive("history", history);
    archive("warnings", warnings);
  }
  /// Whether the iterations of a checkpoint are those of its history.
  bool agrees() const {
    return iteration >= 0 && std::ssize(history) == iteration && best_iteration >= -1 &&
           best_iteration < iteration;
  }

 private:
  template <class Archive>
  static void visit_point(Archive& archive, const char* name, ArmPoint& point) {
    Eigen::VectorXd c = point.c();
    archive(name, c);
    point.move_to(c);
  }
};

/// Mean square residual of the positions from the paths, per joint.
Eigen::VectorXd observation_noise(std::span<const Paths> paths,
                                  std::span<const signals::Recording> recordings) {
  const int n = recordings.front().n();
  Eigen::VectorXd square = Eigen::VectorXd::Zero(n), count = square;
  for (std::size_t r = 0; r < paths.size(); ++r)
    for (const smc::RowMatrix& path : paths[r])
      for (Eigen::Index t = 0; t < path.rows(); ++t)
        for (int j = 0; j < n; ++j) {
          const double y = recordings[r].log.q(t, j);
          if (std::isnan(y)) continue;
          square[j] += (y - path(t, j)) * (y - path(t, j));
          count[j] += 1;
        }
  return square.cwiseQuotient(count.cwiseMax(1)).cwiseMax(kSmallestR);
}

}  // namespace

Eigen::VectorXd latent_sizes(std::span<const RowMatrix> z) {
  Eigen::VectorXd sizes = Eigen::VectorXd::Zero(z.front().cols());
  double rows = 0;
  for (const RowMatrix& states : z) {
    sizes += states.cwiseAbs2().colwise().sum().transpose();
    rows += static_cast<double>(states.rows());
  }
  sizes = (sizes / rows).cwiseSqrt();
  for (double& size : sizes)
    if (!(size > 0)) size = 1;
  return sizes;
}

void require_length_for_em(std::span<const signals::Recording> recordings) {
  for (const signals::Recording& r : recordings)
    if (r.length() * r.dt < kShortest)
      throw UserError("{}: {:.3g} s; allowed for expectation-maximisation: {} s or more",
                      r.log.name, r.length() * r.dt, kShortest);
}

LatentNoise initial_noise(const Arm& arm, std::span<const signals::Recording> recordings,
                          const EmOptions& options) {
  return noise_of(sizes_of(arm, recordings, 1), recordings, options);
}

smc::Gaussian initial_state(const signals::Recording& recording, const Eigen::VectorXd& z,
                            const Eigen::VectorXd& z_size, const LatentNoise& noise) {
  return online_start(recording.wide.q.row(0), recording.wide.v.row(0), z, noise, kVelocityStart,
                      z_size);
}

EmReport fit_em(const Arm& start, std::span<const signals::Recording> recordings,
                const EmOptions& options, std::string_view label, int jobs,
                const optimise::Checkpoint& checkpoint) {
  const auto begin = std::chrono::steady_clock::now();
  require_length_for_em(recordings);
  const Split split = split_recordings(recordings, options.hold_out);
  const ArmCoordinates coordinates(start, {.rigid_body = options.rigid_body,
                                           .rigid_rate = options.rigid_body_rate,
                                           .torque_scale = options.torque_scale});
  ArmPoint first(coordinates, start);
  first.move_to(first.c());

  Sizes sizes = sizes_of(first.arm(), recordings, jobs);
  const Eigen::Index n = start.robot.n();
  const Eigen::VectorXd least_Qv = sizes.variance_v(options.torque_floor);
  const LatentNoise first_noise = noise_of(sizes, recordings, options);
  State now{first, first, optimise::Adam(coordinates.size()), first_noise, first_noise};
  now.z_noise = options.z_noise_first;
  now.length_step.setConstant(std::ssize(length_coordinates(first)), kMostLengthStep);
  EmReport report;
  report.held_out_start = now.best =
      held_out_error(first.arm(), recordings, split, options.judge, jobs);
  checkpoint.load(now);

  TransitionSums sums(now.point.arm(), recordings, options);
  Rng rng(options.seed, 2, now.draw);
  Progress progress(fmt::format("EM {}", label), options.iterations);
  progress.advance(now.iteration);
  // sd of z falls geometrically over the first iterations, but not where the noise is all used up
  const double falling = std::max(1.0, kFallingShare * options.iterations);
  const double fall = std::pow(options.z_noise_last / options.z_noise_first, 1 / falling);
  while (now.iteration < options.iterations) {
    throw_if_stopped();
    EmIteration seen;
    const Arm& arm = now.point.arm();
    const auto z = wash_out(arm, recordings, jobs);
    sizes.z = latent_sizes(z);
    now.noise.z = (now.z_noise * sizes.z).cwiseAbs2();

    // E-step: one recording per task
    std::vector<EStepResult> smoothed(recordings.size());
    std::vector<smc::Gaussian> starts;
    for (std::size_t r = 0; r < recordings.size(); ++r)
      starts.push_back(initial_state(recordings[r], z[r].row(0), sizes.z, now.noise));
    parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
      const auto r = static_cast<std::size_t>(i);
      LatentFrictionModel model(arm, recordings[r], now.noise, starts[r], options.step);
      const auto sequence = static_cast<std::uint32_t>(now.iteration * std::ssize(recordings) + i);
      smoothed[r] =
          smooth(model, recordings[r], split.train_end[r],
                 {options.e_step, options.particles, options.paths, options.seed, sequence});
    });
    std::vector<Paths> paths;
    seen.least_roots = 1;
    bool failed = false;
    for (EStepResult& result : smoothed) {
      failed = failed || result.failed;
      seen.log_likelihood += result.log_likelihood;
      seen.nis += result.nis / static_cast<double>(smoothed.size());
      seen.least_roots = std::min(seen.least_roots, result.roots);
      seen.least_backward_ess = paths.empty()
                                    ? result.backward_ess
                                    : std::min(seen.least_backward_ess, result.backward_ess);
      paths.push_back(std::move(result.paths));
    }
    if (failed) {
      report.message = fmt::format("the {} filter lost all weight in iteration {}",
                                   name_of(options.e_step), now.iteration + 1);
      break;
    }
    now.warnings = smoothed.front().warnings;
    if (seen.nis < options.most_nis)
      now.z_noise = std::max(options.z_noise_last, now.z_noise * fall);

    const std::vector<Transition> all = all_transitions(paths);
    const Likelihood likelihood{recordings, split, options.step, now.noise, starts, jobs};
    if (options.m_step == MStep::kScore && now.point.c().size() <= kMostForNormalEquations)
      climb_by_score(likelihood, now.damping, now.point);
    else
      maximise_transitions(sums, all, paths, now.noise, options,
                           {.slower = 3 * now.iteration < 2 * options.iterations ? 1 : 0.3,
                            .rigid_body = now.iteration >= options.rigid_body_from},
                           now.adam, rng, jobs, now.point);
    if (options.lengths) climb_by_lengths(likelihood, now.length_step, now.point);

    const TransitionSums::Sum residual =
        sums.run(arm, all, paths, now.noise, TransitionSums::Wants::kSquares, jobs);
    now.noise.v = residual.squares.segment(n, n).cwiseMax(least_Qv);
    seen.velocity_sd = std::exp(0.5 * now.noise.v.array().log().mean());
    if (options.free_observation_noise && now.iteration + 1 >= falling)
      now.noise.R = observation_noise(paths, recordings);
    seen.objective = residual.loss;
    seen.held_out = held_out_error(arm, recordings, split, options.judge, jobs);
    now.history.push_back(seen);
    if (options.keep == Keep::kLast || seen.held_out < now.best) {
      now.best = seen.held_out;
      now.best_iteration = now.iteration;
      now.best_point = now.point;
      now.best_noise = now.noise;
    }
    ++now.iteration;
    progress.advance(1, fmt::format("log-likelihood {:.6g}, NIS {:.2f}, held out {:.2e} rad2",
                                    seen.log_likelihood, seen.nis, seen.held_out));
    State left = now;
    left.draw = rng.draw();
    left.seconds += seconds_since(begin);
    checkpoint.save(left);
  }

  report.arm = now.best_iteration >= 0 ? now.best_point.arm() : start;
  report.noise = now.best_noise;
  report.best = now.best_iteration;
  report.iterations = std::move(now.history);
  report.warnings = std::move(now.warnings);
  report.seconds = now.seconds + seconds_since(begin);
  if (report.iterations.empty() && options.iterations > 0) return report;  // failed at once
  report.outcome = Outcome::kIterationLimit;
  if (now.iteration == options.iterations)
    report.message =
        fmt::format("held-out error {:.2e} rad2 after {} of {} iterations, {:.2e} before", now.best,
                    report.best + 1, options.iterations, report.held_out_start);
  checkpoint.remove();
  return report;
}

}  // namespace fricid::estimate
