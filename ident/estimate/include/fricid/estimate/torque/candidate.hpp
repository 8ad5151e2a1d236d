// One of several fits of which held-out data choose, and the evidence for each part of a sum.
#pragma once

#include <string>

#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// A fitted arm and its errors on the held-out part of the recordings.
struct Candidate {
  std::string name;  ///< "sum", "gms, windows"
  Arm arm;
  double held_out = 0;  ///< `held_out_error` [rad^2]
  double torque = 0;    ///< mean over joints of residual / torque variance, held-out rows [1]
  int parameters = 0;   ///< free ones of the friction
  double seconds = 0;
};

/// Evidence of the held-out torque for one part of the sum in one joint.
struct PartEvidence {
  std::string part;  ///< "load", "ripple"; "bristle": lugre in the place of the bank
  int joint = 0;
  double gain = 0;   ///< relative rise of the held-out mean square without the part [1]
  double error = 0;  ///< standard error of it, seconds counting as independent [1]
  bool on = false;
};

}  // namespace fricid::estimate
