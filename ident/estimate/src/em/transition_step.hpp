// M-step on the transition density of smoothed paths.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/em/em.hpp"
#include "fricid/estimate/em/transitions.hpp"
#include "fricid/optimise/adam.hpp"

namespace fricid::estimate {

/// Every step of every path.
std::vector<Transition> all_transitions(std::span<const Paths> paths);

/// Sums over transitions, packs of them in parallel.
class TransitionSums {
 public:
  TransitionSums(const Arm& arm, std::span<const signals::Recording> recordings,
                 const EmOptions& options);

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
          const Eigen::MatrixXd& parameters_of = {});

 private:
  int packs_;
  std::vector<TransitionLoss> losses_;
  std::vector<Sum> parts_;
};

/// Coordinates up to which matrices of that size are made; networks have thousands.
inline constexpr int kMostForNormalEquations = 400;

/// One M-step by Adam.
struct AdamStep {
  double slower = 1;       ///< factor on its steps
  bool rigid_body = true;  ///< whether the rigid body moves
};

/// Moves the point to greater density: by Levenberg-Marquardt on one random batch, or by Adam on
/// many where there are thousands of parameters.
/// @param adam  of the size of c; keeps its moments
void maximise_transitions(TransitionSums& sums, const std::vector<Transition>& all,
                          std::span<const Paths> paths, const LatentNoise& noise,
                          const EmOptions& options, const AdamStep& step, optimise::Adam& adam,
                          Rng& rng, int jobs, ArmPoint& point);

}  // namespace fricid::estimate
