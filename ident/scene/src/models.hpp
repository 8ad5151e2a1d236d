#pragma once

#include "fricid/scene/scene.hpp"

namespace fricid::scene {

/// Checks [[model]] and fills in what its keys leave open: law, method, label; seeds sorted, each
/// once.
/// @throws UserError naming the key
void complete_models(Scene& scene);

}  // namespace fricid::scene
