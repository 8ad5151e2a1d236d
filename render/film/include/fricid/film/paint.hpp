#pragma once

#include <string>

namespace fricid::film {

/// Colour and opacity, each in [0, 1].
struct Paint {
  float red = 0, green = 0, blue = 0, alpha = 1;
};

/// "#rrggbb" with an opacity. @throws UserError on another form
Paint paint_of(const std::string& colour, float alpha = 1);

}  // namespace fricid::film
