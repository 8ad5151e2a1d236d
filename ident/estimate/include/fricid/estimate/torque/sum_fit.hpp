// The model lvm: which parts of the sum are on.
#pragma once

#include <vector>

#include "fricid/estimate/torque/joint_fit.hpp"

namespace fricid::estimate {

/// The sum whose parts the held-out torque wants, on all rows. Fits to the training rows begin with
/// a bank and all parts of the laws, at what `from` has of them; a bristle in its place, a gap
/// before it, further ripples and, on long logs, cables are taken joint by joint where they lower
/// the held-out error, and parts that say nothing are left out. Another choice begins with the
/// memory alone, a bank or, on a long log, a bristle, and adds parts one by one: a sum with all
/// parts may end in a minimum of its own, and fits a short log by values that no gear has. On a
/// long log the other choice alone goes on where it errs less before bristles, gaps and cables are
/// tried, and the first alone where a memory without parts errs ten times as much. The one that
/// errs less on held-out torque is taken or, where they err about as much, less in held-out
/// rollouts. Where there is a prior (`JointFits::take_prior`) its laws, pulled to it, are what is
/// returned if they err less on the held-out rows, on a short log less than twice as much; `parts`
/// stays empty then.
Candidate fit_sum(JointFits& fits, const Arm& from, std::vector<friction::LvmParts>& parts,
                  std::vector<PartEvidence>& evidence);

}  // namespace fricid::estimate
