// What contract and import both know of columns and units.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fricid::data {

/// Headers of n joints: as given, or one pattern filled in, "q{}" -> q1 ... qn, "q_{0}" -> q_0 ...,
/// "position.{name}" -> position.shoulder ...
std::vector<std::string> expand_pattern(const std::vector<std::string>& columns,
                                        const std::vector<std::string>& joint_names);

/// Whether a unit, or a kind of torque, is one at the motor.
bool at_motor(std::string_view unit);
bool counts_at_motor(std::string_view kind);

}  // namespace fricid::data
