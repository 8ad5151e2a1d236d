#include "torque/trials.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "support.hpp"

namespace fricid::estimate {
namespace {

using enum JointFits::Rows;
using friction::LvmParts;
using friction::Memory;
using friction::SumPart;

// Conventional laws that the sum has to beat.
constexpr std::pair<const char*, int> kRivals[] = {
    {"coulomb_viscous", 0}, {"stribeck", 0}, {"dahl", 0}, {"lugre", 0}, {"gms", 4}};
constexpr double kPartsGain = 1e-3;   // smallest gain of a step where fits are only compared
constexpr double kRoughGain = 1e-2;   // .. where a law may be lost anyway:
constexpr double kLost = 10;          // times the held-out torque error of the sum
constexpr double kNetworkTorque = 3;  // Fn of a network: times the residual of the sum
constexpr double kNear = 3;  // times the least held-out error: windows may turn the order round

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

}  // namespace

bool is_sum(const ModelOptions& config) {
  return config.laws.empty() && config.law == friction::kLvm;
}

Trials::Trials(const Prepared& prepared, const JointFits& fits, const ModelOptions& config,
               int seed)
    : prepared_(prepared),
      fits_(fits),
      seed_(seed),
      label_(config.label.empty() ? config.name : config.label),
      progress_(fmt::format("fit {}", label_),
                is_sum(config) ? 5 + 2 * static_cast<int>(std::size(kRivals)) : 1) {}

void Trials::add(Trial trial) {
  progress_.advance(1,
                    fmt::format("{} {:.2e} rad2", trial.candidate.name, trial.candidate.held_out));
  trials_.push_back(std::move(trial));
}

double Trials::near() const {
  const auto held_out = [](const Trial& trial) { return trial.candidate.held_out; };
  return kNear * held_out(*std::ranges::min_element(trials_, {}, held_out));
}

void Trials::add_law(const friction::JointSpec& spec) {
  const ArmTorqueFit fit = fits_.on_torque(fits_.start(spec), kTraining);
  add({fits_.judged("torque", fit.arm, fit.seconds), {}, {}});
}

/// The sum whose parts the held-out torque wants: with all parts and either memory; the better
/// memory joint by joint; without the parts that say nothing. @param bank  the first of these fits
std::vector<LvmParts> Trials::fit_sum(std::vector<PartEvidence>& evidence, Arm& bank) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<LvmParts> parts(static_cast<std::size_t>(fits_.n()));
  for (LvmParts& of_joint : parts) of_joint.temperature = fits_.has_temperature();
  const auto weighed = [&](const Arm& start, bool find_ripples) {
    return fits_.on_torque(start, kTraining, find_ripples, kPartsGain).arm;
  };
  bank = weighed(fits_.start(parts), true);
  std::vector<LvmParts> bristles = parts;
  for (LvmParts& of_joint : bristles) of_joint.memory = Memory::kBristle;
  const Arm bristle =
      weighed(with_stribeck_curves(bank, carried_over(bank, fits_.start(bristles))), false);

  for (std::size_t j = 0; j < parts.size(); ++j) {
    evidence.push_back(fits_.compare(bristle, bank, static_cast<int>(j), SumPart::kBristle));
    set(parts[j], evidence.back().part, evidence.back().on);
  }
  const auto of_bristles = std::ranges::count(parts, Memory::kBristle, &LvmParts::memory);
  Arm fitted = of_bristles > 0 ? bristle : bank;
  if (of_bristles > 0 && of_bristles < std::ssize(parts))
    fitted = weighed(carried_over(bristle, carried_over(bank, fits_.start(parts))), false);
  for (const PartEvidence& of_part : fits_.judge_parts(fitted)) {
    evidence.push_back(of_part);
    set(parts[static_cast<std::size_t>(of_part.joint)], of_part.part, of_part.on);
  }
  const Arm chosen = weighed(carried_over(fitted, fits_.start(parts)), false);
  add({fits_.judged("sum", chosen, seconds_since(begin)), {}, {}});
  return parts;
}

/// Networks beside Stribeck friction or beside a bank, without the other parts: a part fitted to
/// what no law describes takes values that a network then has to undo. Where the better of the two
/// explains what the sum leaves, it is fitted with the other parts of the sum too.
void Trials::add_networks(const Arm& bank, const std::vector<LvmParts>& parts,
                          std::vector<PartEvidence>& evidence) {
  const Arm sum = trials_.front().candidate.arm;
  const auto fit = [&](const char* name, const Arm& from, const std::vector<LvmParts>& with) {
    const auto begin = std::chrono::steady_clock::now();
    Arm start = fits_.start(with);
    for (int j = 0; j < fits_.n(); ++j) {
      const int Fn =
          friction::find_parameter(start.friction.model, j, friction::Role::kNetworkTorque);
      start.friction.theta[static_cast<std::size_t>(Fn)] =
          kNetworkTorque * fits_.residual_rms(sum, j);
    }
    start = with_stribeck_curves(from, carried_over(from, std::move(start)));
    const Arm arm = fits_.on_torque(start, kTraining, false, kPartsGain).arm;
    add({fits_.judged(name, arm, seconds_since(begin)), {}, {}});
  };
  const auto plain = [&](Memory memory) {
    std::vector<LvmParts> of_joints;
    for (const LvmParts& of_joint : parts)
      of_joints.push_back({.memory = memory,
                           .temperature = of_joint.temperature,
                           .load = false,
                           .power_flow = false,
                           .asymmetry = false,
                           .ripples = 0,
                           .network = friction::kNetworkUnits});
    return of_joints;
  };
  fit("stribeck and networks", bank, plain(Memory::kNone));
  fit("bank and networks", bank, plain(Memory::kBank));

  const Trial &last = trials_.back(), &before = trials_[trials_.size() - 2];
  const bool bank_is_better = last.candidate.held_out < before.candidate.held_out;
  const Arm better = (bank_is_better ? last : before).candidate.arm;
  bool any = false;
  for (int j = 0; j < fits_.n(); ++j) {
    evidence.push_back(fits_.compare(better, sum, j, SumPart::kNetwork));
    any = any || evidence.back().on;
  }
  std::vector<LvmParts> all = parts;
  for (LvmParts& of_joint : all) {
    of_joint.memory = bank_is_better ? Memory::kBank : Memory::kNone;
    set(of_joint, SumPart::kNetwork, true);
  }
  if (any && all != plain(all.front().memory)) fit("sum and networks", better, all);
}

/// A joint keeps the law of the arm with the least held-out torque error unless another's lowers
/// that of the joint by more than its standard error.
void Trials::add_best_of_each_joint() {
  const auto begin = std::chrono::steady_clock::now();
  const auto torque = [](const Trial& trial) { return trial.candidate.torque; };
  const Arm& first = std::ranges::min_element(trials_, {}, torque)->candidate.arm;
  std::vector<const Arm*> best(static_cast<std::size_t>(fits_.n()), &first);
  for (std::size_t j = 0; j < best.size(); ++j) {
    double most = 0;
    for (const Trial& trial : trials_) {
      const PartEvidence found = fits_.compare(trial.candidate.arm, first, static_cast<int>(j), {});
      if (!found.on || found.gain <= most) continue;
      most = found.gain;
      best[j] = &trial.candidate.arm;
    }
  }
  if (std::ranges::count(best, &first) == std::ssize(best)) return;
  const Arm fitted = fits_.on_torque(joined(best, first), kTraining, false, kPartsGain).arm;
  add({fits_.judged("best of each joint", fitted, seconds_since(begin)), {}, {}});
}

void Trials::add_sum(std::vector<PartEvidence>& evidence) {
  Arm bank;
  const std::vector<LvmParts> parts = fit_sum(evidence, bank);
  add_networks(bank, parts, evidence);
  const std::size_t first_rival = trials_.size();
  for (const auto& [law, elements] : kRivals) {
    const auto begin = std::chrono::steady_clock::now();
    const Arm start = fits_.start(friction::JointSpec{{{law, elements, {}}}});
    Arm arm = fits_.on_torque(start, kTraining, false, kRoughGain).arm;
    if (fits_.held_out_torque(arm) < kLost * trials_.front().candidate.torque)
      arm = fits_.on_torque(arm, kTraining, false, kPartsGain).arm;
    add({fits_.judged(law, arm, seconds_since(begin)), {}, {}});
  }
  add_best_of_each_joint();
  const double near = this->near();
  const Prepared training = fits_.training_part();
  for (std::size_t i = 0; i < std::size(kRivals); ++i) {
    if (trials_[first_rival + i].candidate.held_out > near) continue;
    const auto begin = std::chrono::steady_clock::now();
    const char* law = kRivals[i].first;
    if (const std::optional<Arm> arm = conventional(training, law))
      add({fits_.judged(fmt::format("{}, conventional", law), *arm, seconds_since(begin)),
           law,
           {}});
  }
}

void Trials::add_windows() {
  const double near = this->near();
  for (std::size_t i = 0, fitted = trials_.size(); i < fitted; ++i)
    if (trials_[i].candidate.held_out <= near)
      trials_.push_back({fits_.on_windows(trials_[i].candidate, kTraining, label_), {}, i});
}

const Trial& Trials::take() {
  Trial& best = trials_[choose(candidates())];
  best.candidate.taken = true;
  return best;
}

Arm Trials::on_all_rows(const Trial& trial) const {
  if (trial.refined) {
    Candidate start = trial.candidate;
    start.arm = on_all_rows(trials_[*trial.refined]);
    return fits_.on_windows(start, kAll, label_).arm;
  }
  if (trial.conventional)
    return conventional(prepared_, trial.conventional).value_or(trial.candidate.arm);
  return fits_.on_torque(trial.candidate.arm, kAll, false).arm;
}

std::vector<Candidate> Trials::candidates() const {
  std::vector<Candidate> out;
  for (const Trial& trial : trials_) out.push_back(trial.candidate);
  return out;
}

/// The arm of the method conventional, if it has a result.
std::optional<Arm> Trials::conventional(const Prepared& prepared, const char* law) const {
  ModelOptions config;
  config.name = config.law = law;
  const FitReport report = fit_conventional(prepared, config, seed_, fits_.jobs());
  if (!report.has_result()) return std::nullopt;
  return report.model.arm;
}

}  // namespace fricid::estimate
