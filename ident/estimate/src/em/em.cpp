#include "fricid/estimate/em/em.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "em/score_step.hpp"
#include "em/transition_step.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/online/online.hpp"
#include "fricid/system/driven_friction.hpp"
#include "support.hpp"
#include "training.hpp"

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
  double rows = 0, poses = 0;
  for (const Recording& r : recordings) {
    const auto driven = drive_friction(arm.friction, r.dt, r.q, r.v, r.tau, r.temperature);
    sizes.friction += driven.tau_f.cwiseAbs2().colwise().sum().transpose();
    rows += r.length();
    for (int k = 0; k < r.length(); k += 100, poses += 1)
      sizes.mobility += r.dt * mobility(arm.robot, r, k);
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

/// What one iteration leaves to the next.
struct State {
  int iteration = 0, best_iteration = -1;
  double best = 0, z_noise = 0, damping = kFirstDamping, seconds = 0;
  std::uint64_t draw = 0;  // of the random numbers
  Eigen::VectorXd c, best_c;
  LatentNoise noise, best_noise;
  std::vector<EmIteration> history;
  std::vector<std::string> warnings;
};

std::vector<double> list(const Eigen::VectorXd& x) { return {x.begin(), x.end()}; }

FitState to_fit_state(const State& state) {
  FitState out{state.iteration, {}, state.warnings};
  out.numbers["scalars"] = {static_cast<double>(state.best_iteration),
                            state.best,
                            state.z_noise,
                            state.damping,
                            state.seconds,
                            static_cast<double>(state.draw)};
  out.numbers["c"] = list(state.c);
  out.numbers["best_c"] = list(state.best_c);
  out.numbers["Q_v"] = list(state.noise.v);
  out.numbers["R"] = list(state.noise.R);
  out.numbers["best_Q_v"] = list(state.best_noise.v);
  out.numbers["best_Q_z"] = list(state.best_noise.z);
  out.numbers["best_R"] = list(state.best_noise.R);
  for (const EmIteration& i : state.history)
    out.numbers["history"].insert(
        out.numbers["history"].end(),
        {i.log_likelihood, i.nis, i.least_roots, i.least_backward_ess, i.objective, i.held_out});
  return out;
}

/// @pre `state` has the noise that EM begins with
void take(const FitState& saved, State& state) {
  const auto numbers = [&](const char* name) {
    const std::vector<double>& list = saved.numbers.at(name);
    return Eigen::VectorXd::Map(list.data(), std::ssize(list));
  };
  const Eigen::VectorXd scalars = numbers("scalars");
  state.iteration = saved.iteration;
  state.best_iteration = static_cast<int>(scalars[0]);
  state.best = scalars[1];
  state.z_noise = scalars[2];
  state.damping = scalars[3];
  state.seconds = scalars[4];
  state.draw = static_cast<std::uint64_t>(scalars[5]);
  state.c = numbers("c");
  state.best_c = numbers("best_c");
  state.noise.v = numbers("Q_v");
  state.noise.R = numbers("R");
  state.best_noise.v = numbers("best_Q_v");
  state.best_noise.z = numbers("best_Q_z");
  state.best_noise.R = numbers("best_R");
  const Eigen::VectorXd h = numbers("history");
  for (Eigen::Index i = 0; i + 5 < h.size(); i += 6)
    state.history.push_back({h[i], h[i + 1], h[i + 2], h[i + 3], h[i + 4], h[i + 5]});
  state.warnings = saved.warnings;
}

/// Mean square of what the paths leave of the positions, per joint.
Eigen::VectorXd observation_noise(std::span<const Paths> paths,
                                  std::span<const Recording> recordings) {
  const int n = recordings.front().n();
  Eigen::VectorXd square = Eigen::VectorXd::Zero(n), count = square;
  for (std::size_t r = 0; r < paths.size(); ++r)
    for (const smc::RowMatrix& path : paths[r])
      for (Eigen::Index t = 0; t < path.rows(); ++t)
        for (int j = 0; j < n; ++j) {
          const double y = recordings[r].q_measured(t, j);
          if (std::isnan(y)) continue;
          square[j] += (y - path(t, j)) * (y - path(t, j));
          count[j] += 1;
        }
  return square.cwiseQuotient(count.cwiseMax(1)).cwiseMax(kSmallestR);
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
                std::string_view label, int jobs, const Checkpoint& checkpoint) {
  const auto begin = std::chrono::steady_clock::now();
  const Split split = split_recordings(recordings, options.hold_out);
  const ArmCoordinates coordinates(start, options.coordinates);
  Arm arm = start;
  State now;
  now.c = now.best_c = coordinates.start();
  coordinates.apply(now.c, arm);

  const Sizes sizes = sizes_of(arm, recordings, jobs);
  const Eigen::Index n = arm.robot.n();
  const Eigen::VectorXd least_Qv = sizes.variance_v(options.torque_floor);
  now.noise = now.best_noise = noise_of(sizes, recordings, options);
  now.z_noise = options.z_noise_first;
  EmReport report;
  report.held_out_start = now.best = held_out_error(arm, recordings, split, options.judge, jobs);
  if (const auto saved = checkpoint.load()) take(*saved, now);
  coordinates.apply(now.c, arm);

  TransitionSums sums(arm, recordings, options);
  Rng rng(options.seed, 2, now.draw);
  Progress progress(fmt::format("EM {}", label), options.iterations);
  progress.advance(now.iteration);
  // sd of z falls geometrically over the first iterations, but not where the noise is all used up
  const double falling = std::max(1.0, kFallingShare * options.iterations);
  const double fall = std::pow(options.z_noise_last / options.z_noise_first, 1 / falling);
  while (now.iteration < options.iterations) {
    throw_if_stopped();
    EmIteration seen;
    now.noise.z = (now.z_noise * sizes.z).cwiseAbs2();

    // E-step: one recording per task
    const auto z = wash_out(arm, recordings, jobs);
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
                                   to_string(options.e_step), now.iteration + 1);
      break;
    }
    now.warnings = smoothed.front().warnings;
    if (seen.nis < options.most_nis)
      now.z_noise = std::max(options.z_noise_last, now.z_noise * fall);

    const std::vector<Transition> all = all_transitions(paths);
    if (options.m_step == MStep::kScore && now.c.size() <= kMostForNormalEquations)
      climb_by_score({recordings, split, options.step, now.noise, starts, jobs}, coordinates,
                     now.damping, arm, now.c);
    else
      maximise_transitions(sums, coordinates, all, paths, now.noise, options,
                           3 * now.iteration < 2 * options.iterations ? 1 : 0.3, rng, jobs, arm,
                           now.c);

    const TransitionSums::Sum residual =
        sums.run(arm, all, paths, now.noise, TransitionSums::Wants::kSquares, jobs);
    now.noise.v = residual.squares.segment(n, n).cwiseMax(least_Qv);
    if (options.free_observation_noise && now.iteration + 1 >= falling)
      now.noise.R = observation_noise(paths, recordings);
    seen.objective = residual.loss;
    seen.held_out = held_out_error(arm, recordings, split, options.judge, jobs);
    now.history.push_back(seen);
    if (options.keep_last || seen.held_out < now.best) {
      now.best = seen.held_out;
      now.best_iteration = now.iteration;
      now.best_c = now.c;
      now.best_noise = now.noise;
    }
    ++now.iteration;
    progress.advance(1, fmt::format("log-likelihood {:.6g}, NIS {:.2f}, held out {:.2e} rad2",
                                    seen.log_likelihood, seen.nis, seen.held_out));
    State left = now;
    left.draw = rng.draw();
    left.seconds += seconds_since(begin);
    checkpoint.save(to_fit_state(left));
  }

  report.arm = start;
  if (now.best_iteration >= 0) coordinates.apply(now.best_c, report.arm);
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
