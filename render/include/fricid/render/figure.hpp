// Figures as data, drawn by the gnuplot program. One look for all of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace fricid::render {

/// One curve. Points with a NaN break the line.
struct Series {
  std::string label;   ///< empty: not in the legend
  std::string colour;  ///< "#rrggbb"
  std::vector<double> x{}, y{};
  double width = 1.2;  ///< [pt]
  bool dashed = false;
  bool markers = false;  ///< line with points
};

/// One pair of axes.
struct Panel {
  std::string title{}, x_label{}, y_label{};
  bool log_x = false, log_y = false;
  std::vector<Series> series{};
};

/// A grid of panels with one legend above them.
struct Figure {
  std::string name;  ///< file stem
  int columns = 3;
  std::vector<Panel> panels{};
  double width_cm = 18, panel_height_cm = 4.2;
};

/// Writes NAME.gp (script with its data, made to be restyled) and NAME.pdf, .svg, .png beside it.
/// @throws UserError when gnuplot is missing or refuses the script; NAME.gp is there all the same
void write_figure(const Figure& figure, const std::filesystem::path& folder);

/// The colour of a model, the same in every figure (Okabe & Ito 2008); truth and oracle are black.
std::string colour_of(const std::string& model, int index);

}  // namespace fricid::render
