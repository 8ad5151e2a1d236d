#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fricid/sim/mujoco_arm.hpp"

namespace fricid::sim {

/// Smallest distance between the arm and itself, floor or ceiling, from MuJoCo's collision geoms.
/// Left out: pairs that cannot move against each other, neighbours along the chain, pairs excluded
/// in the MJCF, and pairs whose contact masks do not match. One per thread.
class Clearance {
 public:
  struct Pair {
    double distance;   ///< [m], negative when they overlap; `range` when nothing is nearer
    int geom1, geom2;  ///< -1 when nothing is nearer than `range`
  };

  /// @param range  distances above it are not resolved [m]
  Clearance(const MujocoArm& arm, double range);

  /// Closest pair at q (n).
  Pair closest(std::span<const double> q);
  /// "link_3 - ceiling": bodies of the pair, the geom's own name for the world's.
  std::string name(const Pair& pair) const;
  int pair_count() const { return static_cast<int>(pairs_.size()); }

 private:
  const MujocoArm& arm_;
  MjDataPtr data_;
  std::vector<std::pair<int, int>> pairs_;
  double range_;
};

}  // namespace fricid::sim
