#pragma once

#include <limits>

namespace fricid {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace fricid
