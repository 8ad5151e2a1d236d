// The film of pushes: one motion, and what observers with two models' friction make of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fricid/film/arm_painter.hpp"
#include "fricid/film/canvas.hpp"
#include "fricid/film/run_film.hpp"

namespace fricid::film {

/// What one observer saw.
struct FilmObserver {
  std::string label, colour;
  RowMatrix tau_ext;                 ///< (T, n) [N m]
  std::vector<double> threshold_Nm;  ///< (n)

  /// Largest torque over its threshold of any joint; beyond 1 it is an alarm.
  double level(int row) const;
};

/// Content of the film, read from the run folder.
struct ContactFilm {
  std::string scene;
  std::vector<std::string> joint_names;
  double force_N = 0;
  Eigen::VectorXd t;                    ///< (T) [s]
  RowMatrix q, tau_ext;                 ///< (T, n) true [rad], [N m]
  std::vector<FilmObserver> observers;  ///< the first model of the run, and the most sensitive
  int joint = 0;                        ///< that the pushes load most

  bool pushed(int row) const;
  int row(double at) const;
};

/// Empty: the folder has no pushes. @throws UserError when a file is damaged
std::optional<ContactFilm> read_contact_film(const workflow::RunFolder& folder,
                                             const scene::Problem& problem);

/// Frames of the film.
int frames_of(const ContactFilm& film);

/// Draws them, in any order. Keeps references to both.
class ContactFrames {
 public:
  ContactFrames(const ContactFilm& film, ArmPainter& painter);

  Image frame(int index);

 private:
  void draw_arm(Canvas& canvas, const FilmObserver& observer, const Box& box, int row);
  void draw_strips(Canvas& canvas, int row) const;

  const ContactFilm& film_;
  ArmPainter& painter_;
  View view_;
  std::pair<double, double> range_;  ///< [N m] of the strip
};

}  // namespace fricid::film
