// Joints that a scene takes out of its robot.
#pragma once

#include <filesystem>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/scene/scene.hpp"

namespace fricid::scene {

/// Joints that are fixed or held; what is held and not yet fixed, anywhere.
dynamics::Welds welds_of(const Scene& scene);

/// Fixes every held joint where the first training log has it: at the median of its positions.
/// @throws UserError when there is no such log or it lacks the joint
void fix_held_joints(Scene& scene, const std::filesystem::path& contract,
                     const std::filesystem::path& folder);

}  // namespace fricid::scene
