#include "mount.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "explained.hpp"

namespace fricid::doctor {
namespace {

constexpr double kBeliefInSlope = 2 * kBelief;  // of any angles
constexpr double kLeastTilt = 0.06;             // [rad] of another mount
constexpr int kMostTilts = 6;                   // of one size

/// The axis of all joints in the base frame, where they turn about parallel ones: gravity along it
/// is in no torque, so that a tilt across it and a lighter arm are the same.
std::optional<Eigen::Vector3d> common_axis(const dynamics::RobotModel& robot) {
  constexpr double kParallel = 1e-3;  // sine of the angle between two
  std::vector<Eigen::Matrix3d> to_base;
  std::optional<Eigen::Vector3d> common;
  for (const dynamics::Joint& joint : robot.joints) {
    const Eigen::Matrix3d parent = joint.parent < 0
                                       ? Eigen::Matrix3d::Identity()
                                       : to_base[static_cast<std::size_t>(joint.parent)];
    to_base.emplace_back(parent * joint.R0);
    const Eigen::Vector3d axis = to_base.back() * joint.axis;
    if (slides(joint) || (common && common->cross(axis).norm() > kParallel)) return std::nullopt;
    if (!common) common = axis;
  }
  return common;
}

}  // namespace

std::vector<OtherMount> other_mounts(const dynamics::RobotModel& robot, const Sight& sight) {
  const Eigen::Vector3d g = robot.gravity;
  std::vector<Eigen::Vector3d> gravities{g, -g};
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d side = g.cross(Eigen::Vector3d::Unit(axis));
    if (side.norm() < 0.5 * g.norm()) continue;
    gravities.emplace_back(side.normalized() * g.norm());
    gravities.emplace_back(-gravities.back());
  }
  const auto unexplained = [&](const Eigen::Vector3d& gravity) {
    dynamics::RobotModel turned = robot;
    turned.gravity = gravity;
    return log_unexplained(Judge(&turned, robot.n()).explain(sight));
  };
  const Eigen::Vector3d upright = *std::ranges::min_element(gravities, {}, unexplained);
  Eigen::Vector3d best = upright;
  double least = unexplained(best);
  // on a slope: tilted further while that explains more
  const std::optional<Eigen::Vector3d> turned_about = common_axis(robot);
  for (const double tilt : {0.3, 0.1, 0.03}) {
    for (int moves = 0; moves < kMostTilts; ++moves) {
      const Eigen::Vector3d now = best, across = now.unitOrthogonal();
      std::vector<Eigen::Vector3d> axes{across, now.cross(across).normalized()};
      if (turned_about) axes = {*turned_about};
      for (const Eigen::Vector3d& axis : std::vector(axes)) axes.emplace_back(-axis);
      for (const Eigen::Vector3d& axis : axes) {
        const Eigen::Vector3d tilted = Eigen::AngleAxisd(tilt, axis) * now;
        if (const double left = unexplained(tilted); left < least) least = left, best = tilted;
      }
      if (best == now) break;
    }
  }
  std::vector<OtherMount> mounts;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  for (const auto& [gravity, belief] :
       {std::pair{best, kBeliefInSlope}, {upright, kBelief}, {none, kBelief}}) {
    if (gravity.dot(g) > std::cos(kLeastTilt) * g.squaredNorm()) continue;
    if (gravity == none && unexplained(none) >= least) continue;
    mounts.push_back({robot, belief});
    mounts.back().robot.gravity = gravity;
  }
  return mounts;
}

std::string zero_instead(const dynamics::RobotModel& robot, const Eigen::Vector3d& gravity) {
  const std::optional<Eigen::Vector3d> axis = common_axis(robot);
  if (!axis) return "";
  const double turned =
      std::atan2(axis->dot(robot.gravity.cross(gravity)),
                 robot.gravity.dot(gravity) - axis->dot(robot.gravity) * axis->dot(gravity));
  return fmt::format(", or where offset_rad of {} is {:.2f} more", robot.joints.front().name,
                     -turned);
}

}  // namespace fricid::doctor
