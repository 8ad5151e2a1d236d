#include "figure_script.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "fricid/render/simplify.hpp"
#include "gnuplot.hpp"

namespace fricid::render {
namespace {

using gnuplot::string_of, gnuplot::Script;

constexpr double kRightCm = 0.3, kTitleCm = 0.55, kBottomCm = 1.15, kLabelCm = 0.3;
constexpr double kLegendRowCm = 0.42, kLegendPadCm = 0.3, kLetterCm = 0.155, kSampleCm = 1.5;
constexpr double kTolerance = 6e-4;  // of a panel's width or height

Script style() {
  return Script::of(R"(reset
set encoding utf8
set border 3 lw 0.6
set tics nomirror out scale 0.5
set grid lt 1 lw 0.4 lc rgb "#dddddd"
set datafile missing "nan"
set title offset 0,-0.6
set xlabel offset 0,0.4
set bars 0.4
set palette defined (-1 "#0072B2", 0 "#ffffff", 1 "#D55E00")
set cbrange [-1:1]
unset colorbox
)");
}

Script dashes(int dash) {
  return dash <= 1   ? Script::of("1")
         : dash == 2 ? Script::of("(9,4)")
         : dash == 3 ? Script::of("(3,3)")
                     : Script::of("(9,4,3,4)");
}

Script style_of(const Series& series) {
  const Script colour = string_of(series.colour);
  const Script line =
      Script::of("lw {} lc rgb {} dt {}", series.width, colour, dashes(series.dash));
  const Script points =
      Script::of("pt {} ps {}", series.marker, series.mark == Mark::kLinePoints ? 0.55 : 0.7);
  switch (series.mark) {
    case Mark::kLine:
      return Script::of("with lines {}", line);
    case Mark::kLinePoints:
      return Script::of("with linespoints {} {}", line, points);
    case Mark::kPoints:
      return Script::of("with points {} {}", line, points);
    case Mark::kBars:
      return Script::of("with yerrorbars {} {}", line, points);
    case Mark::kBand:
      return Script::of("with filledcurves fs transparent solid 0.22 noborder lc rgb {}", colour);
    case Mark::kTiles:
      return Script::of("with boxxyerror fs solid 1 noborder lc palette");
    case Mark::kStrokes:
      return Script::of("with vectors nohead {}", line);
  }
  return {};
}

Script columns_of(Mark mark) {
  switch (mark) {
    case Mark::kBars:
    case Mark::kStrokes:
      return Script::of("1:2:3:4");
    case Mark::kBand:
      return Script::of("1:2:3");
    case Mark::kTiles:
      return Script::of("1:2:(0.5):(0.5):3");
    default:
      return Script::of("1:2");
  }
}

/// Labels in order of first appearance, with the style they have there.
std::vector<const Series*> legend_of(const Figure& figure) {
  std::vector<const Series*> legend;
  for (const Panel& panel : figure.panels)
    for (const Series& series : panel.series)
      if (!series.label.empty() &&
          std::none_of(legend.begin(), legend.end(),
                       [&](const Series* known) { return known->label == series.label; }))
        legend.push_back(&series);
  return legend;
}

struct Layout {
  double width, height, legend;  ///< [cm]
};

/// Height of the legend: its columns are as wide as the longest label.
double legend_height(const Figure& figure) {
  const auto legend = legend_of(figure);
  if (legend.empty()) return 0.1;
  std::size_t longest = 1;
  for (const Series* series : legend) longest = std::max(longest, series->label.size());
  const double column = kSampleCm + kLetterCm * static_cast<double>(longest);
  const int columns = std::max(1, static_cast<int>(figure.width_cm / column));
  const int rows = (static_cast<int>(legend.size()) + columns - 1) / columns;
  return kLegendPadCm + kLegendRowCm * rows;
}

int columns_of(const Figure& figure) {
  return std::clamp(static_cast<int>(figure.panels.size()), 1, figure.columns);
}

/// Whether the labels of a panel's horizontal axis fit side by side.
bool names_fit(const Figure& figure, const Panel& panel) {
  std::size_t letters = 0;
  for (const auto& [place, name] : panel.x_tics) letters += name.size() + 1;
  return kLetterCm * static_cast<double>(letters) <
         figure.width_cm / columns_of(figure) - figure.left_cm - kRightCm;
}

/// Room below a panel, including upright labels.
double bottom_cm(const Figure& figure) {
  double room = kBottomCm;
  for (const Panel& panel : figure.panels)
    if (!names_fit(figure, panel))
      for (const auto& [place, name] : panel.x_tics)
        room = std::max(room, kLabelCm + kLetterCm * static_cast<double>(name.size() + 1));
  return room;
}

Layout layout_of(const Figure& figure) {
  const int columns = columns_of(figure);
  const int rows = (static_cast<int>(figure.panels.size()) + columns - 1) / columns;
  const double legend = legend_height(figure);
  return {figure.width_cm, legend + rows * (figure.panel_height_cm + kTitleCm + bottom_cm(figure)),
          legend};
}

/// One axis, in shares of the range of its data.
class Axis {
 public:
  Axis(const Panel& panel, std::vector<double> Series::*values, bool log, Range range) : log_(log) {
    for (const Series& series : panel.series)
      for (const double value : series.*values)
        if (const double at = place(value); std::isfinite(at)) {
          low_ = std::min(low_, at);
          high_ = std::max(high_, at);
        }
    if (std::isfinite(range.low)) low_ = place(range.low);
    if (std::isfinite(range.high)) high_ = place(range.high);
  }
  /// Length of the data's range; 0 without data.
  double span() const { return high_ > low_ ? high_ - low_ : 0; }
  /// Range of the data. @pre the axis is not logarithmic
  Range range() const { return {low_, high_}; }
  double share(double value) const {
    return high_ > low_ ? (place(value) - low_) / (high_ - low_) : place(value) - low_;
  }

 private:
  double place(double value) const { return log_ ? std::log10(value) : value; }
  bool log_;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -low_;
};

/// Distance between tics that leaves about five of them: 1, 2 or 5 times a power of ten.
double tic_step(double span) {
  const double raw = span / 5, decade = std::pow(10, std::floor(std::log10(raw)));
  return decade * (raw <= decade ? 1 : raw <= 2 * decade ? 2 : raw <= 5 * decade ? 5 : 10);
}

Script number(double value) { return Script::of("{:.6g}", value); }

/// The points of a simplified line, with an empty line where it breaks.
Script line_data(const Series& series, const Axis& x_axis, const Axis& y_axis) {
  Script text;
  std::vector<double> x, y;
  std::size_t begin = 0;
  const auto flush = [&] {
    for (const std::size_t k : simplified(x, y, kTolerance))
      text += Script::of("{:.6g} {:.6g}\n", series.x[begin + k], series.y[begin + k]);
    x.clear();
    y.clear();
  };
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double px = x_axis.share(series.x[i]), py = y_axis.share(series.y[i]);
    if (std::isfinite(px) && std::isfinite(py)) {
      if (x.empty()) begin = i;
      x.push_back(px);
      y.push_back(py);
      continue;
    }
    flush();
    text += Script::of("\n");
  }
  flush();
  return text;
}

Script series_data(const Series& series, const Axis& x_axis, const Axis& y_axis) {
  if (series.mark == Mark::kLine) return line_data(series, x_axis, y_axis);
  Script text;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    std::vector<double> row{series.x[i]};
    if (series.mark != Mark::kBand) row.push_back(series.y[i]);
    if (!series.low.empty()) row.push_back(series.low[i]);
    if (!series.high.empty()) row.push_back(series.high[i]);
    const bool drawn =
        std::all_of(row.begin(), row.end(), [](double v) { return std::isfinite(v); });
    if (drawn)
      for (const double value : row) text += Script::of("{:.6g} ", value);
    text += Script::of("\n");
  }
  return text;
}

/// Whether any point of a series is drawn.
bool has_points(const Series& series) {
  const auto known = [](const std::vector<double>& values, std::size_t i) {
    return i >= values.size() || std::isfinite(values[i]);
  };
  for (std::size_t i = 0; i < series.x.size(); ++i)
    if (std::isfinite(series.x[i]) && known(series.y, i) && known(series.low, i) &&
        known(series.high, i))
      return true;
  return false;
}

Script data_blocks(const Figure& figure) {
  Script text;
  for (std::size_t p = 0; p < figure.panels.size(); ++p) {
    const Panel& panel = figure.panels[p];
    const Axis x_axis(panel, &Series::x, panel.log_x, panel.x_range);
    const Axis y_axis(panel, &Series::y, panel.log_y, panel.y_range);
    for (std::size_t s = 0; s < panel.series.size(); ++s)
      text +=
          Script::of("$d{}_{} << EOD\n{}EOD\n", p, s, series_data(panel.series[s], x_axis, y_axis));
  }
  return text;
}

/// Separator before each item of a list but the first.
Script separator(bool first, const Script& between) { return first ? Script() : between; }

/// @param span  range of the data, for tics with room for their numbers; 0: gnuplot's tics
Script axis_text(char name, bool log, Range range,
                 const std::vector<std::pair<double, std::string>>& tics, double span,
                 bool upright = true) {
  const auto bound = [](double value) {
    return std::isfinite(value) ? number(value) : Script::of("*");
  };
  Script text = log ? Script::of("set logscale {0}\nset format {0} '10^{{%L}}'\n", name)
                    : Script::of("unset logscale {0}\nset format {0} '%g'\n", name);
  text += Script::of("set {}range [{}:{}] noreverse\n", name, bound(range.low), bound(range.high));
  if (tics.empty() && !log && span > 0)
    return text + Script::of("set {}tics norotate {}\n", name, number(tic_step(span)));
  if (tics.empty()) return text + Script::of("set {}tics norotate autofreq\n", name);
  text +=
      Script::of("set {}tics {} noenhanced (", name,
                 upright ? Script::of("norotate autojustify") : Script::of("rotate by 90 right"));
  for (std::size_t i = 0; i < tics.size(); ++i)
    text += Script::of("{}{} {}", separator(i == 0, Script::of(", ")), gnuplot::tic(tics[i].second),
                       number(tics[i].first));
  return text + Script::of(")\n");
}

Script next_plot() { return Script::of(", \\\n     "); }

/// Without a number to draw gnuplot refuses to choose a range: an empty frame.
Script empty_plot() {
  return Script::of("unset logscale\nset xrange [0:1]\nset yrange [0:1]\nplot NaN notitle\n");
}

Script plots_text(const Panel& panel, std::size_t p) {
  Script text = Script::of("plot ");
  bool first = true;
  for (std::size_t s = 0; s < panel.series.size(); ++s) {
    const Series& series = panel.series[s];
    if (series.x.empty()) continue;
    text += Script::of("{}$d{}_{} using {} {} notitle", separator(first, next_plot()), p, s,
                       columns_of(series.mark), style_of(series));
    first = false;
  }
  return text + Script::of("\n");
}

Script panel_text(const Figure& figure, std::size_t p, Layout layout) {
  const Panel& panel = figure.panels[p];
  const int columns = columns_of(figure);
  const auto row = static_cast<int>(p) / columns, column = static_cast<int>(p) % columns;
  const double cell = figure.width_cm / columns;
  const double top =
      layout.legend + row * (figure.panel_height_cm + kTitleCm + bottom_cm(figure)) + kTitleCm;

  Script text = Script::of(
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset tmargin at screen {:.5f}\n"
      "set bmargin at screen {:.5f}\n",
      (column * cell + figure.left_cm) / layout.width,
      ((column + 1) * cell - kRightCm) / layout.width, 1 - top / layout.height,
      1 - (top + figure.panel_height_cm) / layout.height);
  text += Script::of(
      "set title {} noenhanced\nset xlabel {} noenhanced\n"
      "set label 1 {} at screen {:.5f}, graph 0.5 center rotate noenhanced\n",
      string_of(panel.title), string_of(panel.x_label), string_of(panel.y_label),
      (column * cell + kLabelCm) / layout.width);
  const Axis x_axis(panel, &Series::x, panel.log_x, panel.x_range);
  const bool is_empty = std::ranges::none_of(panel.series, has_points);
  const double span = x_axis.span();
  const Range x_range = panel.fit_x && span > 0 ? x_axis.range() : panel.x_range;
  return text + axis_text('x', panel.log_x, x_range, panel.x_tics, span, names_fit(figure, panel)) +
         axis_text('y', panel.log_y, panel.y_range, panel.y_tics, 0) +
         (is_empty ? empty_plot() : plots_text(panel, p));
}

Script legend_text(const Figure& figure, Layout layout) {
  const auto legend = legend_of(figure);
  if (legend.empty()) return {};
  Script text = Script::of(
      "set lmargin at screen 0\nset rmargin at screen 1\nset tmargin at screen 1\n"
      "set bmargin at screen {:.5f}\nunset border\nunset tics\nunset grid\nunset title\n"
      "unset xlabel\nunset label\nunset logscale\n"
      "set key center center horizontal samplen 2 width 1\n"
      "set xrange [0:1]\nset yrange [0:1]\nplot ",
      1 - layout.legend / layout.height);
  for (std::size_t i = 0; i < legend.size(); ++i)
    text += Script::of("{}NaN {} title {} noenhanced", separator(i == 0, next_plot()),
                       style_of(*legend[i]), string_of(legend[i]->label));
  return text + Script::of("\n");
}

}  // namespace

FigureSize size_of(const Figure& figure) {
  const Layout layout = layout_of(figure);
  return {layout.width, layout.height};
}

std::string script_of(const Figure& figure) {
  const Layout layout = layout_of(figure);
  Script text = gnuplot::comment(figure.caption);
  text += gnuplot::comment(
      fmt::format("gnuplot -e \"set terminal pdfcairo size {:.2f}cm,{:.2f}cm; set output "
                  "'{}.pdf'\" {}.gp",
                  layout.width, layout.height, figure.name, figure.name));
  text += style();
  text += data_blocks(figure);
  text += Script::of("set multiplot\nunset key\n");
  for (std::size_t p = 0; p < figure.panels.size(); ++p) text += panel_text(figure, p, layout);
  text += legend_text(figure, layout) + Script::of("unset multiplot\n");
  return text.text();
}

}  // namespace fricid::render
