#include "fricid/estimate/em.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/LU>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/online.hpp"
#include "fricid/system/driven_friction.hpp"
#include "score_step.hpp"
#include "support.hpp"
#include "transition_step.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPositionNoise = 0.25;  // sd of w on q, share of the encoder noise
constexpr double kVelocityStart = 0.02;  // sd of the first velocity [rad/s]
constexpr double kFallingShare = 0.7;    // of the iterations, in which the noise of z falls
constexpr double kSmallestR = 1e-14;     // [rad^2]

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

Sizes sizes_of(const Arm& arm, std::span<const Recording> recordings, int jobs) {
  const int n = arm.robot.n();
  Sizes sizes{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n),
              latent_sizes(wash_out(arm, recordings, jobs))};
  dynamics::Workspace<double> ws(arm.robot);
  Eigen::MatrixXd M(n, n);
  double rows = 0, poses = 0;
  for (const Recording& r : recordings) {
    const auto driven = drive_friction(arm.friction, r.dt, r.q, r.v, r.tau, r.temperature);
    sizes.friction += driven.tau_f.cwiseAbs2().colwise().sum().transpose();
    rows += r.length();
    for (int k = 0; k < r.length(); k += 100, poses += 1) {
      dynamics::crba<double>(arm.robot, ws, view(arm.robot.pi),
                             {r.q.row(k).data(), static_cast<std::size_t>(n)},
                             {M.data(), static_cast<std::size_t>(n * n)});
      sizes.mobility += r.dt * M.inverse().diagonal();
    }
  }
  sizes.friction = (sizes.friction / rows).cwiseSqrt();
  sizes.mobility /= poses;
  return sizes;
}

LatentNoise noise_of(const Sizes& sizes, std::span<const Recording> recordings,
                     const EmOptions& options) {
  LatentNoise noise;
  noise.dt = recordings.front().dt;
  noise.R = Eigen::VectorXd::Zero(sizes.friction.size());
  for (const Recording& r : recordings)
    noise.R += r.noise_sd.cwiseAbs2() / static_cast<double>(recordings.size());
  noise.R = noise.R.cwiseMax(kSmallestR);
  noise.q = kPositionNoise * kPositionNoise * noise.R;
  noise.v = sizes.variance_v(options.torque_noise);
  noise.z = (options.z_noise_first * sizes.z).cwiseAbs2();
  return noise;
}

}  // namespace

std::string_view to_string(MStep m_step) {
  return m_step == MStep::kScore ? "score" : "transitions";
}

Eigen::VectorXd latent_sizes(std::span<const data::RowMatrix> z) {
  Eigen::VectorXd sizes = Eigen::VectorXd::Zero(z.front().cols());
  double rows = 0;
  for (const data::RowMatrix& states : z) {
    sizes += states.cwiseAbs2().colwise().sum().transpose();
    rows += static_cast<double>(states.rows());
  }
  sizes = (sizes / rows).cwiseSqrt();
  for (double& size : sizes)
    if (!(size > 0)) size = 1;
  return sizes;
}

LatentNoise initial_noise(const Arm& arm, std::span<const Recording> recordings,
                          const EmOptions& options) {
  return noise_of(sizes_of(arm, recordings, 1), recordings, options);
}

smc::Gaussian initial_state(const Recording& recording, const Eigen::VectorXd& z,
                            const Eigen::VectorXd& z_size, const LatentNoise& noise) {
  return online_start(recording.q.row(0), recording.v.row(0), z, noise, kVelocityStart, z_size);
}

EmReport fit_em(const Arm& start, std::span<const Recording> recordings, const EmOptions& options,
                std::string_view label, int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const Split split = split_recordings(recordings, options.hold_out);
  EmReport report;
  report.arm = start;
  const ArmCoordinates coordinates(start, options.coordinates);
  Arm arm = start;
  Eigen::VectorXd c = coordinates.start();
  coordinates.apply(c, arm);

  const Sizes sizes = sizes_of(arm, recordings, jobs);
  LatentNoise noise = noise_of(sizes, recordings, options);
  const Eigen::Index n = arm.robot.n();
  const Eigen::VectorXd least_Qv = sizes.variance_v(options.torque_floor);
  report.noise = noise;
  report.held_out_start = held_out_error(arm, recordings, split, options.judge, jobs);
  double best = report.held_out_start;

  TransitionSums sums(arm, recordings, options);
  double damping = kFirstDamping;
  Rng rng(options.seed, 2);
  Progress progress(fmt::format("EM {}", label), options.iterations);
  // sd of z falls geometrically over the first iterations, but not where the noise is all used up
  double z_noise = options.z_noise_first;
  const double fall = std::pow(options.z_noise_last / options.z_noise_first,
                               1 / std::max(1.0, kFallingShare * options.iterations));
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    if (stop_requested()) {
      report.stopped = true;
      break;
    }
    EmIteration now;
    noise.z = (z_noise * sizes.z).cwiseAbs2();

    // E-step: one recording per task
    const auto z = wash_out(arm, recordings, jobs);
    std::vector<EStepResult> smoothed(recordings.size());
    std::vector<smc::Gaussian> starts;
    for (std::size_t r = 0; r < recordings.size(); ++r)
      starts.push_back(initial_state(recordings[r], z[r].row(0), sizes.z, noise));
    parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
      const auto r = static_cast<std::size_t>(i);
      LatentFrictionModel model(arm, recordings[r], noise, starts[r], options.step);
      EStepOptions e_options{options.e_step, options.particles, options.paths, options.seed,
                             static_cast<std::uint32_t>(iteration * std::ssize(recordings) + i)};
      smoothed[r] = smooth(model, recordings[r], split.train_end[r], e_options);
    });
    std::vector<Paths> paths;
    now.least_roots = 1;
    for (EStepResult& result : smoothed) {
      if (result.failed) {
        report.message = fmt::format("the {} filter lost all weight in iteration {}",
                                     to_string(options.e_step), iteration + 1);
        report.outcome = iteration > 0 ? Outcome::kIterationLimit : Outcome::kFailed;
        report.seconds = seconds_since(begin);
        return report;
      }
      now.log_likelihood += result.log_likelihood;
      now.nis += result.nis / static_cast<double>(smoothed.size());
      now.least_roots = std::min(now.least_roots, result.roots);
      now.least_backward_ess = paths.empty()
                                   ? result.backward_ess
                                   : std::min(now.least_backward_ess, result.backward_ess);
      paths.push_back(std::move(result.paths));
    }
    report.warnings = smoothed.front().warnings;
    if (now.nis < options.most_nis) z_noise = std::max(options.z_noise_last, z_noise * fall);

    const std::vector<Transition> all = all_transitions(paths);
    if (options.m_step == MStep::kScore && c.size() <= kMostForNormalEquations)
      climb_by_score({recordings, split, options.step, noise, starts, jobs}, coordinates, damping,
                     arm, c);
    else
      maximise_transitions(sums, coordinates, all, paths, noise, options,
                           3 * iteration < 2 * options.iterations ? 1 : 0.3, rng, jobs, arm, c);

    // that of v in closed form above its floor; that of q stays, that of z follows its schedule
    const TransitionSums::Sum residual =
        sums.run(arm, all, paths, noise, TransitionSums::Wants::kSquares, jobs);
    noise.v = residual.squares.segment(n, n).cwiseMax(least_Qv);
    now.objective = residual.loss;
    now.held_out = held_out_error(arm, recordings, split, options.judge, jobs);
    report.iterations.push_back(now);
    if (now.held_out < best) {
      best = now.held_out;
      report.best = iteration;
      report.arm = arm;
      report.noise = noise;
    }
    progress.advance(1, fmt::format("log-likelihood {:.6g}, NIS {:.2f}, held out {:.2e} rad2",
                                    now.log_likelihood, now.nis, now.held_out));
  }
  report.outcome = Outcome::kIterationLimit;
  report.message =
      fmt::format("held-out error {:.2e} rad2 after {} of {} iterations, {:.2e} before", best,
                  report.best + 1, options.iterations, report.held_out_start);
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace fricid::estimate
