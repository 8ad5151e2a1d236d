#include "fricid/render/figure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"

namespace fricid::render {
namespace {

constexpr double kLeftCm = 1.55, kRightCm = 0.25, kTitleCm = 0.55, kBottomCm = 1.15;
constexpr double kLegendRowCm = 0.45, kLegendPadCm = 0.35, kLetterCm = 0.16, kSampleCm = 1.7;

constexpr std::string_view kStyle = R"(set encoding utf8
set border 3 lw 0.6
set tics nomirror out scale 0.5
set grid lt 1 lw 0.4 lc rgb "#dddddd"
set datafile missing "nan"
set title offset 0,-0.6
set xlabel offset 0,0.4
set ylabel offset 1.2,0
)";

std::string quoted(std::string text) {
  for (char& c : text)
    if (c == '\'' || c == '\n') c = ' ';
  return "'" + text + "'";
}

std::string style_of(const Series& series) {
  return fmt::format("with {} lw {} lc rgb '{}'{}{}", series.markers ? "linespoints" : "lines",
                     series.width, series.colour, series.dashed ? " dt (6,4)" : " dt 1",
                     series.markers ? " pt 7 ps 0.35" : "");
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

struct Size {
  double width, height, legend;  ///< [cm]
};

/// Height of the legend: its columns are as wide as the longest label.
double legend_height(const Figure& figure) {
  const auto legend = legend_of(figure);
  std::size_t longest = 1;
  for (const Series* series : legend) longest = std::max(longest, series->label.size());
  const double column = kSampleCm + kLetterCm * static_cast<double>(longest);
  const int columns = std::max(1, static_cast<int>(figure.width_cm / column));
  const int rows = (static_cast<int>(legend.size()) + columns - 1) / columns;
  return kLegendPadCm + kLegendRowCm * rows;
}

Size size_of(const Figure& figure) {
  const int rows = (static_cast<int>(figure.panels.size()) + figure.columns - 1) / figure.columns;
  const double legend = legend_height(figure);
  return {figure.width_cm, legend + rows * (figure.panel_height_cm + kTitleCm + kBottomCm), legend};
}

std::string data_blocks(const Figure& figure) {
  std::string text;
  for (std::size_t p = 0; p < figure.panels.size(); ++p)
    for (std::size_t s = 0; s < figure.panels[p].series.size(); ++s) {
      const Series& series = figure.panels[p].series[s];
      text += fmt::format("$d{}_{} << EOD\n", p, s);
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        const bool drawn = std::isfinite(series.x[i]) && std::isfinite(series.y[i]);
        text += drawn ? fmt::format("{:.6g} {:.6g}\n", series.x[i], series.y[i]) : "\n";
      }
      text += "EOD\n";
    }
  return text;
}

std::string panel_text(const Figure& figure, std::size_t p, Size size) {
  const Panel& panel = figure.panels[p];
  const auto row = static_cast<int>(p) / figure.columns,
             column = static_cast<int>(p) % figure.columns;
  const double cell = figure.width_cm / figure.columns;
  const double top = size.legend + row * (figure.panel_height_cm + kTitleCm + kBottomCm) + kTitleCm;

  std::string text = fmt::format(
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset tmargin at screen {:.5f}\n"
      "set bmargin at screen {:.5f}\n",
      (column * cell + kLeftCm) / size.width, ((column + 1) * cell - kRightCm) / size.width,
      1 - top / size.height, 1 - (top + figure.panel_height_cm) / size.height);
  text +=
      fmt::format("set title {} noenhanced\nset xlabel {} noenhanced\nset ylabel {} noenhanced\n",
                  quoted(panel.title), quoted(panel.x_label), quoted(panel.y_label));
  const auto axis = [](bool log, char name) {
    return log ? fmt::format("set logscale {0}\nset format {0} '10^{{%L}}'\n", name)
               : fmt::format("unset logscale {0}\nset format {0} '%g'\n", name);
  };
  text += axis(panel.log_x, 'x') + axis(panel.log_y, 'y') + "plot ";
  for (std::size_t s = 0; s < panel.series.size(); ++s)
    text += fmt::format("{}$d{}_{} using 1:2 {} notitle", s == 0 ? "" : ", \\\n     ", p, s,
                        style_of(panel.series[s]));
  return text + (panel.series.empty() ? "NaN notitle\n" : "\n");
}

std::string legend_text(const Figure& figure, Size size) {
  const auto legend = legend_of(figure);
  if (legend.empty()) return {};
  std::string text = fmt::format(
      "set lmargin at screen 0\nset rmargin at screen 1\nset tmargin at screen 1\n"
      "set bmargin at screen {:.5f}\nunset border\nunset tics\nunset grid\nunset title\nunset "
      "xlabel\n"
      "unset ylabel\nunset logscale\nset key center center horizontal samplen 2 width 1\n"
      "set xrange [0:1]\nset yrange [0:1]\nplot ",
      1 - size.legend / size.height);
  for (std::size_t i = 0; i < legend.size(); ++i)
    text += fmt::format("{}NaN {} title {} noenhanced", i == 0 ? "" : ", \\\n     ",
                        style_of(*legend[i]), quoted(legend[i]->label));
  return text + "\n";
}

std::string script_of(const Figure& figure) {
  const Size size = size_of(figure);
  std::string text = fmt::format(
      "# gnuplot -e \"set terminal pdfcairo size {:.2f}cm,{:.2f}cm; set output '{}.pdf'\" {}.gp\n",
      size.width, size.height, figure.name, figure.name);
  text += kStyle;
  text += data_blocks(figure);
  text += "set multiplot\nunset key\n";
  for (std::size_t p = 0; p < figure.panels.size(); ++p) text += panel_text(figure, p, size);
  text += legend_text(figure, size) + "unset multiplot\n";
  return text;
}

}  // namespace

void write_figure(const Figure& figure, const std::filesystem::path& folder) {
  const auto script = folder / (figure.name + ".gp");
  write_file_atomically(script, script_of(figure));
  if (std::system("command -v gnuplot >/dev/null 2>&1") != 0)
    throw UserError(
        "gnuplot is missing: {} was written, its pictures were not; install gnuplot-nox",
        script.string());

  const Size size = size_of(figure);
  struct Terminal {
    std::string extension, settings;
  };
  const std::array<Terminal, 3> terminals{{
      {"pdf", fmt::format("pdfcairo size {:.2f}cm,{:.2f}cm font 'DejaVu Sans,7'", size.width,
                          size.height)},
      {"svg", fmt::format("svg size {:.0f},{:.0f} font 'DejaVu Sans,9'", size.width * 38,
                          size.height * 38)},
      {"png", fmt::format("pngcairo size {:.0f},{:.0f} font 'DejaVu Sans,15' linewidth 2",
                          size.width * 80, size.height * 80)},
  }};
  for (const Terminal& terminal : terminals)
    write_file_atomically(
        folder / (figure.name + "." + terminal.extension), [&](const std::filesystem::path& part) {
          const std::string command =
              fmt::format("gnuplot -e \"set terminal {}; set output '{}'\" '{}' 2>/dev/null",
                          terminal.settings, part.string(), script.string());
          if (std::system(command.c_str()) != 0)
            throw UserError("{}: gnuplot refused the script; run it by hand to see why",
                            script.string());
        });
}

std::string colour_of(const std::string& model, int index) {
  static const std::array<std::pair<std::string_view, std::string_view>, 8> kNamed{{
      {"oracle", "#000000"},
      {"truth", "#000000"},
      {"simple", "#CC79A7"},
      {"stribeck", "#E69F00"},
      {"dahl", "#56B4E9"},
      {"lugre", "#009E73"},
      {"gms", "#D55E00"},
      {"lvm", "#0072B2"},
  }};
  for (const auto& [name, colour] : kNamed)
    if (name == model) return std::string(colour);
  static constexpr std::array<std::string_view, 4> kOthers{"#F0E442", "#8B4513", "#4B0082",
                                                           "#708090"};
  return std::string(kOthers[static_cast<std::size_t>(index) % kOthers.size()]);
}

}  // namespace fricid::render
