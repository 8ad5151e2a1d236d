#include "fricid/estimate/torque/sum_fit.hpp"

#include <chrono>
#include <functional>

#include "support.hpp"

namespace fricid::estimate {
namespace {

using friction::SumPart;

constexpr double kPartsGain = 1e-3;    // smallest gain of a step where fits are only compared
constexpr double kRoughGain = 1e-2;    // .. where a part may be off anyway
constexpr double kWaveGain = 0.05;     // least of a wave, which is the best of many
constexpr double kSmallestGap = 1e-5;  // [rad], below it a fit has closed the gap

/// Half the width of the gap of a joint [rad].
double gap_of(const Arm& arm, int j) {
  const int b = friction::find_parameter(arm.friction.model, j, friction::Role::kGap);
  return b < 0 ? 0 : arm.friction.theta[static_cast<std::size_t>(b)];
}

/// The sum on the training rows, part by part as the held-out torque wants.
class SumChoice {
 public:
  SumChoice(const JointFits& fits, std::vector<friction::LvmParts>& parts,
            std::vector<PartEvidence>& evidence)
      : fits_(fits), parts_(parts), evidence_(evidence) {
    parts_.assign(static_cast<std::size_t>(fits.n()), {});
    for (friction::LvmParts& of_joint : parts_) of_joint.temperature = fits.has_temperature();
    fitted_ = fit(fits_.start(parts_), true);
  }

  /// A bristle instead of the bank, joint by joint.
  void try_bristles() {
    const Arm bristle =
        fit(with_stribeck_curves(fitted_, from_fitted(switched(SumPart::kBristle))));
    const auto on = [](const PartEvidence& part) { return part.on; };
    take(SumPart::kBristle, bristle, on);
  }

  /// A gap before the memory.
  void try_gaps() {
    const Arm gaps = fit(from_fitted(switched(SumPart::kBacklash)));
    take(SumPart::kBacklash, gaps, [&](const PartEvidence& part) {
      return part.on && gap_of(gaps, part.joint) > kSmallestGap;
    });
  }

  /// Further waves over the joint angle, until no joint has one more.
  void try_ripples() {
    for (const SumPart part : {SumPart::kSecondRipple, SumPart::kThirdRipple}) {
      const Arm waves = fit(from_fitted(switched(part)), true, kRoughGain);
      if (!take(part, waves, [](const PartEvidence& of_joint) {
            return of_joint.on && of_joint.gain > kWaveGain;
          }))
        return;
    }
  }

  /// Without the parts that say nothing, on all rows.
  Arm rest() {
    for (const PartEvidence& of_part : fits_.judge_parts(fitted_)) {
      evidence_.push_back(of_part);
      set(parts_[static_cast<std::size_t>(of_part.joint)], of_part.part, of_part.on);
    }
    return fits_.on_torque(from_fitted(parts_), JointFits::Rows::kAll, false).arm;
  }

 private:
  using Parts = std::vector<friction::LvmParts>;

  Arm fit(const Arm& start, bool find_ripples = false, double smallest_gain = kPartsGain) const {
    return fits_.on_torque(start, JointFits::Rows::kTraining, find_ripples, smallest_gain).arm;
  }
  Arm from_fitted(const Parts& parts) const { return carried_over(fitted_, fits_.start(parts)); }
  Parts switched(SumPart part) const {
    Parts out = parts_;
    for (friction::LvmParts& of_joint : out) set(of_joint, part, true);
    return out;
  }

  /// Joints keep the part that `with` has where it earns its place. @return whether any does
  bool take(SumPart part, const Arm& with, const std::function<bool(const PartEvidence&)>& earns) {
    int taken = 0;
    for (int j = 0; j < fits_.n(); ++j) {
      PartEvidence of_joint = fits_.compare(with, fitted_, j, part);
      of_joint.on = earns(of_joint);
      taken += of_joint.on;
      set(parts_[static_cast<std::size_t>(j)], part, of_joint.on);
      evidence_.push_back(of_joint);
    }
    if (taken == fits_.n())
      fitted_ = with;
    else if (taken > 0)
      fitted_ = fit(carried_over(with, from_fitted(parts_)));
    return taken > 0;
  }

  const JointFits& fits_;
  Parts& parts_;
  std::vector<PartEvidence>& evidence_;
  Arm fitted_;
};

}  // namespace

Candidate fit_sum(const JointFits& fits, std::vector<friction::LvmParts>& parts,
                  std::vector<PartEvidence>& evidence) {
  const auto begin = std::chrono::steady_clock::now();
  SumChoice sum(fits, parts, evidence);
  sum.try_bristles();
  sum.try_gaps();
  sum.try_ripples();
  return fits.judged("sum", sum.rest(), seconds_since(begin));
}

}  // namespace fricid::estimate
