#include "fricid/estimate/online/log_start.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/system/initial_state.hpp"

namespace fricid::estimate {
namespace {

constexpr double kBegin = 0.1;  // [s] over which a log begins
constexpr double kSlid = 1e-3;  // [rad or m] in it, beyond which a joint moves

Eigen::RowVectorXd first_velocities(ConstRowMatrix q, double dt) {
  const Eigen::Index last = std::min(q.rows() - 1, std::lround(kBegin / dt));
  const Eigen::RowVectorXd moved = q.row(last) - q.row(0);
  return (moved.array().abs() > kSlid).select(moved / (static_cast<double>(last) * dt), 0.0);
}

}  // namespace

LogStart log_start(const Arm& arm, double dt, ConstRowMatrix q, ConstRowMatrix tau,
                   ConstRowMatrix temperature) {
  LogStart start{.q = q.row(0), .v = first_velocities(q, dt)};
  // as if at these velocities: differences of positions are no accelerations
  start.z = initial_friction_state(arm, dt, q, start.v.transpose().replicate(q.rows(), 1), tau,
                                   temperature);
  return start;
}

}  // namespace fricid::estimate
