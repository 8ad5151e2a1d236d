#include "em/transition_step.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "em/score_step.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/estimate/adam.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr int kLanes = TransitionLoss::lanes();
constexpr int kPacksPerTask = 16;             // a task of about 0.1 ms
constexpr int kBatchesOfNormalEquations = 4;  // of EmOptions::batch
constexpr int kNormalEquationSteps = 6, kAttempts = 5;
constexpr double kLongestStep = 0.3;  // of a coordinate

std::vector<Transition> draw(const std::vector<Transition>& all, int count, Rng& rng) {
  std::vector<Transition> some(static_cast<std::size_t>(count));
  const auto size = static_cast<double>(all.size());
  for (Transition& t : some)
    t = all[std::min(all.size() - 1, static_cast<std::size_t>(rng.uniform() * size))];
  return some;
}

/// Adam on random batches, the coordinates averaged over its second half.
void maximise_by_adam(TransitionSums& sums, const ArmCoordinates& coordinates,
                      const std::vector<Transition>& all, std::span<const Paths> paths,
                      const LatentNoise& noise, const EmOptions& options, double slower, Rng& rng,
                      int jobs, Arm& arm, Eigen::VectorXd& c) {
  Adam adam(coordinates.size());
  Eigen::VectorXd average = Eigen::VectorXd::Zero(c.size()), c_bar;
  for (int k = 0; k < options.m_steps; ++k) {
    const auto batch = draw(all, options.batch, rng);
    const TransitionSums::Sum mean =
        sums.run(arm, batch, paths, noise, TransitionSums::Wants::kGradient, jobs);
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
void maximise_by_normal_equations(TransitionSums& sums, const ArmCoordinates& coordinates,
                                  const std::vector<Transition>& all, std::span<const Paths> paths,
                                  const LatentNoise& noise, const EmOptions& options, Rng& rng,
                                  int jobs, Arm& arm, Eigen::VectorXd& c) {
  const auto batch = draw(all, kBatchesOfNormalEquations * options.batch, rng);
  const auto count = static_cast<double>(all.size()) / options.paths;
  const auto pi_size = arm.robot.pi.size();
  const auto theta_size = static_cast<Eigen::Index>(arm.friction.theta.size());
  double damping = kFirstDamping;
  for (int k = 0; k < kNormalEquationSteps; ++k) {
    const TransitionSums::Sum here =
        sums.run(arm, batch, paths, noise, TransitionSums::Wants::kNormalEquations, jobs,
                 coordinates.jacobian(c, pi_size, theta_size));
    bool moved = false;
    for (int attempt = 0; attempt < kAttempts && !moved; ++attempt) {
      Eigen::MatrixXd H = here.JJ;
      H.diagonal() *= 1 + damping;
      H.diagonal().array() += 1 / count;  // one nat per unit of a coordinate over all data
      const Eigen::VectorXd step = H.ldlt().solve(-here.Jw);
      Eigen::VectorXd trial = c + step.cwiseMax(-kLongestStep).cwiseMin(kLongestStep);
      trial = trial.cwiseMax(coordinates.lower()).cwiseMin(coordinates.upper());
      coordinates.apply(trial, arm);
      const double loss =
          sums.run(arm, batch, paths, noise, TransitionSums::Wants::kLoss, jobs).loss;
      moved = loss < here.loss;
      if (moved) c = trial;
      damping = std::clamp(moved ? damping / 5 : damping * 10, 1e-9, 1e6);
    }
    coordinates.apply(c, arm);
    if (!moved) return;
  }
}

}  // namespace

TransitionSums::TransitionSums(const Arm& arm, std::span<const Recording> recordings,
                               const EmOptions& options)
    : packs_(std::max(1, options.batch / (kLanes * kPacksPerTask))) {
  for (int p = 0; p < packs_; ++p) losses_.emplace_back(arm, recordings, options.step);
  parts_.resize(static_cast<std::size_t>(packs_));
}

TransitionSums::Sum TransitionSums::run(const Arm& arm, std::span<const Transition> transitions,
                                        std::span<const Paths> paths, const LatentNoise& noise,
                                        Wants wants, int jobs,
                                        const Eigen::MatrixXd& parameters_of) {
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
      part.loss += losses_[i].loss(
          some, paths, noise, wants == Wants::kSquares ? view(part.squares) : std::span<double>());
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
  mean.JJ.triangularView<Eigen::StrictlyUpper>() = mean.JJ.transpose();
  mean.JJ *= share;
  mean.Jw *= share;
  mean.loss *= share;
  return mean;
}

std::vector<Transition> all_transitions(std::span<const Paths> paths) {
  std::vector<Transition> all;
  for (std::size_t r = 0; r < paths.size(); ++r)
    for (std::size_t p = 0; p < paths[r].size(); ++p)
      for (int t = 0; t + 1 < paths[r][p].rows(); ++t)
        all.push_back({static_cast<int>(r), static_cast<int>(p), t});
  return all;
}

void maximise_transitions(TransitionSums& sums, const ArmCoordinates& coordinates,
                          const std::vector<Transition>& all, std::span<const Paths> paths,
                          const LatentNoise& noise, const EmOptions& options, double slower,
                          Rng& rng, int jobs, Arm& arm, Eigen::VectorXd& c) {
  if (options.m_steps == 0) return;
  if (c.size() <= kMostForNormalEquations)
    maximise_by_normal_equations(sums, coordinates, all, paths, noise, options, rng, jobs, arm, c);
  else
    maximise_by_adam(sums, coordinates, all, paths, noise, options, slower, rng, jobs, arm, c);
}

}  // namespace fricid::estimate
