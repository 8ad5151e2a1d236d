#pragma once

#include <Eigen/Core>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/dynamics/workspace.hpp"

namespace fricid::dynamics::detail {

/// The geometry of a model in internal frames (see Link); a joint's parent is a lower index or -1.
/// The turn of a joint on the base is general and acts on gravity alone.
std::vector<Link<double>> make_links(const RobotModel& model);

}  // namespace fricid::dynamics::detail
