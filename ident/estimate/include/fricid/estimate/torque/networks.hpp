// Networks for what the laws of the sum leave.
#pragma once

#include <optional>
#include <vector>

#include "fricid/estimate/torque/joint_fit.hpp"

namespace fricid::estimate {

/// What is fitted to the training rows alone, so that the held-out ones have the say: the friction
/// of `plain` again, and networks beside the sum. Where one at least halves what a joint leaves, in
/// all joints that are better with one: networks beside Stribeck friction and beside a bank,
/// without the other parts, since a part that is fitted to what no law describes takes values that
/// a network then has to undo; the better of the two with the other parts; and of each joint the
/// best of all these. Where networks better the rollouts by more than their standard error and
/// by half, the one that `choose` takes is fitted once more, to all rows.
/// @param plain     the arm to better
/// @param sum       where the fits start
/// @param parts     of the sum, per joint; empty: its laws are those of a prior, and stay alone
/// @param evidence  for a network in each joint
/// @return          none: networks are not needed
std::optional<Candidate> fit_networks(const JointFits& fits, const Arm& plain, const Arm& sum,
                                      const std::vector<friction::LvmParts>& parts,
                                      std::vector<PartEvidence>& evidence);

}  // namespace fricid::estimate
