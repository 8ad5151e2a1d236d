#include "fricid/estimate/torque/sum_fit.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <ranges>
#include <utility>

#include "fricid/estimate/torque/carry_over.hpp"
#include "support.hpp"
#include "torque/fitted_parts.hpp"

namespace fricid::estimate {
namespace {

using friction::SumPart;

constexpr int kSweeps = 2;  // over the parts
// Of load on the link's side of a gear, where it shows most: share of the mean square, and standard
// errors.
constexpr double kGearGain = 0.05, kGearErrors = 3;
constexpr double kInnerGain = 0.2, kInnerErrors = 2;  // of viscous friction in the memory, likewise
// Of twice as many springs: the filters of motion and torque round the corner of a single one.
constexpr double kSpringsGain = 0.1;
constexpr double kHopeless = -0.98;             // gain without memory: 50 times the mean square
constexpr double kSmallestGap = 1e-5;           // [rad], below it a fit has closed the gap
constexpr double kOpenGaps[] = {3e-4, 1.5e-3};  // half of them [rad], at a start
constexpr double kNearGap = -0.3;  // gain of a rough fit with gaps that is worth another
constexpr double kTie = 1.1;       // held-out torques, between which rollouts decide
constexpr double kFarBehind = 10;  // the same: parts that explain this much are not left out

/// Half the width of the gap of a joint [rad].
double gap_of(const Arm& arm, int j) {
  const int b = friction::find_parameter(arm.friction.model, j, friction::Role::kGap);
  return b < 0 ? 0 : arm.friction.theta[static_cast<std::size_t>(b)];
}

/// The sum on the training rows, part by part as the held-out torque wants.
class SumChoice : public FittedParts {
 public:
  /// Begins with all parts of the laws from what `from` has of them.
  SumChoice(JointFits& fits, const Arm& from) : FittedParts(fits) {
    const Arm start = start_with(fits.all_parts());
    fitted_ = fit(with_stribeck_curves(from, carried_over(from, start)), WaveSearch::kGears);
  }
  /// Begins with a memory alone: on a long log the one that explains more, else a bank.
  explicit SumChoice(JointFits& fits) : FittedParts(fits) {
    const auto n = static_cast<std::size_t>(fits.n());
    friction::LvmParts alone{.load = false, .power_flow = false, .asymmetry = false, .ripples = 0};
    fitted_ = fit(start_with(Parts(n, alone)));
    if (fits.is_short()) return;
    alone.memory = friction::Memory::kBristle;
    const Parts bank = std::exchange(parts_, Parts(n, alone));
    if (const Arm bristle = fit(fits_->start(parts_));
        fits_->held_out_torque(bristle) < fits_->held_out_torque(fitted_))
      fitted_ = bristle;
    else
      parts_ = bank;
  }

  /// Parts of the laws, until none is added. One may show only when another is there.
  void add_parts() {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool any = false;
      for (const SumPart part : {SumPart::kTemperature, SumPart::kRipple, SumPart::kLoad,
                                 SumPart::kPowerFlow, SumPart::kAsymmetry})
        any = try_part(part) || any;
      if (!any) return;
    }
  }

  /// Whether `other` explains more, whatever memory this has.
  bool is_behind(const SumChoice& other) const {
    const double bar = kTie * fits_->held_out_torque(other.fitted());
    return bar < fits_->held_out_torque(fitted_) && bar < fits_->held_out_torque(with_bristles());
  }

  /// What else may be in a joint, and what says nothing.
  void complete() {
    search();
    leave_out_idle();
  }

 private:
  void search() {
    try_gear_loads();
    try_memories();
    try_gaps();
    try_bristles_behind_gaps();
    if (try_inner_viscous()) try_memories();
    if (try_under_load(SumPart::kLoadedViscous)) try_memories();
    if (try_stribeck()) {
      if (!fits_->is_short()) try_under_load(SumPart::kLoadedStribeck);
      try_memories();
    }
    const Parts before = parts_;
    try_ripples();
    // a few seconds are no proof for a cable, or against a part
    if (!fits_->is_short()) {
      try_bristles_and_cables();
      try_cables();
    }
    // a wave or a cable that was not known had hidden what the memory is
    if (parts_ != before) {
      try_gear_loads();
      try_memories();
      if (try_inner_viscous()) try_memories();
      if (!fits_->is_short() && try_stribeck()) try_memories();
    }
    if (fits_->is_short()) return;
    try_further_modifiers();
    leave_out_parts();
  }

  /// What the gear hands on as load, where there is one, instead of the motor's torque. The gears
  /// of an arm are of one kind: where one shows it and they gain together, the others need no
  /// proof.
  void try_gear_loads() {
    Parts with = parts_;
    for (friction::LvmParts& of_joint : with)
      if (of_joint.load || of_joint.power_flow) set(of_joint, SumPart::kGearLoad, true);
    if (with == parts_) return;
    const Arm gears = fit(with_load_growth(fitted_, from_fitted(with)));
    bool one_shows_it = false;
    double together = 0;
    for (int j = 0; j < fits_->n(); ++j) {
      if (!has(with[static_cast<std::size_t>(j)], SumPart::kGearLoad)) continue;
      const PartEvidence part = fits_->compare(gears, fitted_, j, SumPart::kGearLoad);
      together += part.gain;
      one_shows_it = one_shows_it || part.gain > std::max(kGearGain, kGearErrors * part.error);
    }
    const bool proven =
        fits_->is_short() ? is_clear(gears, SumPart::kGearLoad) : one_shows_it && together > 0;
    take(SumPart::kGearLoad, gears, [&](const PartEvidence& part) {
      return proven && part.on &&
             has(with[static_cast<std::size_t>(part.joint)], SumPart::kGearLoad);
    });
  }

  /// Load on friction of the speed alone, where the residual of a joint looks like it. Load on the
  /// memory may have stood for it, far from both: a start that knows nothing may be nearer.
  /// @return whether a joint has it
  bool try_under_load(SumPart part) {
    const std::vector<bool> promises = fits_->promises(part, fitted_);
    if (std::ranges::none_of(promises, std::identity())) return false;
    Parts with = parts_;
    for (std::size_t j = 0; j < with.size(); ++j)
      if (fits_->can_show(part, static_cast<int>(j)) &&
          (part == SumPart::kLoadedViscous || with[j].stribeck))
        set(with[j], part, true);
    if (with == parts_) return false;
    const Parts before = parts_;
    const Arm loaded =
        better_of_each_joint(fit(from_fitted(with)), fit(fits_->start(with), WaveSearch::kGears));
    return take(part, loaded, [&](const PartEvidence& of_joint) {
      const auto j = static_cast<std::size_t>(of_joint.joint);
      return with[j] != before[j] && explains_enough(of_joint);
    });
  }

  /// Temperature and direction of what stands beside the memory and the viscous torque. Other parts
  /// may have stood for them, far from the truth: a start that knows nothing may be nearer.
  void try_further_modifiers() {
    Parts with = parts_;
    for (friction::LvmParts& of_joint : with)
      if ((of_joint.temperature || of_joint.asymmetry) &&
          (of_joint.power_flow || of_joint.stribeck || of_joint.cable))
        set(of_joint, SumPart::kFurtherModifiers, true);
    if (with == parts_) return;
    const auto earns = [&](const PartEvidence& part) {
      return has(with[static_cast<std::size_t>(part.joint)], SumPart::kFurtherModifiers) &&
             explains_enough(part);
    };
    Arm modified = fit(from_fitted(with));
    if (shows(modified, SumPart::kFurtherModifiers, earns))
      modified = better_of_each_joint(modified, fit(fits_->start(with), WaveSearch::kGears));
    take(SumPart::kFurtherModifiers, modified, earns);
  }

  /// Another memory instead of the bank: a bristle, or none.
  void try_memories() {
    bristles_ = with_bristles();
    take(SumPart::kBristle, bristles_, explains);
    try_memoryless();
  }

  /// No memory, alone and with gear load, which may hide behind a bank. Most joints are told apart
  /// by a rough fit.
  void try_memoryless() {
    const Parts none = switched(SumPart::kMemoryless);
    if (none == parts_ || is_hopeless_without_memory_) return;
    Arm without =
        fit(with_curves_without_memory(fitted_, from_fitted(none)), WaveSearch::kNone, kRoughGain);
    is_hopeless_without_memory_ = true;
    for (int j = 0; j < fits_->n(); ++j)
      if (none[static_cast<std::size_t>(j)] != parts_[static_cast<std::size_t>(j)] &&
          fits_->compare(without, fitted_, j, SumPart::kMemoryless).gain > kHopeless)
        is_hopeless_without_memory_ = false;
    if (is_hopeless_without_memory_) return;
    without = with_curves_risen(fit(without));
    const bool taken = take(SumPart::kMemoryless, without, explains);
    if (taken) try_gear_loads();
    try_memoryless_under_gear_load();
  }
  /// Fitted again from curves that rise towards rest, where some fall; each joint keeps the better.
  Arm with_curves_risen(const Arm& fitted) const {
    const std::optional<Arm> rising =
        with_rising_curves(fitted, fits_->start(fitted.friction.model.joints()));
    return rising ? better_of_each_joint(fitted, fit(*rising)) : fitted;
  }

  void try_memoryless_under_gear_load() {
    Parts with = parts_;
    for (int j = 0; j < fits_->n(); ++j) {
      friction::LvmParts& of_joint = with[static_cast<std::size_t>(j)];
      const bool may_hide = of_joint.power_flow && !of_joint.gear_load;  // behind power flow
      if (of_joint.memory == friction::Memory::kNone && !may_hide) continue;
      set(of_joint, SumPart::kMemoryless, true);
      if (fits_->can_show(SumPart::kGearLoad, j)) set(of_joint, SumPart::kGearLoad, true);
      of_joint.power_flow = false;
    }
    if (with == parts_) return;
    const Arm both = with_curves_risen(fit(fits_->start(with)));
    if (take_together({SumPart::kMemoryless, SumPart::kGearLoad}, with, both,
                      earning(both, SumPart::kMemoryless)) &&
        !fits_->is_short())
      leave_out(SumPart::kGearLoad);
  }

  /// A gap before the memory.
  void try_gaps() {
    const Arm gaps = fit(from_fitted(switched(SumPart::kBacklash)));
    take(SumPart::kBacklash, gaps, [&](const PartEvidence& part) {
      return part.on && gap_of(gaps, part.joint) > kSmallestGap;
    });
  }

  /// Both at once: a bank stands for a bristle behind a gap, and neither alone is better than it. A
  /// gap that begins closed stays so. On a short log, where a gap was found in any joint.
  void try_bristles_behind_gaps() {
    if (fits_->is_short() && std::ranges::none_of(parts_, &friction::LvmParts::backlash)) return;
    Parts with = switched(SumPart::kBacklash);
    for (friction::LvmParts& of_joint : with) set(of_joint, SumPart::kBristle, true);
    if (with == parts_) return;
    const Arm start = with_stribeck_curves(fitted_, from_fitted(with));
    Arm both = fit(start, WaveSearch::kNone, kRoughGain);
    for (const double half : kOpenGaps)
      both = better_of_each_joint(
          both, fit(with_open_gaps(start, half), WaveSearch::kNone, kRoughGain), kRoughGain);
    if (!shows(both, SumPart::kBacklash,
               [](const PartEvidence& part) { return part.gain > kNearGap; }))
      return;
    both = fit(both);
    take_together({SumPart::kBristle, SumPart::kBacklash}, with, both,
                  [&](const PartEvidence& part) {
                    return part.on && gap_of(both, part.joint) > kSmallestGap;
                  });
  }

  /// Viscous friction that the modifiers of the memory scale. @return whether a joint has it
  bool try_inner_viscous() {
    const Parts with = switched(SumPart::kInnerViscous);
    const Arm inner =
        fit(with_viscous_friction(fitted_, from_fitted(with)), WaveSearch::kNone, kRoughGain);
    return take(SumPart::kInnerViscous, inner, [&](const PartEvidence& part) {
      const bool memoryless =
          has(parts_[static_cast<std::size_t>(part.joint)], SumPart::kMemoryless);
      return part.on && (memoryless || part.gain > std::max(kInnerGain, kInnerErrors * part.error));
    });
  }

  /// A Stribeck torque that waits for no spring, beside the memory as it is or, since a bank stands
  /// for the two and neither alone is better than it, beside a bristle.
  /// @return whether a joint has it
  bool try_stribeck() {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      const Parts before = parts_, beside = switched(SumPart::kStribeck);
      if (beside != parts_) {
        const Arm with = fit(from_fitted(beside), WaveSearch::kNone, kRoughGain);
        take(SumPart::kStribeck, with, earning(with, SumPart::kStribeck));
      }
      Parts with = beside;
      for (friction::LvmParts& of_joint : with) set(of_joint, SumPart::kBristle, true);
      if (with == parts_) break;
      Arm both = fit(with_stribeck_beside(carried_over(bristles_, from_fitted(with))));
      // a curve that stood for two lies far from both: a start that knows nothing may be nearer
      if (std::ranges::any_of(parts_, &friction::LvmParts::stribeck) ||
          shows(both, SumPart::kStribeck))
        both = better_of_each_joint(both, fit(fits_->start(with)));
      take_together({SumPart::kBristle, SumPart::kStribeck}, with, both,
                    earning(both, SumPart::kStribeck));
      if (parts_ == before) break;
    }
    // two curves, of which the wide one is found first
    if (const std::optional<Arm> start = with_curves_in_memories(fitted_))
      fitted_ = better_of_each_joint(fitted_, fit(*start));
    return std::ranges::any_of(parts_, &friction::LvmParts::stribeck);
  }

  /// Further waves over the joint angle, until no joint has one more.
  void try_ripples() {
    for (const SumPart part : {SumPart::kSecondRipple, SumPart::kThirdRipple}) {
      const Arm waves = fit(from_fitted(switched(part)), WaveSearch::kGears, kRoughGain);
      if (!take(part, waves, explains_enough)) return;
    }
  }

  /// Both at once, where what bristles leave looks like a cable: a bank with long springs stands
  /// for the two, and neither alone is better than it.
  void try_bristles_and_cables() {
    Parts with = switched(SumPart::kBristle);
    for (friction::LvmParts& of_joint : with) set(of_joint, SumPart::kCable, true);
    const std::vector<Cable> cables = fits_->promising_cables(bristles_);
    for (std::size_t j = 0; j < with.size(); ++j)
      if (cables[j].K == 0) with[j] = parts_[j];
    if (with == parts_) return;
    Arm start = carried_over(bristles_, from_fitted(with));
    start_cables(cables, start.friction);
    take_together({SumPart::kBristle, SumPart::kCable}, with, fits_->on_torque_of_springs(start),
                  explains_enough);
    keep_springs_of(with);
  }

  /// A cable in the joints whose residual looks like one.
  void try_cables() {
    std::vector<Cable> cables = fits_->promising_cables(fitted_);
    Parts with = parts_;
    for (std::size_t j = 0; j < with.size(); ++j) {
      if (parts_[j].cable) cables[j] = {};
      if (cables[j].K > 0) set(with[j], SumPart::kCable, true);
    }
    if (with == parts_) return;
    Arm start = from_fitted(with);
    start_cables(cables, start.friction);
    take(SumPart::kCable, fits_->on_torque_of_springs(start), [&](const PartEvidence& part) {
      return cables[static_cast<std::size_t>(part.joint)].K > 0 && explains_enough(part);
    });
    keep_springs_of(with);
  }

  /// The rows of joints whose cables were not taken count in full again.
  void keep_springs_of(const Parts& tried) {
    fits_->take_springs_of(fitted_);
    if (parts_ != tried && std::ranges::any_of(parts_, &friction::LvmParts::cable))
      fitted_ = fit(fitted_);
  }

  /// What says nothing beside the others goes, one part after the other: of two that stand for each
  /// other one stays.
  void leave_out_parts() {
    for (const SumPart part : {SumPart::kEightSprings, SumPart::kFourSprings, SumPart::kTwoSprings})
      leave_out(part, [](const PartEvidence& springs) {
        return explains(springs) && springs.gain > kSpringsGain;
      });
    fitted_ = with_strongest_waves_first(fitted_);
    for (const SumPart part : {SumPart::kThirdRipple, SumPart::kSecondRipple, SumPart::kRipple})
      leave_out(part, explains_enough);
    for (const SumPart part :
         {SumPart::kPowerFlow, SumPart::kLoad, SumPart::kAsymmetry, SumPart::kTemperature,
          SumPart::kStribeck, SumPart::kBacklash, SumPart::kViscous})
      leave_out(part);
  }

  bool try_part(SumPart part) {
    const Parts with = switched(part);
    if (with == parts_) return false;
    return take(part,
                fit(from_fitted(with),
                    part == SumPart::kRipple ? WaveSearch::kGears : WaveSearch::kNone, kRoughGain),
                explains);
  }

  Arm with_bristles() const {
    return fit(with_stribeck_curves(fitted_, from_fitted(switched(SumPart::kBristle))));
  }

  Arm bristles_;  // with a bristle in every joint
  bool is_hopeless_without_memory_ = false;
};

/// The better of two choices: one begins with all parts of the laws, the other adds parts.
SumChoice better_choice(JointFits& fits, const Arm& from) {
  SumChoice all(fits, from), added(fits);
  const bool is_short = fits.is_short();
  const bool needs_parts =
      fits.held_out_torque(added.fitted()) > kFarBehind * fits.held_out_torque(all.fitted());
  if (is_short || !needs_parts) added.add_parts();
  if (!is_short && all.is_behind(added)) {
    added.complete();
    return added;
  }
  const auto judged = [&](const SumChoice& sum) {
    return fits.judged("", sum.fitted(JointFits::Rows::kTraining), 0);
  };
  all.complete();
  const Candidate many = judged(all);
  fits.take_springs_of(added.fitted());
  if (!is_short && kTie * fits.held_out_torque(added.fitted()) > many.torque) return all;
  added.complete();
  const Candidate few = judged(added);
  const bool tie = std::max(few.torque, many.torque) < kTie * std::min(few.torque, many.torque);
  const bool is_better = tie ? few.held_out < many.held_out : few.torque < many.torque;
  return is_better ? added : all;
}

}  // namespace

Candidate fit_sum(JointFits& fits, const Arm& from, std::vector<friction::LvmParts>& parts,
                  std::vector<PartEvidence>& evidence) {
  const auto begin = std::chrono::steady_clock::now();
  SumChoice taken = better_choice(fits, from);
  fits.take_springs_of(taken.fitted());
  if (const std::optional<ArmPrior>& prior = fits.prior()) {
    const auto like = [&](JointFits::Rows rows) {
      fits.take_viscous_of(fits.all_parts());
      return fits.on_torque(prior->arm, rows).arm;
    };
    if (fits.keeps_prior(fits.held_out_torque(like(JointFits::Rows::kTraining)),
                         fits.held_out_torque(taken.fitted(JointFits::Rows::kTraining))))
      return fits.judged("like the prior", like(JointFits::Rows::kAll), seconds_since(begin));
  }
  taken.take_all_rows();
  parts = taken.parts();
  evidence = taken.evidence();
  return fits.judged("sum", taken.fitted(), seconds_since(begin));
}

}  // namespace fricid::estimate
