// Logs of one training set that no one arm explains.
#pragma once

#include <span>
#include <vector>

#include "fricid/estimate/fault.hpp"
#include "fricid/signals/recording.hpp"
#include "rigid_body/joint_rows.hpp"

namespace fricid::estimate {

/// Two logs whose bodies differ, as by a load, or else whose friction does, as on another day,
/// where fits with bodies or friction of each log's own leave a joint twelve times less variance.
/// Short logs are not judged.
/// @param all  of the recordings
std::vector<Fault> find_contradicting_logs(const StackedByJoint& all,
                                           std::span<const signals::Recording> recordings);

}  // namespace fricid::estimate
