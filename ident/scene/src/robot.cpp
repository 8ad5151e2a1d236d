#include "fricid/scene/robot.hpp"

#include <Eigen/Geometry>

namespace fricid::scene {

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

}  // namespace fricid::scene
