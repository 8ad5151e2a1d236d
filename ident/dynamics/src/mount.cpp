#include "fricid/dynamics/mount.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace fricid::dynamics {

std::string mount_in_words(const Eigen::Vector3d& gravity) {
  const Eigen::Vector3d up = -gravity.normalized();
  const double roll = std::atan2(up[1], up[2]), pitch = -std::asin(std::clamp(up[0], -1.0, 1.0));
  return fmt::format("mount = \"rpy\", mount_rpy = [{:.3f}, {:.3f}, 0]", roll, pitch);
}

}  // namespace fricid::dynamics
