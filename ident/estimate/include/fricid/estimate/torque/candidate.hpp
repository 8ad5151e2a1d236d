// One of several fits of which held-out data choose, and the evidence for each part of a sum.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fricid/estimate/windows/multi_step.hpp"
#include "fricid/friction/sum.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// A fitted arm and its errors on the held-out part of the recordings.
struct Candidate {
  std::string name;  ///< "sum", "gms, windows"
  Arm arm;
  RolloutErrors rollouts;  ///< on the held-out part
  double held_out = 0;     ///< their geometric mean, `held_out_error` [rad^2]
  double torque = 0;       ///< mean over joints of residual / torque variance, held-out rows [1]
  int parameters = 0;      ///< free ones of the friction
  double seconds = 0;
  bool rival = false;            ///< a conventional law, which the sum contains
  bool near_regression = false;  ///< see `JointFits::pull_to_regression`
  bool taken = false;
};

/// Mean difference a - b of the logarithms of rollout errors on the same stretches, weighed as in
/// `RolloutErrors::mean`, and its standard error, rollouts counting as independent; infinite where
/// there is one of a kind and no other to tell how much they vary.
struct Difference {
  double mean = 0, error = 0;
};
Difference between(const RolloutErrors& a, const RolloutErrors& b);

/// Whether the friction has networks.
bool has_networks(const Arm& arm);

/// Which candidates' held-out rollouts fell no more often than those of the best, and are no worse
/// by more than a standard error; where rollouts of a second are fewer than ten, by more than a
/// factor of three, and one fall of a rollout of full length does not count. A candidate whose
/// held-out torque error is four times the least of those with rollouts within thirty times the
/// best has good rollouts by chance: it is neither, unless all others fall more often.
std::vector<bool> eligible(std::span<const Candidate> candidates);
/// Of those the one with fewest parameters among the least held-out torque error and what is within
/// 3 % of it; of as many, the one with the best rollouts. Where rollouts are so few, one of the
/// conventional laws is chosen so, within 6 %, and of that and the others the one with the least
/// product of torque and rollout error. The best where none is eligible.
/// @return index
std::size_t choose(std::span<const Candidate> candidates);

/// Whether `a` leaves less than a quarter of the held-out torque error of `b`, and its rollouts
/// fell no more often and are no worse by more than a standard error.
bool explains_far_more(const Candidate& a, const Candidate& b);

/// Evidence of the held-out torque for one part of the sum in one joint.
struct PartEvidence {
  friction::SumPart part = friction::SumPart::kBristle;
  int joint = 0;
  double gain = 0;   ///< relative rise of the held-out mean square without the part [1]
  double error = 0;  ///< standard error of it, seconds counting as independent [1]
  bool on = false;
};

}  // namespace fricid::estimate
