#include "fricid/scene/robot.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include <Eigen/Geometry>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/error.hpp"

namespace fricid::scene {
namespace {

/// Three numbers between commas.
std::optional<std::array<double, 3>> angles_of(std::string_view words) {
  std::array<double, 3> angles{};
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const std::string_view word = words.substr(0, words.find(','));
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), angles[i]);
    const bool last = i + 1 == angles.size();
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(angles[i]) ||
        last != (word.size() == words.size()))
      return std::nullopt;
    if (!last) words.remove_prefix(word.size() + 1);
  }
  return angles;
}

}  // namespace

Eigen::Matrix3d mount_rotation(const RobotSection& robot) {
  if (robot.mount == Mount::kCeiling) return Eigen::Vector3d(1, -1, -1).asDiagonal();
  if (robot.mount == Mount::kWall) return Eigen::Matrix3d{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}};
  if (robot.mount == Mount::kRpy) {
    using Eigen::AngleAxisd, Eigen::Vector3d;
    const auto& [roll, pitch, yaw] = robot.mount_rpy;
    return (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
            AngleAxisd(roll, Vector3d::UnitX()))
        .toRotationMatrix();
  }
  return Eigen::Matrix3d::Identity();
}

Eigen::Matrix3d mount_rotation(const std::string& words) {
  RobotSection robot;
  const auto named = value_named<Mount>(words);
  if (named && *named != Mount::kRpy) {
    robot.mount = *named;
  } else if (const auto angles = angles_of(words)) {
    robot.mount = Mount::kRpy;
    robot.mount_rpy = *angles;
  } else {
    throw UserError(
        "mount {}: allowed: floor, ceiling, wall, or roll, pitch and yaw in rad such as "
        "0.3,-0.45,0",
        words);
  }
  return mount_rotation(robot);
}

}  // namespace fricid::scene
