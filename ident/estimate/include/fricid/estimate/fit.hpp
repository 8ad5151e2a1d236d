// Fits of models by any method.
#pragma once

#include "fricid/estimate/conventional.hpp"
#include "fricid/estimate/fit_report.hpp"
#include "fricid/estimate/prepared.hpp"
#include "fricid/optimise/checkpoint.hpp"

namespace fricid::estimate {

/// Fits one model by its method. Method joint fits friction and rigid body to the torque at once
/// (`JointFits`) and continues from there by windows; of model lvm, there are several candidates,
/// strong conventional laws among them, and held-out rollouts choose. Every other method starts
/// from the conventional fit of its law; learned laws start from that of dahl, their networks from
/// random weights so small that their torque is negligible. Laws of the whole robot start from
/// random weights and the rigid body of the conventional fit of coulomb_viscous, and are trained by
/// method torque before windows. Methods multi_step and em choose the iteration with the best
/// held-out rollouts, the start included; method torque that with the least held-out torque error.
/// @param checkpoint  of method em, which saves its state there and continues from it
/// @throws as fit_conventional
FitReport fit_model(ConventionalFits& conventional, const ModelOptions& options, int seed, int jobs,
                    const optimise::Checkpoint& checkpoint = {});

}  // namespace fricid::estimate
