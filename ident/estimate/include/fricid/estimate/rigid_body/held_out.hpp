// Held-out recordings of another arm than the training data: another load, day or zero.
#pragma once

#include <span>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/estimate/options/rigid_body.hpp"

namespace fricid::estimate {

/// What each held-out recording differs in from the training data, by the regressions that compare
/// training recordings with each other: zeros of joints, bodies, friction, torque constants.
/// @param training  what a fit takes of the training data, `data::training_part`
/// @return of each held-out recording; nothing where the training data need a prior or differ among
///         themselves
std::vector<std::vector<Fault>> find_differences_from_training(
    const dynamics::RobotModel& robot, std::span<const data::Dataset> training,
    std::span<const data::Dataset> held_out, const RigidBodyOptions& options, int jobs);

}  // namespace fricid::estimate
