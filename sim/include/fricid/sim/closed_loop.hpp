// The true arm under its controller along a path, with a model's friction fed forward.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/data/loop_file.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/fourier.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/sim/options.hpp"

namespace fricid::sim {

/// Friction to feed forward.
struct FeedForward {
  friction::Friction friction;
  Eigen::VectorXd constant;  ///< (n) torque that the model holds beside it [N m]
  double gain = 1;
  Drive drive = Drive::kReference;
};

/// A force on a link from the samples `begin` to `end` of the signals.
struct Push {
  int begin = 0, end = 0;
  int joint = 0;          ///< that moves the link
  Eigen::Vector3d force;  ///< at the link's centre of mass, in the world [N]
};

/// One closed loop: a periodic path from its start for some periods, then rest at its end.
struct LoopTask {
  Fourier path;
  ControllerOptions controller;
  int periods = 1;
  std::optional<FeedForward> forward = {};
  double rest_s = 0;
  std::vector<Push> pushes = {};  ///< one after the other
  int number = 0;                 ///< of the streams of its sensors' noise
};

/// A random path within the limits of [excitation] that no recording of the scene follows.
/// @param number  of the path
/// @param size    scales its motion about the centre, in (0, 1]
/// @throws UserError when no motion keeps the limits
Fourier random_path(const scene::Problem& problem, const MujocoArm& arm, int number, double size);

/// Pushes of one force in random directions on links of the outer half of the arm, one in each of
/// `count` equal parts of the samples from `begin` to `end`, away from its borders.
std::vector<Push> random_pushes(const scene::Problem& problem, int number, int count, int begin,
                                int end, double force_N, double push_s);

/// Simulates a closed loop. Every sample the controller sees the encoders of [sensors] and the
/// difference of their last two readings as velocity; the motor torque
///
///     tau = clamp(controller(reference, q, v) + gain (tau_f(model) + constant))
///
/// is held over the sample. The friction model is driven by the reference in the middle of the
/// sample that comes, or by the measured motion up to now, and sees the torque of the sample
/// before as its load; its state is never corrected. One period or 2 s of the path before the
/// start are not recorded. The signals end early when a joint is off by more than 1 rad.
data::LoopSignals simulate_loop(const scene::Problem& problem, const MujocoArm& arm,
                                const LoopTask& task);

/// What the robot logs of a loop: encoder readings and motor torque, as `measure`.
data::Dataset log_of(const data::LoopSignals& loop, const scene::Problem& problem, int number);

}  // namespace fricid::sim
