// A link as a body.
#pragma once

#include <Eigen/Core>

#include "fricid/dynamics/physical_inertia.hpp"

namespace fricid::dynamics {

/// Mass [kg], centre of mass [m] and inertia about it [kg m^2], in the axes of the link.
struct Body {
  double m;
  Eigen::Vector3d c;
  Eigen::Matrix3d I;
};

/// The body of standard parameters (m, mc, I about the origin as in RobotModel). @pre m > 0
inline Body body_of(const Vector10& pi) {
  Body body{.m = pi[0], .c = pi.segment<3>(1) / pi[0], .I = {}};
  body.I << pi[4], pi[5], pi[7], pi[5], pi[6], pi[8], pi[7], pi[8], pi[9];
  body.I -=
      body.m * (body.c.squaredNorm() * Eigen::Matrix3d::Identity() - body.c * body.c.transpose());
  return body;
}

}  // namespace fricid::dynamics
