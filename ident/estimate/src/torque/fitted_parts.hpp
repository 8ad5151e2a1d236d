// What of a trial fit the joints of a sum keep.
#pragma once

#include <functional>
#include <initializer_list>
#include <vector>

#include "fricid/estimate/torque/joint_fit.hpp"

namespace fricid::estimate {

/// Rules for a part to stay in a joint. On held-out torque it gains more than its standard error.
bool explains(const PartEvidence& part);
/// What was picked from many, a wave by its order or a cable by its length, has to gain more than
/// by chance.
bool explains_enough(const PartEvidence& part);

/// A sum on the training rows with the parts that its joints have by now, and the steps by which a
/// search changes them: fit with other parts, compare on held-out torque, keep what earns its
/// place.
class FittedParts {
 public:
  using Parts = std::vector<friction::LvmParts>;

  const Parts& parts() const { return parts_; }
  const std::vector<PartEvidence>& evidence() const { return evidence_; }
  const Arm& fitted() const { return fitted_; }
  /// With these parts, from there, to other rows.
  Arm fitted(JointFits::Rows rows) const;
  /// From now on fitted to all rows, without the parts that say nothing there.
  void take_all_rows();

 protected:
  explicit FittedParts(JointFits& fits) : fits_(&fits) {}

  /// @return the start of a fit with these parts, which are now those of the choice
  Arm start_with(Parts parts);
  /// On the training rows.
  Arm fit(const Arm& start, WaveSearch waves = WaveSearch::kNone,
          double smallest_gain = kPartsGain) const;
  /// The start of a fit with other parts, which has what was found.
  Arm from_fitted(const Parts& parts) const;
  /// The parts with another one in every joint that can show it.
  Parts switched(friction::SumPart part) const;
  /// Of two fits with the same parts: `first`, with the friction of `second` in the joints where
  /// that explains more.
  Arm better_of_each_joint(const Arm& first, const Arm& second,
                           double smallest_gain = kPartsGain) const;
  /// Joints without the part keep what `with` has of it where it earns its place.
  /// @return whether any does
  bool take(friction::SumPart part, const Arm& with,
            const std::function<bool(const PartEvidence&)>& earns);
  /// Joints in which `with` has other parts than now keep them where these together earn their
  /// place. @return whether any does
  bool take_together(std::initializer_list<friction::SumPart> tried, const Parts& with,
                     const Arm& both, const std::function<bool(const PartEvidence&)>& earns);
  /// A joint keeps the part where a fit in which no joint has it is worse: on held-out rows or,
  /// where these do not tell, on those it was fitted to.
  void leave_out(friction::SumPart part,
                 const std::function<bool(const PartEvidence&)>& earns = explains);
  /// Parts go without which the torque is what it is, a wave without amplitude or a load without
  /// growth: what they gained was of another fit. None on short logs.
  void leave_out_idle();
  /// Whether any joint shows `part` of `with`.
  bool shows(const Arm& with, friction::SumPart part,
             const std::function<bool(const PartEvidence&)>& earns = explains) const;
  /// Whether all joints together show what `with` has, clearly.
  bool is_clear(const Arm& with, friction::SumPart part) const;
  /// What a part of `with` has to gain in a joint. A few seconds of one joint are no proof, those
  /// of all joints may be: then it has to gain anything.
  std::function<bool(const PartEvidence&)> earning(const Arm& with, friction::SumPart part) const;
  /// The last evidence of a part in a joint counts.
  void note(const PartEvidence& found);

  JointFits* fits_;
  Parts parts_;
  std::vector<PartEvidence> evidence_;
  Arm fitted_;
};

}  // namespace fricid::estimate
