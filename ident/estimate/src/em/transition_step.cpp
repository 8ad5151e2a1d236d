#include "em/transition_step.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/optimise/damped_step.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr int kLanes = TransitionLoss::lanes();
constexpr int kPacksPerTask = 16;             // a task of about 0.1 ms
constexpr int kBatchesOfNormalEquations = 4;  // of EmOptions::batch
constexpr int kNormalEquationSteps = 6;
constexpr double kLeastRidgeRate = 0.05;

std::vector<Transition> draw(const std::vector<Transition>& all, int count, Rng& rng) {
  std::vector<Transition> some(static_cast<std::size_t>(count));
  const auto size = static_cast<double>(all.size());
  for (Transition& t : some)
    t = all[std::min(all.size() - 1, static_cast<std::size_t>(rng.uniform() * size))];
  return some;
}

/// Adam on random batches, the coordinates averaged over its second half.
void maximise_by_adam(TransitionSums& sums, const std::vector<Transition>& all,
                      std::span<const Paths> paths, const LatentNoise& noise,
                      const EmOptions& options, const AdamStep& step, optimise::Adam& adam,
                      Rng& rng, int jobs, ArmPoint& point) {
  const ArmCoordinates& coordinates = point.coordinates();
  const Eigen::Index of_body =
      step.rigid_body ? 0 : point.c().size() - std::ssize(coordinates.friction());
  const Eigen::VectorXd ridge =
      options.ridge * coordinates.rate().cwiseMax(kLeastRidgeRate).cwiseInverse();
  Eigen::VectorXd c = point.c(), average = Eigen::VectorXd::Zero(c.size()), c_bar;
  for (int k = 0; k < options.m_steps; ++k) {
    const auto batch = draw(all, options.batch, rng);
    const TransitionSums::Sum mean =
        sums.run(point.arm(), batch, paths, noise, TransitionSums::Wants::kGradient, jobs);
    point.pull_back(mean.pi, mean.theta, c_bar);
    c_bar += ridge.cwiseProduct(c - coordinates.start());
    c_bar.tail(of_body).setZero();
    // steps shorten towards the end: the quieter the model, the steeper its density
    const double rate = step.slower * options.rate * (1 - 0.9 * k / options.m_steps);
    adam.step(c_bar, rate, coordinates.rate(), coordinates.box(), c);
    point.move_to(c);
    if (2 * k >= options.m_steps) average += c;
  }
  point.move_to(average / (options.m_steps - options.m_steps / 2));
}

/// Levenberg-Marquardt on one random batch, with a weak pull to where each step starts.
void maximise_by_normal_equations(TransitionSums& sums, const std::vector<Transition>& all,
                                  std::span<const Paths> paths, const LatentNoise& noise,
                                  const EmOptions& options, Rng& rng, int jobs, ArmPoint& point) {
  using enum TransitionSums::Wants;
  const auto batch = draw(all, kBatchesOfNormalEquations * options.batch, rng);
  const auto count = static_cast<double>(all.size()) / options.paths;
  ArmPoint trial = point;
  const auto linearise = [&](const Eigen::VectorXd& c, double) {
    trial.move_to(c);
    TransitionSums::Sum here =
        sums.run(trial.arm(), batch, paths, noise, kNormalEquations, jobs, trial.jacobian());
    return optimise::Quadratic{here.loss, std::move(here.Jw), std::move(here.JJ)};
  };
  const auto loss = [&](const Eigen::VectorXd& c) {
    trial.move_to(c);
    return sums.run(trial.arm(), batch, paths, noise, kLoss, jobs).loss;
  };
  optimise::LeastSquaresOptions steps;
  steps.damping.ridge = 1 / count;  // one nat per unit of a coordinate over all data
  steps.iterations = kNormalEquationSteps;
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  point.move_to(
      damped_least_squares(linearise, loss, point.coordinates().box(), {point.c(), unknown}, steps)
          .c);
}

}  // namespace

TransitionSums::TransitionSums(const Arm& arm, std::span<const signals::Recording> recordings,
                               const EmOptions& options)
    : packs_(std::max(1, options.batch / (kLanes * kPacksPerTask))) {
  for (int p = 0; p < packs_; ++p)
    losses_.emplace_back(arm, recordings, options.step, options.rigid_body_speed);
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

void maximise_transitions(TransitionSums& sums, const std::vector<Transition>& all,
                          std::span<const Paths> paths, const LatentNoise& noise,
                          const EmOptions& options, const AdamStep& step, optimise::Adam& adam,
                          Rng& rng, int jobs, ArmPoint& point) {
  if (options.m_steps == 0) return;
  if (point.c().size() <= kMostForNormalEquations)
    maximise_by_normal_equations(sums, all, paths, noise, options, rng, jobs, point);
  else
    maximise_by_adam(sums, all, paths, noise, options, step, adam, rng, jobs, point);
}

}  // namespace fricid::estimate
