// Friction along measured motion against the torque it has to explain, and the gradient of what is
// left.
#pragma once

#include <span>
#include <vector>

#include "fricid/estimate/windows/windows.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Motion that drives the friction, and the friction torque that the rigid body leaves along it.
struct TorqueData {
  std::span<const signals::Recording> recordings;
  signals::Band band = signals::Band::kWide;  ///< of the motion
  std::vector<RowMatrix> target;  ///< per recording (T, n) [N m]; the rows of `use` count
};

/// Drives a friction along windows of recordings, one per lane of S ("teacher forcing": motion is
/// measured, only z is the model's), and differentiates the error of its torque:
///
///     f_k     = torque(theta; q_k, v_k, load_k, z_k)
///     z_{k+1} = step(theta; q_{k+1}, (q_{k+1} - q_k)/dt, load_k, z_k)     as drive_friction
///     loss    = mean over windows, samples, joints of  ((F[f] - target)/s)^2
///
/// F is the filter of the measured torque (its impulse response; {1}: none): friction drops within
/// milliseconds at a reversal, the measured torque only as fast as its filter. The window is driven
/// K samples before and after the `steps` samples that count. Memory O(steps). Owns its workspace:
/// make one per thread. Instantiated for PackD, PackF.
template <class S>
class TorqueWindows {
 public:
  /// @param scale     s (n) [N m]
  /// @param response  F as `signals::impulse_response` gives it
  TorqueWindows(const friction::RobotFriction& model, const TorqueData& data, int steps,
                std::vector<double> scale, std::vector<double> response);

  static constexpr int lanes() { return kLaneCount<S>; }

  /// Samples before and after a window that it needs.
  int margin() const { return static_cast<int>(response_.size()) - 1; }

  /// Parameters, the same in every lane.
  void set_parameters(std::span<const double> theta);

  /// @param windows  at most lanes(), each margin() or more from both ends of its recording
  /// @param z        friction state along each recording (T, state_size), see wash_out
  /// @return sum of the loss over the windows; those that are not finite count as kFallen
  double loss(std::span<const Window> windows, std::span<const RowMatrix> z);

  /// After `loss` on the same windows: adds its gradient to theta_bar.
  void add_gradient(std::span<double> theta_bar);

  static constexpr double kFallen = 100;

 private:
  using Number = decltype(lane(S(), 0));
  int row(int lane, int sample) const;
  const signals::Recording& recording_of(const Window& window) const {
    return data_.recordings[static_cast<std::size_t>(window.recording)];
  }
  S* state(int sample) { return z_.data() + static_cast<std::size_t>(sample * nz_); }
  void motion_at(int sample);
  void motion_over(int sample);

  const friction::RobotFriction& model_;
  const TorqueData& data_;
  int steps_, n_, nz_;
  std::vector<double> scale_, response_;
  std::vector<Window> windows_;
  std::vector<S> theta_, theta_bar_;
  std::vector<S> z_;            // states at every sample, the one after the last included
  std::vector<S> tau_, slope_;  // torque and d loss / d torque, (samples, n)
  std::vector<S> z_bar_, z_next_bar_;
  std::vector<friction::Input<S>> in_, in_bar_;
  std::vector<char> fallen_;  // per lane
};

extern template class TorqueWindows<PackD>;
extern template class TorqueWindows<PackF>;

}  // namespace fricid::estimate
