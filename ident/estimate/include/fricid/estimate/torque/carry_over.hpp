// From one arm to another: what a fit begins with that another has found.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "fricid/estimate/torque/cable.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// Where stiffness and cap of a spring are in theta.
struct SpringIndices {
  std::size_t K, W;
};

/// The maxwell_slip of one spring of a joint, which may be a cable; nothing where it has none.
std::optional<SpringIndices> single_spring(const friction::RobotFriction& friction, int joint);

/// Single springs begin as cables where there are some (K > 0).
/// @return whether any does
bool start_cables(std::span<const Cable> cables, friction::Friction& friction);

/// A single spring that is stiffer than the bristle beside it has taken its place: they change
/// places. Nothing where there is none.
std::optional<Arm> with_springs_in_place(Arm arm);

/// `to` with the Stribeck curve of each joint's first law that `from` has there, whatever the laws;
/// with that of the Stribeck torque beside it where `to` has none.
Arm with_stribeck_curves(const Arm& from, Arm to);

/// The same; laws without memory begin anew where the curve falls towards rest, which stands for
/// the smoothing speed of a law that is not fitted yet.
Arm with_curves_without_memory(const Arm& from, Arm to);

/// Stribeck curves of first laws without memory that fall towards rest begin anew: they stand for a
/// smoothing speed that is too small. They begin wider than those of `unfitted`. Nothing where
/// there are none.
std::optional<Arm> with_rising_curves(Arm arm, Arm unfitted);

/// Joints with a Stribeck torque beside their memory have that of the memory there, and none in it.
Arm with_stribeck_beside(Arm arm);

/// A narrow Stribeck curve in the memories that have none, or one as wide as the Stribeck torque
/// beside them: from there its speed has no gradient. Nothing where there is no such joint.
std::optional<Arm> with_curves_in_memories(Arm arm);

/// `to` with the bank of springs of `from` in joints where it has fewer of them: springs that slip
/// at about the same travel are one, of their stiffness and force together.
Arm with_springs_joined(const Arm& from, Arm to);

/// `to` with the growth of the memory's friction with load that `from` has, whatever the load is.
Arm with_load_growth(const Arm& from, Arm to);

/// `to` with what stands for parts of `from` that it lacks: the mean of the power flow in the
/// growth of the memory's friction with load, and linear viscous friction beside a power law that
/// is linear, in that.
Arm with_parts_handed_over(const Arm& from, Arm to);

/// `to` with the linear viscous friction of `from`, both sums of the lvm: beside the memory or in
/// it.
Arm with_viscous_friction(const Arm& from, Arm to);

/// Gaps are at least `half` wide to either side [rad], a tenth of it [m] in joints that slide.
Arm with_open_gaps(Arm arm, double half);

/// The waves over the joint angle of each joint of `lvm_sum` in the order of their amplitudes.
Arm with_strongest_waves_first(Arm arm);

/// The friction of each joint from one arm of several, and the rigid body of `first`.
Arm joined(const std::vector<const Arm*>& of_joint, const Arm& first);

/// `to` with the parameters of friction that `from` has too, by joint, law and name; and its rigid
/// body.
Arm carried_over(const Arm& from, Arm to);

/// Index in theta of the linear viscous friction of a joint of `lvm_sum`: beside its memory or in
/// it; -1: there is none.
int linear_viscous(const friction::RobotFriction& model, int joint);

}  // namespace fricid::estimate
