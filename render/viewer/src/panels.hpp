#pragma once

#include <imgui.h>

#include "stage.hpp"

namespace fricid::viewer {

/// Requests of the user in this frame that the window must handle.
struct Wishes {
  bool still = false;  ///< save the picture
  bool scene = false;  ///< save the scene with the friction as it is
};

/// Size of the picture of the arm in a window of this size.
ImVec2 picture_size(float width, float height);

/// All panels around the picture of the arm: transport, models, friction parameters, plots. Changes
/// `stage` by the user's input.
Wishes draw_panels(Stage& stage, ImTextureID picture, float width, float height);

}  // namespace fricid::viewer
