// The mount of a robot by the direction of gravity in its base.
#pragma once

#include <string>

#include <Eigen/Core>

namespace fricid::dynamics {

/// The keys of [robot] in a scene under which gravity has this direction in the frame of the base:
/// mount = "rpy", mount_rpy = [roll, pitch, 0].
std::string mount_in_words(const Eigen::Vector3d& gravity);

}  // namespace fricid::dynamics
