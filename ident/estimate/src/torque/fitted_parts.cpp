#include "torque/fitted_parts.hpp"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <utility>

#include "fricid/estimate/torque/carry_over.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

using friction::SumPart;

// Least gain of the best of many: share of the mean square, and standard errors unless it halves
// the mean square.
constexpr double kWaveGain = 0.05, kWaveErrors = 2, kHalf = 1;
constexpr double kClearGain = 0.25, kClearErrors = 3;  // of all joints on a short log, mean
// Of a part whose held-out gain is within its standard error: on the training rows. Chance gains
// parameters over independent rows, some thousandths.
constexpr double kTrainingGain = 0.2;
constexpr double kIdle = 1e-4;      // rise of the mean square without what says nothing
constexpr double kFarBetter = 0.1;  // held-out mean square without a part of a fit that was stuck

}  // namespace

bool explains(const PartEvidence& part) { return part.on; }
bool explains_enough(const PartEvidence& part) {
  return part.on && part.gain > std::max(kWaveGain, std::min(kWaveErrors * part.error, kHalf));
}

Arm FittedParts::fitted(JointFits::Rows rows) const {
  return fits_->on_torque(from_fitted(parts_), rows, WaveSearch::kNone).arm;
}

void FittedParts::take_all_rows() {
  fitted_ = fitted(JointFits::Rows::kAll);
  leave_out_idle();
}

Arm FittedParts::start_with(Parts parts) {
  parts_ = std::move(parts);
  fits_->take_viscous_of(parts_);
  Arm start = fits_->start(parts_);
  fits_->take_springs_of(start);
  return start;
}

Arm FittedParts::fit(const Arm& start, WaveSearch waves, double smallest_gain) const {
  return fits_->on_torque(start, JointFits::Rows::kTraining, waves, smallest_gain).arm;
}

Arm FittedParts::from_fitted(const Parts& parts) const {
  fits_->take_viscous_of(parts);
  return with_springs_joined(fitted_, carried_over(fitted_, fits_->start(parts)));
}

FittedParts::Parts FittedParts::switched(SumPart part) const {
  Parts out = parts_;
  for (int j = 0; j < fits_->n(); ++j)
    if (fits_->can_show(part, j)) set(out[static_cast<std::size_t>(j)], part, true);
  return out;
}

Arm FittedParts::better_of_each_joint(const Arm& first, const Arm& second,
                                      double smallest_gain) const {
  std::vector<const Arm*> of_joint(static_cast<std::size_t>(fits_->n()), &first);
  for (int j = 0; j < fits_->n(); ++j)
    if (fits_->compare(second, first, j, SumPart::kStribeck).on)
      of_joint[static_cast<std::size_t>(j)] = &second;
  return std::ranges::count(of_joint, &first) == std::ssize(of_joint)
             ? first
             : fit(joined(of_joint, first), WaveSearch::kNone, smallest_gain);
}

bool FittedParts::take(SumPart part, const Arm& with,
                       const std::function<bool(const PartEvidence&)>& earns) {
  int lacking = 0, taken = 0;
  for (int j = 0; j < fits_->n(); ++j) {
    friction::LvmParts& of_joint = parts_[static_cast<std::size_t>(j)];
    if (has(of_joint, part) || !fits_->can_show(part, j)) continue;
    PartEvidence found = fits_->compare(with, fitted_, j, part);
    found.on = earns(found);
    ++lacking;
    taken += found.on;
    set(of_joint, part, found.on);
    note(found);
  }
  if (taken == lacking)
    fitted_ = with;
  else if (taken > 0)
    fitted_ = fit(carried_over(with, from_fitted(parts_)));
  return taken > 0;
}

bool FittedParts::take_together(std::initializer_list<SumPart> tried, const Parts& with,
                                const Arm& both,
                                const std::function<bool(const PartEvidence&)>& earns) {
  const Parts before = parts_;
  for (int j = 0; j < fits_->n(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    if (with[i] == before[i]) continue;
    const PartEvidence found = fits_->compare(both, fitted_, j, *tried.begin());
    if (!earns(found)) continue;
    for (const SumPart taken : tried)
      if (has(with[i], taken) && !has(before[i], taken))
        note({taken, j, found.gain, found.error, true});
    parts_[i] = with[i];
  }
  if (parts_ == before) return false;
  fitted_ = fit(carried_over(both, from_fitted(parts_)));
  return true;
}

void FittedParts::leave_out(SumPart part, const std::function<bool(const PartEvidence&)>& earns) {
  Parts rest = parts_;
  for (friction::LvmParts& of_joint : rest) set(of_joint, part, false);
  if (rest == parts_) return;
  // of two viscous torques the other makes up for the one that goes, slowly; so do many springs
  const bool is_slow = part == SumPart::kViscous || part == SumPart::kEightSprings;
  const double gain = is_slow ? kPartsGain : kRoughGain;
  const Arm without =
      fit(with_parts_handed_over(fitted_, from_fitted(rest)), WaveSearch::kNone, gain);
  // where a joint is far better without, its fit had not found its way: from there once more
  const auto was_lost = [&](int j) {
    const PartEvidence found = fits_->compare(fitted_, without, j, part);
    return found.gain < -std::max(kFarBetter, 2 * found.error);
  };
  const auto joints = std::views::iota(0, fits_->n());
  if (std::ranges::any_of(joints, was_lost)) {
    fits_->take_viscous_of(parts_);
    fitted_ = better_of_each_joint(fitted_, fit(carried_over(without, fits_->start(parts_))));
  }
  const Parts before = parts_;
  for (int j = 0; j < fits_->n(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    if (before[i] == rest[i]) continue;
    PartEvidence found = fits_->compare(fitted_, without, j, part);
    const bool undecided = std::abs(found.gain) < found.error;
    const double rise = fits_->residual_rms(without, j) / fits_->residual_rms(fitted_, j);
    found.on = earns(found) || (undecided && rise * rise - 1 > kTrainingGain);
    note(found);
    if (!found.on) parts_[i] = rest[i];
  }
  if (parts_ == rest)
    fitted_ = without;
  else if (parts_ != before)
    fitted_ = fit(from_fitted(parts_));
}

void FittedParts::leave_out_idle() {
  if (fits_->is_short()) return;
  using enum SumPart;
  fitted_ = with_strongest_waves_first(fitted_);
  for (const SumPart part : {kFurtherModifiers, kLoadedStribeck, kStribeck, kCable, kPowerFlow,
                             kLoadedViscous, kInnerViscous, kViscous, kThirdRipple, kSecondRipple,
                             kRipple, kLoad, kAsymmetry, kTemperature, kBacklash}) {
    Parts rest = parts_;
    for (friction::LvmParts& of_joint : rest) set(of_joint, part, false);
    if (rest == parts_) continue;
    const Arm without = from_fitted(rest);
    for (int j = 0; j < fits_->n(); ++j) {
      const auto i = static_cast<std::size_t>(j);
      if (parts_[i] == rest[i]) continue;
      PartEvidence found = fits_->compare(fitted_, without, j, part);
      const double rise = fits_->residual_rms(without, j) / fits_->residual_rms(fitted_, j);
      if (std::abs(found.gain) > kIdle || std::abs(rise - 1) > kIdle) continue;
      found.on = false;
      note(found);
      parts_[i] = rest[i];
    }
    fitted_ = from_fitted(parts_);
  }
}

bool FittedParts::shows(const Arm& with, SumPart part,
                        const std::function<bool(const PartEvidence&)>& earns) const {
  return std::ranges::any_of(std::views::iota(0, fits_->n()),
                             [&](int j) { return earns(fits_->compare(with, fitted_, j, part)); });
}

bool FittedParts::is_clear(const Arm& with, SumPart part) const {
  double gain = 0, variance = 0;
  for (int j = 0; j < fits_->n(); ++j) {
    const PartEvidence found = fits_->compare(with, fitted_, j, part);
    gain += found.gain;
    variance += found.error * found.error;
  }
  return gain > std::max(kClearGain * fits_->n(), kClearErrors * std::sqrt(variance));
}

std::function<bool(const PartEvidence&)> FittedParts::earning(const Arm& with, SumPart part) const {
  if (!fits_->is_short()) return explains_enough;
  return
      [clear = is_clear(with, part)](const PartEvidence& found) { return clear && found.gain > 0; };
}

void FittedParts::note(const PartEvidence& found) {
  const auto same = std::ranges::find_if(evidence_, [&](const PartEvidence& other) {
    return other.part == found.part && other.joint == found.joint;
  });
  if (same == evidence_.end())
    evidence_.push_back(found);
  else
    *same = found;
}

}  // namespace fricid::estimate
