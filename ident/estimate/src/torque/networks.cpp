#include "fricid/estimate/torque/networks.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string>
#include <utility>

#include "fricid/estimate/torque/carry_over.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

using enum JointFits::Rows;
using friction::LvmParts;
using friction::Memory;
using friction::SumPart;

constexpr int kPasses = 3;            // each weighs the joints by what the last one left
constexpr double kBetter = 1.5;       // errors of rollouts that networks have to better
constexpr double kWorse = 4;          // .. and of the torque that this may cost
constexpr double kLeastGain = 0.2;    // held-out mean square of a joint: less betters no rollout
constexpr double kEnough = 1;         // .. of one joint at least: half of it goes
constexpr double kNetworkTorque = 3;  // Fn: times the residual without networks

/// Memory, viscous torque and a network in the joints that want one.
std::vector<LvmParts> bare(std::vector<LvmParts> parts, const std::vector<bool>& wants,
                           Memory memory) {
  for (std::size_t j = 0; j < parts.size(); ++j)
    if (wants[j])
      parts[j] = {.memory = memory,
                  .temperature = parts[j].temperature,
                  .load = false,
                  .power_flow = false,
                  .asymmetry = parts[j].asymmetry,
                  .ripples = 0,
                  .network = friction::kNetworkUnits};
  return parts;
}

/// The parts with a network in the joints that want one, and all viscous torque beside it.
std::vector<LvmParts> with_networks(std::vector<LvmParts> parts, const std::vector<bool>& wants) {
  for (std::size_t j = 0; j < parts.size(); ++j)
    if (wants[j])
      for (const SumPart part : {SumPart::kNetwork, SumPart::kViscous}) set(parts[j], part, true);
  return parts;
}

/// The fits to the training rows; the first has no networks.
class Trials {
 public:
  Trials(const JointFits& fits, const Arm& plain) : fits_(fits) {
    add("without networks", plain, 1);
  }

  const Candidate& operator[](std::size_t i) const { return found_[i]; }
  const Candidate& last() const { return found_.back(); }
  const std::vector<Candidate>& all() const { return found_; }

  void add(std::string name, const Arm& start, int passes = kPasses,
           double smallest_gain = kPartsGain) {
    const auto begin = std::chrono::steady_clock::now();
    Arm arm = start;
    for (int pass = 0; pass < passes; ++pass)
      arm = fits_.on_torque(arm, kTraining, WaveSearch::kNone, smallest_gain).arm;
    found_.push_back(fits_.judged(std::move(name), arm, seconds_since(begin)));
  }

  /// From what `from` has of it, networks at zero and of the size of what is left without them.
  void add_sum(std::string name, const Arm& from, const std::vector<LvmParts>& parts,
               int passes = kPasses, double smallest_gain = kPartsGain) {
    Arm start = fits_.start(parts);
    for (int j = 0; j < fits_.n(); ++j) {
      const int Fn =
          friction::find_parameter(start.friction.model, j, friction::Role::kNetworkTorque);
      if (Fn >= 0)
        start.friction.theta[static_cast<std::size_t>(Fn)] =
            kNetworkTorque * fits_.residual_rms(found_.front().arm, j);
    }
    add(std::move(name), with_stribeck_curves(from, carried_over(from, std::move(start))), passes,
        smallest_gain);
  }

  /// A joint keeps the friction of the arm with the least held-out torque error unless another's
  /// lowers that of the joint by more than its standard error.
  void add_best_of_each_joint() {
    const Arm first = std::ranges::min_element(found_, {}, &Candidate::torque)->arm;
    std::vector<const Arm*> best(static_cast<std::size_t>(fits_.n()), &first);
    for (std::size_t j = 0; j < best.size(); ++j) {
      double most = 0;
      for (const Candidate& candidate : found_) {
        const PartEvidence better =
            fits_.compare(candidate.arm, first, static_cast<int>(j), SumPart::kNetwork);
        if (!better.on || better.gain <= most) continue;
        most = better.gain;
        best[j] = &candidate.arm;
      }
    }
    if (std::ranges::count(best, &first) < std::ssize(best))
      add("best of each joint", joined(best, first));
  }

 private:
  const JointFits& fits_;
  std::vector<Candidate> found_;
};

}  // namespace

std::optional<Candidate> fit_networks(const JointFits& fits, const Arm& plain, const Arm& sum,
                                      const std::vector<LvmParts>& parts,
                                      std::vector<PartEvidence>& evidence) {
  if (parts.empty()) return std::nullopt;
  const auto begin = std::chrono::steady_clock::now();
  Trials trials(fits, plain);
  std::vector<bool> wants(parts.size(), true);
  double most = 0;
  trials.add_sum("sum and networks", sum, with_networks(parts, wants), 1, kRoughGain);
  std::vector<PartEvidence> gains;
  const auto judge = [&] {
    gains.clear();
    for (int j = 0; j < fits.n(); ++j)
      gains.push_back(fits.compare(trials.last().arm, trials[0].arm, j, SumPart::kNetwork));
  };
  const auto promises = [](const PartEvidence& part) { return part.on && part.gain > kLeastGain; };
  judge();
  // Weights at zero gain little at first: where any joint gains, steps go on before it is judged.
  if (std::ranges::any_of(gains, promises)) {
    trials.add("sum and networks", trials.last().arm, 1);
    judge();
  }
  evidence.insert(evidence.end(), gains.begin(), gains.end());
  for (std::size_t j = 0; j < parts.size(); ++j) {
    wants[j] = promises(gains[j]);
    if (wants[j]) most = std::max(most, gains[j].gain);
  }
  if (most < kEnough) return std::nullopt;

  trials.add_sum("sum and networks", trials.last().arm, with_networks(parts, wants));
  trials.add_sum("stribeck and networks", sum, bare(parts, wants, Memory::kNone));
  const Candidate of_stribeck = trials.last();
  trials.add_sum("bank and networks", sum, bare(parts, wants, Memory::kBank));
  const bool bank = trials.last().held_out < of_stribeck.held_out;
  const Arm from = bank ? trials.last().arm : of_stribeck.arm;
  const Memory memory = bank ? Memory::kBank : Memory::kNone;
  std::vector<LvmParts> whole = with_networks(parts, wants);
  for (std::size_t j = 0; j < whole.size(); ++j)
    if (wants[j]) {
      whole[j].memory = memory;
      // without springs in the memory the cable would be what holds the Coulomb friction
      whole[j].cable = whole[j].cable && memory != Memory::kNone;
    }
  if (whole != bare(parts, wants, memory)) trials.add_sum("networks and sum", from, whole);
  trials.add_best_of_each_joint();

  std::vector<Candidate> cheap = trials.all();
  std::erase_if(cheap, [&](const Candidate& candidate) {
    return candidate.torque >= kWorse * trials[0].torque || !has_networks(candidate.arm);
  });
  if (cheap.empty()) return std::nullopt;
  const Candidate& best = cheap[choose(cheap)];
  const Difference gain = between(trials[0].rollouts, best.rollouts);
  const bool rolls_better = gain.mean > gain.error && kBetter * best.held_out < trials[0].held_out;
  if (!rolls_better && !explains_far_more(best, trials[0])) return std::nullopt;
  const Arm arm = fits.on_torque(best.arm, kAll, WaveSearch::kNone).arm;
  return fits.judged(best.name, arm, seconds_since(begin));
}

}  // namespace fricid::estimate
