#include "fricid/estimate/em.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/adam.hpp"
#include "fricid/estimate/online.hpp"
#include "fricid/system/driven_friction.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPositionNoise = 0.25;       // sd of w on q, share of the encoder noise
constexpr double kVelocityStart = 0.02;       // sd of the first velocity [rad/s]
constexpr double kFallingShare = 0.7;         // of the iterations, in which the noise of z falls
constexpr int kMostForNormalEquations = 400;  // coordinates; networks have thousands
constexpr int kBatchesOfNormalEquations = 4;  // of EmOptions::batch
constexpr int kNormalEquationSteps = 6, kAttempts = 5;
constexpr double kFirstDamping = 1e-3, kLongestStep = 0.3;
constexpr double kSmallestR = 1e-14;  // [rad^2]

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
              latent_sizes(wash_out(arm.friction, recordings, jobs))};
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

/// Sums over transitions, packs of them in parallel.
class MStep {
 public:
  MStep(const Arm& arm, std::span<const Recording> recordings, const EmOptions& options)
      : packs_(std::max(1, options.batch / (kLanes * kPacksPerTask))) {
    for (int p = 0; p < packs_; ++p) losses_.emplace_back(arm, recordings, options.step);
    parts_.resize(static_cast<std::size_t>(packs_));
  }

  struct Sum {
    Eigen::VectorXd pi, theta, squares;
    Eigen::MatrixXd JJ;
    Eigen::VectorXd Jw;
    double loss = 0;
  };
  enum class Wants { kGradient, kSquares, kNormalEquations, kLoss };

  /// Mean loss over `transitions`, and its gradient, the mean squares of the residuals, or the
  /// normal equations in the coordinates that `parameters_of` belongs to.
  Sum run(const Arm& arm, std::span<const Transition> transitions, std::span<const Paths> paths,
          const LatentNoise& noise, Wants wants, int jobs,
          const Eigen::MatrixXd& parameters_of = {}) {
    parallel_for(packs_, jobs, [&](int p) {
      const auto i = static_cast<std::size_t>(p);
      Sum& part = parts_[i];
      part.pi.setZero(arm.robot.pi.size());
      part.theta.setZero(static_cast<Eigen::Index>(arm.friction.theta.size()));
      part.squares.setZero(2 * noise.v.size() + noise.z.size());
      part.loss = 0;
      part.JJ.setZero(parameters_of.cols(), parameters_of.cols());
      part.Jw.setZero(parameters_of.cols());
      losses_[i].set_parameters(view(arm.robot.pi), arm.friction.theta);
      const std::size_t share = (transitions.size() + static_cast<std::size_t>(packs_) - 1) /
                                static_cast<std::size_t>(packs_);
      const std::size_t end = std::min(transitions.size(), (i + 1) * share);
      for (std::size_t at = i * share; at < end; at += kLanes) {
        const auto some = transitions.subspan(at, std::min<std::size_t>(kLanes, end - at));
        part.loss +=
            losses_[i].loss(some, paths, noise,
                            wants == Wants::kSquares ? view(part.squares) : std::span<double>());
        if (wants == Wants::kGradient) losses_[i].add_gradient(view(part.pi), view(part.theta));
        if (wants == Wants::kNormalEquations)
          losses_[i].add_normal_equations(parameters_of, noise, part.JJ, part.Jw);
      }
    });
    Sum mean = parts_[0];
    for (std::size_t i = 1; i < parts_.size(); ++i) {
      mean.pi += parts_[i].pi;
      mean.theta += parts_[i].theta;
      mean.squares += parts_[i].squares;
      mean.JJ += parts_[i].JJ;
      mean.Jw += parts_[i].Jw;
      mean.loss += parts_[i].loss;
    }
    const double share = 1 / static_cast<double>(transitions.size());
    mean.pi *= share;
    mean.theta *= share;
    mean.squares *= share;
    mean.JJ = mean.JJ.selfadjointView<Eigen::Lower>() *
              Eigen::MatrixXd::Identity(mean.JJ.rows(), mean.JJ.cols());
    mean.JJ *= share;
    mean.Jw *= share;
    mean.loss *= share;
    return mean;
  }

 private:
  static constexpr int kLanes = TransitionLoss::lanes();
  static constexpr int kPacksPerTask = 16;  // a task of about 0.1 ms

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

std::vector<Transition> draw(const std::vector<Transition>& all, int count, Rng& rng) {
  std::vector<Transition> some(static_cast<std::size_t>(count));
  const auto size = static_cast<double>(all.size());
  for (Transition& t : some)
    t = all[std::min(all.size() - 1, static_cast<std::size_t>(rng.uniform() * size))];
  return some;
}

/// Adam on random batches, the coordinates averaged over its second half.
void maximise_by_adam(MStep& m_step, const ArmCoordinates& coordinates,
                      const std::vector<Transition>& all, std::span<const Paths> paths,
                      const LatentNoise& noise, const EmOptions& options, double slower, Rng& rng,
                      int jobs, Arm& arm, Eigen::VectorXd& c) {
  if (options.m_steps == 0) return;
  Adam adam(coordinates.size());
  Eigen::VectorXd average = Eigen::VectorXd::Zero(c.size()), c_bar;
  for (int k = 0; k < options.m_steps; ++k) {
    const auto batch = draw(all, options.batch, rng);
    const MStep::Sum mean = m_step.run(arm, batch, paths, noise, MStep::Wants::kGradient, jobs);
    coordinates.pull_back(c, mean.pi, mean.theta, c_bar);
    // steps shorten towards the end: the quieter the model, the steeper its density
    const double rate = slower * options.rate * (1 - 0.9 * k / options.m_steps);
    adam.step(c_bar, rate, coordinates.rate(), coordinates.lower(), coordinates.upper(), c);
    coordinates.apply(c, arm);
    if (2 * k >= options.m_steps) average += c;
  }
  c = average / (options.m_steps - options.m_steps / 2);
  coordinates.apply(c, arm);
}

/// Levenberg-Marquardt on one random batch, with a weak pull to where it starts.
void maximise_by_normal_equations(MStep& m_step, const ArmCoordinates& coordinates,
                                  const std::vector<Transition>& all, std::span<const Paths> paths,
                                  const LatentNoise& noise, const EmOptions& options, Rng& rng,
                                  int jobs, Arm& arm, Eigen::VectorXd& c) {
  if (options.m_steps == 0) return;
  const auto batch = draw(all, kBatchesOfNormalEquations * options.batch, rng);
  const auto count = static_cast<double>(all.size()) / options.paths;
  const auto pi_size = arm.robot.pi.size();
  const auto theta_size = static_cast<Eigen::Index>(arm.friction.theta.size());
  double damping = kFirstDamping;
  for (int k = 0; k < kNormalEquationSteps; ++k) {
    const MStep::Sum here = m_step.run(arm, batch, paths, noise, MStep::Wants::kNormalEquations,
                                       jobs, coordinates.jacobian(c, pi_size, theta_size));
    bool moved = false;
    for (int attempt = 0; attempt < kAttempts && !moved; ++attempt) {
      Eigen::MatrixXd H = here.JJ;
      H.diagonal() *= 1 + damping;
      H.diagonal().array() += 1 / count;  // one nat per unit of a coordinate over all data
      const Eigen::VectorXd step = H.ldlt().solve(-here.Jw);
      Eigen::VectorXd trial = c + step.cwiseMax(-kLongestStep).cwiseMin(kLongestStep);
      trial = trial.cwiseMax(coordinates.lower()).cwiseMin(coordinates.upper());
      coordinates.apply(trial, arm);
      const double loss = m_step.run(arm, batch, paths, noise, MStep::Wants::kLoss, jobs).loss;
      moved = loss < here.loss;
      if (moved) c = trial;
      damping = std::clamp(moved ? damping / 5 : damping * 10, 1e-9, 1e6);
    }
    coordinates.apply(c, arm);
    if (!moved) return;
  }
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
    noise.z = (z_noise * sizes.z).cwiseAbs2();

    // E-step: one recording per task
    const auto z = wash_out(arm.friction, recordings, jobs);
    std::vector<EStepResult> smoothed(recordings.size());
    parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
      const auto r = static_cast<std::size_t>(i);
      LatentFrictionModel model(arm, recordings[r], noise,
                                initial_state(recordings[r], z[r].row(0), sizes.z, noise),
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

    const std::vector<Transition> all = all_transitions(paths);
    if (c.size() <= kMostForNormalEquations)
      maximise_by_normal_equations(m_step, coordinates, all, paths, noise, options, rng, jobs, arm,
                                   c);
    else
      maximise_by_adam(m_step, coordinates, all, paths, noise, options,
                       3 * iteration < 2 * options.iterations ? 1 : 0.3, rng, jobs, arm, c);

    // that of v in closed form above its floor; that of q stays, that of z follows its schedule
    const MStep::Sum residual = m_step.run(arm, all, paths, noise, MStep::Wants::kSquares, jobs);
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
