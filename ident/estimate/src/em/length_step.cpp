#include "em/length_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fricid::estimate {
namespace {

constexpr double kLeastStep = 0.05;

/// Joint of each coordinate: the laws of the whole robot number theirs by joint.
std::vector<int> joints_of(const ArmPoint& point, const std::vector<Eigen::Index>& coordinates) {
  std::vector<int> joints;
  for (const Eigen::Index c : coordinates) {
    const friction::ParameterRef& p =
        point.arm()
            .friction.model
            .parameters()[point.coordinates().friction()[static_cast<std::size_t>(c)]];
    joints.push_back(p.joint == friction::kWholeRobot ? p.info.element - 1 : p.joint);
  }
  return joints;
}

/// Vertex of the parabola through (-d, down), (0, here), (d, up), at most 2 d away; where it opens
/// upwards or a value is infinite, the best of the three.
double way_up(double d, double down, double here, double up) {
  const double curvature = 2 * here - down - up;
  if (curvature > 0 && std::isfinite(curvature))
    return std::clamp(d * (up - down) / (2 * curvature), -2 * d, 2 * d);
  if (here >= std::max(down, up)) return 0;
  return up > down ? d : -d;
}

}  // namespace

std::vector<Eigen::Index> length_coordinates(const ArmPoint& point) {
  std::vector<Eigen::Index> lengths;
  const std::vector<std::size_t>& friction = point.coordinates().friction();
  for (std::size_t k = 0; k < friction.size(); ++k)
    if (point.arm().friction.model.parameters()[friction[k]].info.role == friction::Role::kLength)
      lengths.push_back(static_cast<Eigen::Index>(k));
  return lengths;
}

void climb_by_lengths(const Likelihood& likelihood, Eigen::VectorXd& d, ArmPoint& point) {
  const std::vector<Eigen::Index> lengths = length_coordinates(point);
  const std::vector<int> joints = joints_of(point, lengths);
  const optimise::Box& box = point.coordinates().box();
  std::vector<bool> done(lengths.size());
  while (true) {
    // the next length of every joint
    std::vector<std::size_t> some;
    for (std::size_t i = 0; i < lengths.size(); ++i)
      if (!done[i] &&
          std::ranges::none_of(some, [&](std::size_t other) { return joints[other] == joints[i]; }))
        some.push_back(i);
    if (some.empty()) return;

    const Eigen::VectorXd begin = point.c();
    const auto moved = [&](const auto& way_of) {
      Eigen::VectorXd c = begin;
      for (const std::size_t i : some) {
        const Eigen::Index k = lengths[i];
        c[k] = std::clamp(c[k] + way_of(i), box.lower[k], box.upper[k]);
      }
      ArmPoint trial = point;
      trial.move_to(c);
      return trial;
    };
    const auto step = [&](std::size_t i) { return d[static_cast<Eigen::Index>(i)]; };
    std::vector<ArmPoint> tried{moved([&](std::size_t i) { return -step(i); }), point, moved(step)};
    const std::vector<Arm> arms{tried[0].arm(), tried[1].arm(), tried[2].arm()};
    std::vector<Eigen::VectorXd> values = likelihood.by_joint(arms);
    tried.push_back(moved([&](std::size_t i) {
      const Eigen::Index j = joints[i];
      return way_up(step(i), values[0][j], values[1][j], values[2][j]);
    }));
    values.push_back(likelihood.by_joint({&tried[3].arm(), 1})[0]);
    std::size_t best = 1;
    for (std::size_t k = 0; k < tried.size(); ++k)
      if (values[k].sum() > values[best].sum()) best = k;
    point = tried[best];
    for (const std::size_t i : some) {
      done[i] = true;
      double& of_next = d[static_cast<Eigen::Index>(i)];
      const double way = std::abs(point.c()[lengths[i]] - begin[lengths[i]]);
      of_next = std::clamp(way > 0 ? way : of_next / 2, kLeastStep, kMostLengthStep);
    }
  }
}

}  // namespace fricid::estimate
