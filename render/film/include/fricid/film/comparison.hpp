// The film of a run: the true arm, and the models under the same torques.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fricid/film/chart.hpp"
#include "fricid/film/run_film.hpp"
#include "fricid/film/viewpoint.hpp"

namespace fricid::film {

inline constexpr int kFilmWidth = 1280, kFilmHeight = 720, kFilmRate = 30;

/// Frames of the film's motion, kFilmRate per second.
int frames_of(const RunFilm& film);

/// Draws single frames of the film, in any order. Top: the true arm with those of the models, as
/// translucent ghosts and enlarged at the flange, or each in a picture of its own. Bottom: friction
/// torque of one joint against time, distance of the tips from the truth, and friction torque
/// against velocity. Keeps references to `film` and `painter`.
class Comparison {
 public:
  /// @param painter  for pictures of kFilmWidth x kFilmHeight
  /// @throws UserError when render.joint of the scene is no joint of the robot
  Comparison(const RunFilm& film, const scene::Problem& problem, ArmPainter& painter);

  /// @param index  0 to frames_of(film) - 1
  Image frame(int index);
  /// Scene, friction and models beside the arm.
  Image opening_card();
  /// Errors of all models by horizon.
  Image closing_card();

  /// The arms alone, at a row of the film.
  Image still(int row);

 private:
  std::vector<PaintedArm> arms(int row) const;
  void draw_ghosts(Canvas& canvas, int row);
  void draw_side_by_side(Canvas& canvas, int row);
  /// The flange enlarged, seen in the same direction.
  View close_view(int row) const;
  void draw_scale(Canvas& canvas, const Box& zoomed) const;
  void draw_strips(Canvas& canvas, int row) const;
  void draw_header(Canvas& canvas, int row) const;
  void draw_legend(Canvas& canvas, int row) const;
  std::vector<Trail> trails(int row) const;
  double error_mm(std::size_t model, int row) const;

  const RunFilm& film_;
  ArmPainter& painter_;
  bool side_by_side_;
  FilmPaths paths_;
  View view_;
  View portrait_;  ///< of the opening card
  double zoom_;    ///< half height of the enlarged picture [m]
  int joint_;
  std::vector<std::vector<double>> errors_mm_;  ///< [model, then the oracle][row]
  std::pair<double, double> torque_range_, speed_range_, error_range_;
};

}  // namespace fricid::film
