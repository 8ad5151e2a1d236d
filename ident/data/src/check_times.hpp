#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

namespace fricid::data {

/// Rules of sample times [s]: finite, rising, and each period within 1 % of 1 / rate_hz.
/// @param place  "where" of sample k in a message
/// @throws UserError at the first sample that breaks one
void check_times(const Eigen::VectorXd& t, double rate_hz,
                 const std::function<std::string(int)>& place);

}  // namespace fricid::data
