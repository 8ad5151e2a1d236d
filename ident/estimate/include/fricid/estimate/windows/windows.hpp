// Open-loop windows of recordings, many at once, and the gradient of their error.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/estimate/options/multi_step.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// A window: `steps` samples of a recording from sample `begin` on.
struct Window {
  int recording = 0;
  int begin = 0;
};

/// Rolls an arm out over windows, one per lane of S, and differentiates the error:
///
///     loss = mean over windows, steps, joints of  rho((q - q_m)/s_q) + rho((v - v_m)/s_v),
///     rho(x) = sqrt(1 + x^2) - 1,
///
/// from the recorded position and velocity and a given friction state. Missing positions do not
/// count. Memory O(steps). Owns its workspace: make one per thread. Instantiated for PackD, PackF.
template <class S>
class WindowRollout {
 public:
  WindowRollout(const Arm& arm, std::span<const signals::Recording> recordings, StepOptions step,
                int steps, ErrorScales scales = {});

  static constexpr int lanes() { return kLaneCount<S>; }

  /// Parameters to roll out with, the same in every lane.
  void set_parameters(std::span<const double> pi, std::span<const double> theta);

  /// @param windows  at most `lanes()`
  /// @param z        friction state along each recording (T, state_size), see wash_out
  /// @return sum of the loss over the windows; lanes that are not finite add `kFallen` instead
  double loss(std::span<const Window> windows, std::span<const RowMatrix> z);

  /// After `loss` on the same windows: adds its gradient to pi_bar and theta_bar.
  void add_gradient(std::span<double> pi_bar, std::span<double> theta_bar);

  /// After `loss` on the same windows: a sample of each window's curvature. With J the Jacobian of
  /// the window's errors x, W = rho'(x)/x their weights in the loss and e random signs, column k
  /// becomes J' W^1/2 e of window k, so that E[s s'] is the Gauss-Newton matrix of its loss; zero
  /// for a lane that is not finite.
  /// @param pi_bar, theta_bar  one column per window, one row per parameter
  void curvature_samples(Rng& rng, Eigen::Ref<Eigen::MatrixXd> pi_bar,
                         Eigen::Ref<Eigen::MatrixXd> theta_bar);

  /// Mean square of q - q_m over joints and steps of lane k of the last `loss` [rad^2]; infinite
  /// when not finite.
  double mean_square(int k) const;

  static constexpr double kFallen = 100;

 private:
  struct Frame {  // state at one leap
    std::span<S> q, v, z;
  };
  Frame frame(int leap);
  void sweep(const std::vector<S>& slope);
  using Signal = const RowMatrix& (*)(const signals::Recording&);
  void gather(Signal signal, int step, std::vector<S>& out) const;

  const Arm& arm_;
  std::span<const signals::Recording> recordings_;
  ArmStepper<S> stepper_;
  int steps_, n_, nz_;
  ErrorScales scales_;
  std::vector<Window> windows_;
  std::vector<S> history_;  // states at every leap, the last included
  std::vector<S> slope_;    // d loss / d (q, v) at every sample 1 .. steps
  std::vector<S> root_;     // square roots of their weights, of either sign
  std::vector<S> tau_, temperature_, target_, pi_, theta_;
  std::vector<S> q_bar_, v_bar_, z_bar_, pi_bar_, theta_bar_;
  std::vector<double> square_;  // per lane
  std::vector<char> fallen_;    // per lane
};

extern template class WindowRollout<PackD>;
extern template class WindowRollout<PackF>;

}  // namespace fricid::estimate
