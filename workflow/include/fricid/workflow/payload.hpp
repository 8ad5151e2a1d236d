// What `fricid payload` looks at, and what it finds.
#pragma once

#include <string>
#include <vector>

#include "fricid/data/payload_file.hpp"
#include "fricid/workflow/check.hpp"

namespace fricid::workflow {

/// The load that the arm of `without` carries in the recordings `with`, and what `check` finds
/// wrong in either.
/// @param frame  that carries it; empty: flange or tool0, whichever the robot has
/// @throws UserError without a robot, for a frame that it has not or that does not move, for logs
/// of
///         other joints or with uneven times
data::PayloadFile find_payload(const Subject& without, const std::vector<data::Dataset>& with,
                               const std::string& frame);

/// As the keys of [robot] of a scene, with standard errors.
std::string to_text(const data::PayloadFile& payload);

}  // namespace fricid::workflow
