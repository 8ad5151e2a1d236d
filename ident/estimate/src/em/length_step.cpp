#include "em/length_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fricid::estimate {
namespace {

constexpr double kLeastStep = 0.05;

/// Vertex of the parabola through (-d, down), (0, here), (d, up), at most 2 d away; 0 where it
/// opens upwards or a value is infinite.
double vertex(double d, double down, double here, double up) {
  const double curvature = 2 * here - down - up;
  return curvature > 0 && std::isfinite(curvature)
             ? std::clamp(d * (up - down) / (2 * curvature), -2 * d, 2 * d)
             : 0;
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
  const optimise::Box& box = point.coordinates().box();
  double best = likelihood.value(point.arm());
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const Eigen::Index k = lengths[i];
    double& step = d[static_cast<Eigen::Index>(i)];
    const Eigen::VectorXd begin = point.c();
    const double here = best;
    const auto look = [&](double way) {
      Eigen::VectorXd c = begin;
      c[k] = std::clamp(c[k] + way, box.lower[k], box.upper[k]);
      ArmPoint trial = point;
      trial.move_to(c);
      const double value = likelihood.value(trial.arm());
      if (value > best) {
        best = value;
        point = std::move(trial);
      }
      return value;
    };
    const double down = look(-step), up = look(step);
    if (const double way = vertex(step, down, here, up); way != 0) look(way);
    const double moved = std::abs(point.c()[k] - begin[k]);
    step = std::clamp(moved > 0 ? moved : step / 2, kLeastStep, kMostLengthStep);
  }
}

}  // namespace fricid::estimate
