// Figures as data, drawn by the gnuplot program. One look for all of them.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace fricid::render {

/// How a series is drawn. kBars: points with a bar from low to high; kBand: the area between low
/// and high; kTiles: a unit square around each point, its colour by `low` from -1 (blue) over 0
/// (white) to 1 (vermilion); kStrokes: straight lines by (low, high).
enum class Mark { kLine, kLinePoints, kPoints, kBars, kBand, kTiles, kStrokes };

/// One curve. Points that are not finite break the line.
struct Series {
  std::string label{};  ///< empty: not in the legend
  std::string colour = "#000000";
  std::vector<double> x{}, y{};
  double width = 1.2;  ///< [pt]
  int dash = 1;        ///< 1 solid, 2 dashed, 3 dotted, 4 dash-dot
  Mark mark = Mark::kLine;
  int marker = 7;                     ///< gnuplot point type
  std::vector<double> low{}, high{};  ///< as the mark reads them
};

/// Closed interval of an axis; NaN: from the data.
struct Range {
  double low, high;
};
inline constexpr Range kFromData{std::numeric_limits<double>::quiet_NaN(),
                                 std::numeric_limits<double>::quiet_NaN()};

/// One pair of axes.
struct Panel {
  std::string title{}, x_label{}, y_label{};
  bool log_x = false, log_y = false;
  std::vector<Series> series{};
  Range x_range = kFromData, y_range = kFromData;
  bool fit_x = false;  ///< without a range: the axis ends at the data; false: at a tic
  std::vector<std::pair<double, std::string>> x_tics{},
      y_tics{};  ///< position and label; empty: numbers
};

/// A grid of panels with one legend above them.
struct Figure {
  std::string name;       ///< file stem
  std::string caption{};  ///< one or two sentences for the report
  int columns = 3;        ///< at most
  std::vector<Panel> panels{};
  double width_cm = 18, panel_height_cm = 4.2;
  double left_cm = 1.55;  ///< room for the labels of the vertical axis
};

inline constexpr double kColumnCm = 8.8;  ///< width of one column of a journal page

/// The gnuplot script with its data, made to be restyled. Lines are thinned to visible detail: a
/// point is kept when it lies more than 0.06 % of the panel off the line through its neighbours
/// (Ramer 1972; Douglas & Peucker 1973).
std::string script_of(const Figure& figure);

/// Writes NAME.gp and runs gnuplot on it, which makes NAME.pdf, .svg and .png beside it.
/// @return these files
/// @throws UserError when gnuplot is missing, refuses the script, was killed, or could not write
///         all of a picture; NAME.gp is written all the same. Stopped after Ctrl-C
std::vector<std::filesystem::path> write_figure(const Figure& figure,
                                                const std::filesystem::path& folder);

}  // namespace fricid::render
