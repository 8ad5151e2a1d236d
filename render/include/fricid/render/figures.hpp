#pragma once

#include <vector>

#include "fricid/render/figure.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::render {

/// The figures of a run folder, made from its files only. First seed and first held-out trajectory:
///
///     error_horizon      geometric mean of MSE(q) against horizon, with oracle, floor, intervals
///     error_time         mean absolute position error of the open loops against time
///     error_joint        error of each joint, with the spread over rollouts
///     tracking           measured position and each model's open loop, per joint
///     friction_JOINT     friction torque against velocity, one panel per model, with truth
///     presliding         torque against displacement around an outer and an inner loop
///     reversal           friction torque around each joint's slowest reversal
///     friction_time, friction_error     against time, with bands of the online filter
///     latent             hidden states
///     parameters, training, em, filter_health, residual_spectrum    quality of the fits
///     excitation, margins               what the training motion covers
///     compensation, compensation_time   closed loops with the models' friction fed forward
///     contact, contact_threshold        external torque under pushes, and what is noticed
///     torque_MODEL       measured and predicted motor torque and their difference, per joint
///
/// A figure whose files are absent (no truth, no rollout) is left out.
/// @throws UserError when evaluation.json is missing, or a file is damaged
std::vector<Figure> figures_of_run(const workflow::RunFolder& folder);

}  // namespace fricid::render
