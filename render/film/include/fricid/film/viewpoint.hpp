#pragma once

#include <span>
#include <vector>

#include "fricid/film/arm_painter.hpp"
#include "fricid/film/run_film.hpp"

namespace fricid::film {

/// Paths in space of a film's arms.
struct FilmPaths {
  std::vector<Eigen::Vector3d> truth;                ///< tip per row
  std::vector<std::vector<Eigen::Vector3d>> models;  ///< [model][row]
  std::vector<Eigen::Vector3d> oracle;               ///< empty if there is no oracle
  std::vector<Eigen::Vector3d> outline;  ///< joints and tips of all, a few times a second
};

FilmPaths paths_of(const RunFilm& film, ArmPainter& painter);

/// A fixed view that holds all of `points`.
/// @param aspect  width over height of the picture
View view_of(std::span<const Eigen::Vector3d> points, double azimuth_deg, double elevation_deg,
             double field_of_view, double aspect);

/// The view of the whole motion from the azimuth (in steps of 15 degrees, slightly above) at which
/// the tips' errors appear largest and the surroundings hide least.
View telling_view(const FilmPaths& paths, const ArmPainter& painter, double aspect);

}  // namespace fricid::film
