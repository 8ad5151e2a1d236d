// What makes a fit not to be trusted.
#pragma once

#include <string>

namespace fricid::estimate {

/// Something that a fit to be trusted does not have.
struct Fault {
  std::string joint;   ///< empty: the whole robot
  std::string found;   ///< "R2 -249 on its own training torque"
  std::string remedy;  ///< what the user can do
  /// Not of a model whose friction depends on the temperature.
  bool without_temperature = false;
};

/// "joint_a2: R2 -249 on its own training torque; record more ...".
std::string in_words(const Fault& fault);

}  // namespace fricid::estimate
