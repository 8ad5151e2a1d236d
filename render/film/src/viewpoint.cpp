#include "fricid/film/viewpoint.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "film_style.hpp"

namespace fricid::film {
namespace {

constexpr double kOutlinePeriod = 0.2;  // [s]
constexpr double kRadians = std::numbers::pi / 180;

/// Axes of a camera in the world.
struct CameraAxes {
  Eigen::Vector3d forward, right, up;
  CameraAxes(double azimuth_deg, double elevation_deg) {
    const double a = azimuth_deg * kRadians, e = elevation_deg * kRadians;
    forward = {std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)};
    right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    up = right.cross(forward);
  }
};

}  // namespace

FilmPaths paths_of(const RunFilm& film, ArmPainter& painter) {
  FilmPaths paths;
  const Eigen::Index rows = film.t.size();
  const auto follow = [&](const RowMatrix& q, std::vector<Eigen::Vector3d>& tips) {
    double next = 0;
    for (Eigen::Index k = 0; k < rows; ++k) {
      if (film.t[k] < next) {
        tips.push_back(painter.tip(row_of(q, k)));
        continue;
      }
      next += kOutlinePeriod;
      const auto joints = painter.joints(row_of(q, k));
      paths.outline.insert(paths.outline.end(), joints.begin(), joints.end());
      tips.push_back(joints.back());
    }
  };
  follow(film.q, paths.truth);
  paths.models.resize(film.models.size());
  for (std::size_t m = 0; m < film.models.size(); ++m) follow(film.models[m].q, paths.models[m]);
  if (film.oracle.q.size() > 0)
    for (Eigen::Index k = 0; k < rows; ++k)
      paths.oracle.push_back(painter.tip(row_of(film.oracle.q, k)));
  return paths;
}

View view_of(std::span<const Eigen::Vector3d> points, double azimuth_deg, double elevation_deg,
             double field_of_view, double aspect) {
  const CameraAxes axes(azimuth_deg, elevation_deg);
  Eigen::Vector3d low = Eigen::Vector3d::Constant(HUGE_VAL), high = -low;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d seen(axes.right.dot(point), axes.up.dot(point), axes.forward.dot(point));
    low = low.cwiseMin(seen);
    high = high.cwiseMax(seen);
  }
  const Eigen::Vector3d middle = (low + high) / 2, half = (high - low) / 2;
  const double tangent = std::tan(field_of_view / 2);
  const double distance = std::max(half[1] / tangent, half[0] / (tangent * aspect)) + half[2];
  return {middle[0] * axes.right + middle[1] * axes.up + middle[2] * axes.forward, distance,
          azimuth_deg, elevation_deg};
}

View telling_view(const FilmPaths& paths, const ArmPainter& painter, double aspect) {
  View best;
  double largest = -1;
  for (int azimuth = 0; azimuth < 360; azimuth += 15) {
    const View view =
        view_of(paths.outline, azimuth, kFrontElevation, painter.field_of_view(), aspect);
    const CameraAxes axes(azimuth, kFrontElevation);
    double seen = 0;
    for (const auto& tips : paths.models)
      for (std::size_t k = 0; k < tips.size(); k += 10) {
        const Eigen::Vector3d error = tips[k] - paths.truth[k];
        seen += std::hypot(axes.right.dot(error), axes.up.dot(error));
      }
    const double shown = 1 - painter.hidden_share(view, paths.outline);
    const double score = seen / view.distance * shown * shown;
    if (score > largest) {
      largest = score;
      best = view;
    }
  }
  return best;
}

}  // namespace fricid::film
