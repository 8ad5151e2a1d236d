#pragma once

#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/excitation.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/sim/truth.hpp"

namespace fricid::sim {

/// Ground truth of a scene: data sets and truths go pairwise.
struct Simulation {
  std::vector<data::Dataset> train, validation;
  std::vector<Truth> train_truth, validation_truth;
  Excitation excitation;
};

/// The arm of a scene in MuJoCo, with mount and payload; made of the URDF where the scene names no
/// MJCF. @throws UserError as MujocoArm, and for a scene of logs without an MJCF
MujocoArm make_arm(const scene::Problem& problem);
/// The same with another physics step [s].
MujocoArm make_arm(const scene::Problem& problem, double step);

/// Designs the excitation and simulates every sequence, each on a plant of its own: `train` x
/// `repeats` training periods and `validation` held-out ones. The arm enters each period from the
/// end of the one before, so that a log starts with a settled friction state. Equal bytes for any
/// number of jobs.
/// @throws UserError on a scene without friction, or as above; std::runtime_error when the arm
/// diverges
Simulation simulate(const scene::Problem& problem, int jobs);

/// Open loop of the true arm for a data set (the oracle): from the true state at `start`, under the
/// measured, held torque.
/// @param length  samples; row 0 is the state at `start`
Trace oracle_rollout(const scene::Problem& problem, const MujocoArm& arm, const Truth& truth,
                     const data::Dataset& dataset, int start, int length);

}  // namespace fricid::sim
