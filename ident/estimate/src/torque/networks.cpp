#include "torque/networks.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string>
#include <utility>

#include "support.hpp"

namespace fricid::estimate {
namespace {

using enum JointFits::Rows;
using friction::LvmParts;
using friction::Memory;
using friction::SumPart;

constexpr double kSmallestGain = 1e-3;  // of a step where fits are only compared
constexpr int kPasses = 3;              // each weighs the joints by what the last one left
constexpr double kBetter = 1.5;         // errors of rollouts that networks have to better
constexpr double kWorse = 4;            // .. and of the torque that this may cost
constexpr double kNetworkTorque = 3;    // Fn: times the residual without networks

/// Memory, viscous torque and a network.
std::vector<LvmParts> bare(const std::vector<LvmParts>& parts, Memory memory) {
  std::vector<LvmParts> out;
  for (const LvmParts& of_joint : parts)
    out.push_back({.memory = memory,
                   .temperature = of_joint.temperature,
                   .load = false,
                   .power_flow = false,
                   .asymmetry = false,
                   .ripples = 0,
                   .network = friction::kNetworkUnits});
  return out;
}

/// The friction of each joint from one arm of several, and the rigid body of the first.
Arm joined(const std::vector<const Arm*>& of_joint, const Arm& first) {
  std::vector<friction::JointSpec> specs;
  Arm out = first;
  out.friction.theta.clear();
  for (std::size_t j = 0; j < of_joint.size(); ++j) {
    const friction::Friction& from = of_joint[j]->friction;
    const int joint = static_cast<int>(j);
    specs.push_back(from.model.joints()[j]);
    out.friction.theta.insert(out.friction.theta.end(),
                              from.theta.begin() + from.model.parameter_begin(joint),
                              from.theta.begin() + from.model.parameter_begin(joint + 1));
  }
  out.friction.model = friction::RobotFriction(std::move(specs));
  return out;
}

/// The fits to the training rows; the first has no networks.
class Trials {
 public:
  Trials(const JointFits& fits, const Arm& plain) : fits_(fits) { add("without networks", plain); }

  const Candidate& operator[](std::size_t i) const { return found_[i]; }
  const std::vector<Candidate>& all() const { return found_; }

  void add(std::string name, const Arm& start) {
    const auto begin = std::chrono::steady_clock::now();
    const Arm arm = fits_.on_torque(start, kTraining, false, kSmallestGain).arm;
    found_.push_back(fits_.judged(std::move(name), arm, seconds_since(begin)));
  }

  /// Fits on from there.
  void refine(Candidate& candidate) {
    const auto begin = std::chrono::steady_clock::now();
    Arm arm = candidate.arm;
    for (int pass = 1; pass < kPasses; ++pass)
      arm = fits_.on_torque(arm, kTraining, false, kSmallestGain).arm;
    candidate = fits_.judged(candidate.name, arm, candidate.seconds + seconds_since(begin));
  }
  void refine_all() {
    std::ranges::for_each(found_, [this](Candidate& c) { refine(c); });
  }
  void refine_last() { refine(found_.back()); }

  /// From what `from` has of it, networks at zero and of the size of what is left without them.
  void add_sum(std::string name, const Arm& from, const std::vector<LvmParts>& parts) {
    Arm start = fits_.start(parts);
    for (int j = 0; j < fits_.n(); ++j) {
      const int Fn =
          friction::find_parameter(start.friction.model, j, friction::Role::kNetworkTorque);
      start.friction.theta[static_cast<std::size_t>(Fn)] =
          kNetworkTorque * fits_.residual_rms(found_.front().arm, j);
    }
    add(std::move(name), with_stribeck_curves(from, carried_over(from, std::move(start))));
  }

  /// A joint keeps the friction of the arm with the least held-out torque error unless another's
  /// lowers that of the joint by more than its standard error.
  void add_best_of_each_joint() {
    const Arm first = std::ranges::min_element(found_, {}, &Candidate::torque)->arm;
    std::vector<const Arm*> best(static_cast<std::size_t>(fits_.n()), &first);
    for (std::size_t j = 0; j < best.size(); ++j) {
      double most = 0;
      for (const Candidate& candidate : found_) {
        const PartEvidence better = fits_.compare(candidate.arm, first, static_cast<int>(j), {});
        if (!better.on || better.gain <= most) continue;
        most = better.gain;
        best[j] = &candidate.arm;
      }
    }
    if (std::ranges::count(best, &first) == std::ssize(best)) return;
    add("best of each joint", joined(best, first));
    refine_last();
  }

 private:
  const JointFits& fits_;
  std::vector<Candidate> found_;
};

}  // namespace

std::optional<Candidate> fit_networks(const JointFits& fits, const Arm& plain, const Arm& sum,
                                      const std::vector<LvmParts>& parts,
                                      std::vector<PartEvidence>& evidence) {
  const auto begin = std::chrono::steady_clock::now();
  Trials trials(fits, plain);
  trials.add_sum("stribeck and networks", sum, bare(parts, Memory::kNone));
  trials.add_sum("bank and networks", sum, bare(parts, Memory::kBank));
  const auto better = [&]() -> std::size_t {
    return trials[2].held_out < trials[1].held_out ? 2 : 1;
  };
  const auto gains = [&] {
    std::vector<PartEvidence> of_joints;
    for (int j = 0; j < fits.n(); ++j)
      of_joints.push_back(fits.compare(trials[better()].arm, trials[0].arm, j, SumPart::kNetwork));
    return of_joints;
  };
  std::vector<PartEvidence> found = gains();
  const bool any = std::ranges::any_of(found, &PartEvidence::on);
  if (any) {
    trials.refine_all();
    found = gains();
  }
  std::ranges::copy(found, std::back_inserter(evidence));
  if (!any) return std::nullopt;
  std::vector<LvmParts> whole = parts;
  for (LvmParts& of_joint : whole) {
    of_joint.memory = better() == 2 ? Memory::kBank : Memory::kNone;
    set(of_joint, SumPart::kNetwork, true);
  }
  if (whole != bare(parts, whole.front().memory)) {
    trials.add_sum("sum and networks", trials[better()].arm, whole);
    trials.refine_last();
  }
  trials.add_best_of_each_joint();

  std::vector<Candidate> cheap = trials.all();
  std::erase_if(cheap, [&](const Candidate& candidate) {
    return candidate.torque >= kWorse * trials[0].torque;
  });
  const Candidate& best = cheap[choose(cheap)];
  const bool worth_it = has_networks(best.arm) && kBetter * best.held_out < trials[0].held_out;
  if (!worth_it) return std::nullopt;
  const Arm arm = fits.on_torque(best.arm, kAll, false).arm;
  return fits.judged(best.name, arm, seconds_since(begin));
}

}  // namespace fricid::estimate
