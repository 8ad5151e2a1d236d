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
#include "fricid/estimate/adam.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPositionNoise = 0.25;  // sd of w on q, share of the encoder noise
constexpr double kVelocityStart = 0.02;  // sd of the first velocity [rad/s]
constexpr double kFallingShare = 0.7;    // of the iterations, in which the noise of z falls
constexpr double kSmallestR = 1e-14;     // [rad^2]

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::span<const double> view(const Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}
std::span<double> view(Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

/// Size of the friction torque per joint, and what one N m does to v in a sample.
struct Sizes {
  Eigen::VectorXd friction;  // rms [N m]
  Eigen::VectorXd mobility;  // dt mean (M^-1)_jj [rad/s per N m]
};

Sizes joint_sizes(const Arm& arm, std::span<const Recording> recordings) {
  const int n = arm.robot.n();
  Sizes sizes{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
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

/// All transitions of all paths.
class MStep {
 public:
  MStep(const Arm& arm, std::span<const Recording> recordings, const EmOptions& options)
      : options_(options), packs_(std::max(1, options.batch / (kLanes * kPacksPerTask))) {
    for (int p = 0; p < packs_; ++p) losses_.emplace_back(arm, recordings, options.step);
    parts_.resize(static_cast<std::size_t>(packs_));
  }

  struct Sum {
    Eigen::VectorXd pi, theta, squares;
    double loss = 0;
    long count = 0;
  };

  /// Mean loss over `transitions`, and its gradient or the mean squares of the residuals.
  Sum run(const Arm& arm, std::span<const Transition> transitions, std::span<const Paths> paths,
          const LatentNoise& noise, bool gradient, int jobs) {
    parallel_for(packs_, jobs, [&](int p) {
      const auto i = static_cast<std::size_t>(p);
      Sum& part = parts_[i];
      part.pi.setZero(arm.robot.pi.size());
      part.theta.setZero(static_cast<Eigen::Index>(arm.friction.theta.size()));
      part.squares.setZero(2 * noise.v.size() + noise.z.size());
      part.loss = 0;
      losses_[i].set_parameters(view(arm.robot.pi), arm.friction.theta);
      const std::size_t share = (transitions.size() + static_cast<std::size_t>(packs_) - 1) /
                                static_cast<std::size_t>(packs_);
      const std::size_t end = std::min(transitions.size(), (i + 1) * share);
      for (std::size_t at = i * share; at < end; at += kLanes) {
        const auto some = transitions.subspan(at, std::min<std::size_t>(kLanes, end - at));
        part.loss += losses_[i].loss(some, paths, noise,
                                     gradient ? std::span<double>() : view(part.squares));
        if (gradient) losses_[i].add_gradient(view(part.pi), view(part.theta));
      }
    });
    Sum mean = parts_[0];
    for (std::size_t i = 1; i < parts_.size(); ++i) {
      mean.pi += parts_[i].pi;
      mean.theta += parts_[i].theta;
      mean.squares += parts_[i].squares;
      mean.loss += parts_[i].loss;
    }
    const double share = 1 / static_cast<double>(transitions.size());
    mean.pi *= share;
    mean.theta *= share;
    mean.squares *= share;
    mean.loss *= share;
    return mean;
  }

 private:
  static constexpr int kLanes = TransitionLoss::lanes();
  static constexpr int kPacksPerTask = 16;  // a task of about 0.1 ms

  EmOptions options_;
  int packs_;
  std::vector<TransitionLoss> losses_;
  std::vector<Sum> parts_;
};

std::vector<Transition> all_transitions(std::span<const Paths> paths) {
  std::vector<Transition> all;
  for (std::size_t r = 0; r < paths.size(); ++r)
    for (std::size_t p = 0; p < paths[r].size(); ++p)
      for (int t = 0; t + 1 < paths[r][p].rows(); ++t)
        all.push_back({static_cast<int>(r), static_cast<int>(p), t});
  return all;
}

}  // namespace

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
  const int n = arm.robot.n();
  const Sizes joints = joint_sizes(arm, recordings);
  const Eigen::VectorXd z_size = latent_sizes(wash_out(arm.friction, recordings, 1));

  LatentNoise noise;
  noise.dt = recordings.front().dt;
  noise.R = Eigen::VectorXd::Zero(n);
  for (const Recording& r : recordings)
    noise.R += r.noise_sd.cwiseAbs2() / static_cast<double>(recordings.size());
  noise.R = noise.R.cwiseMax(kSmallestR);
  noise.q = kPositionNoise * kPositionNoise * noise.R;
  noise.v = (options.torque_noise * joints.friction.cwiseProduct(joints.mobility)).cwiseAbs2();
  noise.z = (options.z_noise_first * z_size).cwiseAbs2();
  return noise;
}

smc::Gaussian initial_state(const Recording& recording, const Eigen::VectorXd& z,
                            const Eigen::VectorXd& z_size, const LatentNoise& noise) {
  const Eigen::Index n = recording.n(), nz = z.size();
  smc::Gaussian x;
  x.mean.resize(2 * n + nz);
  x.mean << recording.q.row(0).transpose(), recording.v.row(0).transpose(), z;
  Eigen::VectorXd variance(2 * n + nz);
  variance << 4 * noise.R.head(n), Eigen::VectorXd::Constant(n, kVelocityStart * kVelocityStart),
      z_size.cwiseAbs2();
  x.covariance = variance.asDiagonal();
  return x;
}

EmReport fit_em(const Arm& start, std::span<const Recording> recordings, const EmOptions& options,
                std::string_view label, int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const Split split = split_recordings(recordings, options.hold_out);
  EmReport report;
  report.arm = start;
  const ArmCoordinates coordinates(start, options.coordinates);
  Arm arm = start;
  Eigen::VectorXd c = coordinates.start(), c_bar;
  coordinates.apply(c, arm);

  const Eigen::VectorXd z_size = latent_sizes(wash_out(arm.friction, recordings, jobs));
  LatentNoise noise = initial_noise(arm, recordings, options);
  const Sizes joints = joint_sizes(arm, recordings);
  const Eigen::Index n = arm.robot.n();
  const Eigen::VectorXd least_Qv =
      (options.torque_floor * joints.friction.cwiseProduct(joints.mobility)).cwiseAbs2();
  report.noise = noise;
  report.held_out_start = held_out_error(arm, recordings, split, options.judge, jobs);
  double best = report.held_out_start;

  MStep m_step(arm, recordings, options);
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
    noise.z = (z_noise * z_size).cwiseAbs2();

    // E-step: one recording per task
    const auto z = wash_out(arm.friction, recordings, jobs);
    std::vector<EStepResult> smoothed(recordings.size());
    parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
      const auto r = static_cast<std::size_t>(i);
      LatentFrictionModel model(arm, recordings[r], noise,
                                initial_state(recordings[r], z[r].row(0), z_size, noise),
                                options.step);
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

    // M-step: the coordinates averaged over its second half
    const std::vector<Transition> all = all_transitions(paths);
    const double rate = options.rate * (3 * iteration < 2 * options.iterations ? 1 : 0.3);
    Adam adam(coordinates.size());
    Eigen::VectorXd average = Eigen::VectorXd::Zero(c.size());
    std::vector<Transition> batch(static_cast<std::size_t>(options.batch));
    for (int k = 0; k < options.m_steps; ++k) {
      for (Transition& t : batch)
        t = all[std::min(all.size() - 1, static_cast<std::size_t>(
                                             rng.uniform() * static_cast<double>(all.size())))];
      const MStep::Sum mean = m_step.run(arm, batch, paths, noise, true, jobs);
      coordinates.pull_back(c, mean.pi, mean.theta, c_bar);
      // steps shorten towards the end: the quieter the model, the steeper its density
      const double shorter = 1 - 0.9 * k / options.m_steps;
      adam.step(c_bar, shorter * rate, coordinates.rate(), coordinates.lower(), coordinates.upper(),
                c);
      coordinates.apply(c, arm);
      if (2 * k >= options.m_steps) average += c;
    }
    if (options.m_steps > 0) c = average / (options.m_steps - options.m_steps / 2);
    coordinates.apply(c, arm);

    // that of v in closed form above its floor; that of q stays, that of z follows its schedule
    const MStep::Sum residual = m_step.run(arm, all, paths, noise, false, jobs);
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
