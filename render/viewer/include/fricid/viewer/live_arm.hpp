#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "fricid/scene/problem.hpp"
#include "fricid/sim/plant.hpp"

namespace fricid::viewer {

/// A torque applied to one joint by the user; a controller holds the others. The motor of the
/// pushed joint compensates gravity and adds
///
///     tau = torque + amplitude sin(2 pi frequency t).
struct Push {
  int joint = 0;
  double torque = 0;        ///< [N m]
  double amplitude = 0;     ///< [N m]
  double frequency_hz = 1;  ///< [Hz]
};

/// One sample of a live arm.
struct Moment {
  double t;                              ///< [s]
  std::vector<double> q, v, tau, tau_f;  ///< (n)
  std::vector<double> z;                 ///< (state_size) of the friction
};

/// The true arm, simulated in real time. Parameters of its friction may change at any time; state
/// and time are kept.
class LiveArm {
 public:
  /// @param friction  the injected friction: the scene's, or that of an identified model
  /// Keeps references to `arm` and `problem`.
  LiveArm(const sim::MujocoArm& arm, const scene::Problem& problem, friction::Friction friction);

  /// Restarts at rest in the middle of the scene's position box with relaxed friction, t = 0; swing
  /// or push are kept.
  void reset();
  /// Simulates the samples that fit into `seconds`, at most `kMostPerCall`; the remainder is
  /// carried over.
  void advance(double seconds);
  /// One sample.
  void step();

  Push push;  ///< active while the arm does not swing

  /// Whether the controller moves all joints in a slow wave about the middle of the position box,
  ///
  ///     q_j = middle_j + amplitude_j sin(2 pi f t - lag j),
  ///
  /// of at most 0.3 of the box and of the velocity limits. It fades in and out over a second; a
  /// displaced joint returns smoothly.
  bool swings = false;

  double time() const { return t_; }
  const sim::State& state() const { return state_; }
  const friction::Friction& friction() const { return friction_; }
  /// Clamped to the bounds of the law table.
  void set_parameter(int index, double value);
  /// The last `kHistory` seconds, oldest first.
  const std::deque<Moment>& history() const { return history_; }

  static constexpr double kHistory = 20;       ///< [s]
  static constexpr double kMostPerCall = 0.1;  ///< [s]

 private:
  const sim::MujocoArm& arm_;
  const scene::Problem& problem_;
  friction::Friction friction_;
  double dt_;
  int steps_;
  std::unique_ptr<sim::Plant> plant_;
  std::vector<double> middle_, amplitude_;  // [rad or m]
  std::vector<double> away_;                // offset of a held joint from its reference [rad or m]
  sim::State state_;
  double t_ = 0, owed_ = 0;
  double swing_share_ = 0;  // amplitude of the swing, 0 to 1
  std::deque<Moment> history_;
};

}  // namespace fricid::viewer
