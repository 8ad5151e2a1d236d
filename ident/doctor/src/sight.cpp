#include "sight.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "fricid/system/transmission.hpp"

namespace fricid::doctor {
namespace {

constexpr double kBeforeReversal = 0.056;  // [s]

// Rows at which joint j slides steadily: friction has settled since the last reversal, and the next
// is far. Friction climbs over a travel, which would look like a delay.
std::vector<int> settled_rows(const data::Dataset& d, const Motion& motion, int j) {
  constexpr double kSettled = 0.05;  // [rad or m] of travel
  const int T = d.length(), half = motion.half;
  const int reach = half + 3 * static_cast<int>(std::lround(kSmoothing / d.dt()));
  const int margin = static_cast<int>(std::lround(kBeforeReversal / d.dt()));
  // travel since the last reversal and samples since it and to the next, from displacements over a
  // window
  std::vector<double> travel(static_cast<std::size_t>(T), 0.0);
  std::vector<int> ahead(static_cast<std::size_t>(T), 0), since = ahead;
  const auto direction = [&](int k) {
    const double step = d.q(k + half, j) - d.q(k - half, j);
    return step > 0 ? 1 : step < 0 ? -1 : 0;
  };
  double origin = d.q(0, j);
  for (int k = half + 1; k + half < T; ++k) {
    const bool turns = direction(k) != direction(k - 1) || direction(k) == 0;
    if (turns) origin = d.q(k, j);
    since[static_cast<std::size_t>(k)] = turns ? 0 : since[static_cast<std::size_t>(k - 1)] + 1;
    travel[static_cast<std::size_t>(k)] = std::abs(d.q(k, j) - origin);
  }
  for (int k = T - half - 2; k > half; --k)
    ahead[static_cast<std::size_t>(k)] =
        direction(k) == direction(k + 1) ? ahead[static_cast<std::size_t>(k + 1)] + 1 : 0;
  std::vector<int> rows;
  for (int i = 0; i < motion.length(); ++i) {
    const auto k = static_cast<std::size_t>(motion.samples[static_cast<std::size_t>(i)]);
    if (travel[k] > kSettled && since[k] > reach && ahead[k] > reach + margin) rows.push_back(i);
  }
  return rows;
}

}  // namespace

Eigen::RowVectorXd motors_on(const dynamics::RobotModel* robot, int n, int j) {
  return robot ? Eigen::RowVectorXd(robot->motors_of_joints().col(j).transpose())
               : Eigen::RowVectorXd::Unit(n, j);
}

Sight see(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion) {
  Sight sight{motion.q, motion.v, motion.a, data::RowMatrix(motion.length(), d.n()), {}};
  const data::Dataset motors = robot ? Transmission(*robot).to_motors(d) : d;
  for (int j = 0; j < d.n(); ++j) {
    sight.tau.col(j) = motion.torque(j, 0);
    std::vector<int> rows = settled_rows(motors, motion, j);
    const Eigen::RowVectorXd acting = motors_on(robot, d.n(), j);
    for (int k = 0; k < d.n(); ++k) {
      if (k == j || acting[k] == 0) continue;
      const std::vector<int> also = settled_rows(motors, motion, k), before = std::move(rows);
      rows.clear();
      std::ranges::set_intersection(before, also, std::back_inserter(rows));
    }
    sight.rows.push_back(std::move(rows));
  }
  return sight;
}

}  // namespace fricid::doctor
