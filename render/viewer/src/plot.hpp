#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "fricid/film/chart.hpp"

namespace fricid::viewer {

struct Line {
  std::vector<double> x, y;
  std::string colour;  ///< "#rrggbb"
  float width = 1.5f;
  bool dots = false;  ///< a dot of diameter `width` at each point in place of the line
};

/// Axes and lines in a box of the screen; the end of each line gets a dot.
void draw_plot(const ImVec2& from, const ImVec2& size, const std::string& title,
               const film::Axis& x, const film::Axis& y, const std::vector<Line>& lines);

ImU32 colour_of(const std::string& colour);

}  // namespace fricid::viewer
