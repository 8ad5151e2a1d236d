// Held-out recordings that do not belong to the arm as it was trained.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/torque_prediction.hpp"
#include "fricid/evaluate/trajectory.hpp"

namespace fricid::evaluate {

/// A held-out recording that is not of the arm as it was trained. Either a regression of it and the
/// training data says in what they differ (`difference`; no values), or no trusted model explains
/// the torque of a joint as it explains the training data: another load, a stop or a collision,
/// closed brakes. Values of the model that comes nearest.
struct Unexplained {
  std::string recording;
  std::string joint;              ///< empty: the whole robot
  std::string difference;         ///< "the load on link_6 changes, as between ..."; empty: values
  bool throughout = false;        ///< else from `begin_s` to `end_s`, or at times in between
  double begin_s = 0, end_s = 0;  ///< of the recording's time
  double r2 = 0;                  ///< over the whole recording
  double residual = 0;            ///< RMS [N m] over the windows in question, or all
  double training_residual = 0;   ///< RMS [N m] over the training data

  /// The difference, or "from 9.5 to 12 s 310 N m are unexplained, 40 times the residual of the
  /// training data".
  std::string in_words() const;

  template <class Archive>
  void visit(Archive& archive) {
    archive("recording", recording, text("name of the held-out recording"));
    archive("joint", joint, text("name of the joint; empty: the whole robot"));
    archive("difference", difference,
            text("in what it differs from the training data, by a regression of both; empty: no "
                 "model explains its torque, and the values say where"));
    archive("throughout", throughout, flag("all of the recording; else a part of it"));
    archive("begin_s", begin_s, any_number("s", "where the part begins"));
    archive("end_s", end_s, any_number("s", "where it ends"));
    archive("r2", r2, any_number("1", "share of the variance explained, whole recording"));
    archive("residual", residual, not_negative("N m", "RMS of measured - predicted there"));
    archive("training_residual", training_residual,
            not_negative("N m", "RMS on the training data"));
  }
};

/// What a model predicts of held-out and of training recordings, one prediction each.
struct Judge {
  std::span<const TorquePrediction> held_out, training;
};

/// Windows of half a second that every judge leaves unexplained by more than 4.5 times its worst
/// window of the training data, and by more than half the deviation of the training torque; those
/// that the judge with the best R2 leaves by so many times its worst window and two fifths of the
/// deviation, as of a push; and recordings with R2 below one half whose residual is four times that
/// of the training data, for every judge.
/// @return sorted by recording and joint; nothing without judges or training data
std::vector<Unexplained> find_unexplained(std::span<const Trajectory> held_out,
                                          std::span<const Trajectory> training,
                                          std::span<const Judge> judges);

}  // namespace fricid::evaluate
