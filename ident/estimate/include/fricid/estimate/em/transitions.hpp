// The transition density of smoothed paths, the objective of the M-step, and its gradient.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/estimate/em/latent_friction_model.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/smc/model.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// Smoothed paths x_0 .. x_{T-1} of one recording, (T, 2 n + n_z) each.
using Paths = std::vector<smc::RowMatrix>;

/// Step t -> t + 1 of one path of one recording.
struct Transition {
  int recording = 0;
  int path = 0;
  int t = 0;
};

/// Sums over transitions, one per lane of PackD:
///
///     loss = 1/2 sum e' Q^-1 e,   e = x_{t+1} - f(x_t),
///
/// f and Q as in LatentFrictionModel: Q^-1 is diagonal in r = (e_q - c e_v, e_v, e_z), c as in
/// `position_per_velocity`. Owns its
/// workspace: make one per thread.
class TransitionLoss {
 public:
  /// @param rigid_body_speed  (n) transitions with a joint slower than this have no gradient with
  ///                          respect to pi [rad/s]; empty: all have
  TransitionLoss(const Arm& arm, std::span<const signals::Recording> recordings, StepOptions step,
                 std::span<const double> rigid_body_speed = {});

  static constexpr int lanes() { return PackD::kLanes; }

  void set_parameters(std::span<const double> pi, std::span<const double> theta);

  /// Sum over at most lanes() transitions; adds the squares of r to `squares` (2 n + n_z)
  /// unless it is empty.
  double loss(std::span<const Transition> transitions, std::span<const Paths> paths,
              const LatentNoise& noise, std::span<double> squares = {});

  /// After `loss` on the same transitions: adds J'J and J'w of the whitened residuals w = L^-1 e,
  /// Q = L L', whose squares make the loss; J = dw/dc by one reverse sweep per state.
  /// @param parameters_of  d(pi, theta)/dc, see ArmCoordinates::jacobian
  void add_normal_equations(const Eigen::MatrixXd& parameters_of, const LatentNoise& noise,
                            Eigen::MatrixXd& JJ, Eigen::VectorXd& Jw);

  /// After `loss` on the same transitions: adds its gradient to pi_bar and theta_bar.
  void add_gradient(std::span<double> pi_bar, std::span<double> theta_bar);

 private:
  std::span<const signals::Recording> recordings_;
  ArmStepper<PackD> stepper_;
  void pull(std::span<PackD> bar);

  int n_, nz_;
  int count_ = 0;
  double dt_, coupling_;
  Eigen::RowVectorXd rigid_body_speed_;
  std::vector<bool> slow_;  // lanes with a joint slower than that
  std::vector<PackD> history_, residual_, bar_, tau_, temperature_, pi_, theta_, pi_bar_,
      theta_bar_;
  std::vector<PackD> whitened_;
};

}  // namespace fricid::estimate
