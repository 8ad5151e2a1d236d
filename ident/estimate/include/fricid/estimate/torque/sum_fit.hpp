// The model lvm: which parts of the sum are on.
#pragma once

#include <vector>

#include "fricid/estimate/torque/joint_fit.hpp"

namespace fricid::estimate {

/// The sum whose parts the held-out torque wants: with a bank on the training rows; a bristle in
/// its place, a gap before it, further ripples, each joint by joint where it lowers the held-out
/// error; without the other parts that say nothing; on all rows.
Candidate fit_sum(const JointFits& fits, std::vector<friction::LvmParts>& parts,
                  std::vector<PartEvidence>& evidence);

}  // namespace fricid::estimate
