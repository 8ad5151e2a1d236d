// Repeating motions: they show the noise of a recording without knowing the truth.
#pragma once

#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::evaluate {

/// Repeatability of a recording with period P: the standard deviation of one period, which is the
/// root mean square of x(t + P) - x(t) over sqrt 2. No function of the motion can predict the
/// torque with an error below tau_sd.
struct Repeats {
  double period_s = 0;               ///< P [s]; 0: the motion does not repeat
  std::vector<double> q_sd, tau_sd;  ///< (n) [rad], [N m]; empty without a period

  template <class Archive>
  void visit(Archive& archive) {
    archive("period_s", period_s, number("s", 0, 300, "0: the motion does not repeat"));
    archive("q_sd", q_sd, not_negative("rad", "per joint, standard deviation of one passage"));
    archive("tau_sd", tau_sd, not_negative("N m", "per joint, standard deviation of one passage"));
  }
};

/// Of a motion that repeats (`signals::period_of`) at most half the recording and 300 s later, and
/// all of it: the mean over moving joints of mean (q(t + P) - q(t))^2 / (2 var q) is below 1e-3.
Repeats find_repeats(const data::Dataset& dataset);

/// The measured torque (T, n) that belongs to the same motion one period later, or before where the
/// recording ends. @pre the recording is at least two periods long
RowMatrix other_passage(ConstRowMatrix tau, int period);

}  // namespace fricid::evaluate
