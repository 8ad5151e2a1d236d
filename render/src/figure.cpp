#include "fricid/render/figure.hpp"

#include <array>
#include <cstring>
#include <string_view>
#include <system_error>

#include "figure_script.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/progress.hpp"
#include "gnuplot.hpp"
#include "letters.hpp"
#include "program.hpp"

namespace fricid::render {
namespace {

namespace fs = std::filesystem;
using gnuplot::Script;

struct Picture {
  std::string_view extension;
  gnuplot::Script terminal;
  std::string_view ending;  ///< how a whole file ends, blank space aside
  bool keeps_text = false;  ///< which is drawn by the fonts of who looks at it
};

std::array<Picture, 3> pictures_of(const Figure& figure) {
  const auto [width, height] = size_of(figure);
  constexpr double kSvgPerCm = 38, kPngPerCm = 80;
  return {
      {{".pdf", Script::of("pdfcairo size {:.2f}cm,{:.2f}cm font 'DejaVu Sans,7'", width, height),
        "%%EOF"},
       {".svg",
        Script::of("svg size {:.0f},{:.0f} font 'DejaVu Sans,9' linewidth 0.9", width * kSvgPerCm,
                   height * kSvgPerCm),
        "</svg>", true},
       {".png",
        Script::of("pngcairo size {:.0f},{:.0f} font 'DejaVu Sans,15' linewidth 2",
                   width * kPngPerCm, height * kPngPerCm),
        std::string_view("IEND\xae\x42\x60\x82")}}};
}

/// The line of gnuplot's output that states the error.
std::string first_complaint(const std::string& errors) {
  const std::size_t at = errors.find("line ");
  const std::string tail = at == std::string::npos ? errors : errors.substr(at);
  return tail.substr(0, tail.find('\n'));
}

void check_whole(const fs::path& part, std::string_view ending, const fs::path& file) {
  std::string text = read_file(part);
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  if (!text.ends_with(ending))
    throw UserError("{}: gnuplot could not write all of it; is the disk full", file.string());
}

/// @param shown  the script of pictures whose text is drawn here
void draw(const Figure& figure, const fs::path& script, const fs::path& shown,
          const std::array<fs::path, 3>& files) {
  const auto pictures = pictures_of(figure);
  Script commands;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    commands +=
        Script::of("set terminal {}; set output {}; load {}; unset output; ", pictures[i].terminal,
                   gnuplot::file(files[i]), gnuplot::file(pictures[i].keeps_text ? script : shown));
  const ProgramResult result =
      run_program({"gnuplot", "--default-settings", "-e", commands.text()});
  throw_if_stopped();
  if (!result.found)
    throw UserError(
        "gnuplot is missing: scripts were written, plots were not; install gnuplot-nox");
  if (result.signal != 0)
    throw UserError("{}: gnuplot was killed by signal {} ({})", script.string(), result.signal,
                    strsignal(result.signal));
  if (result.exit_code != 0)
    throw UserError("{}: gnuplot refused the script: {}", script.string(),
                    first_complaint(result.errors));
  for (std::size_t i = 0; i < pictures.size(); ++i)
    check_whole(files[i], pictures[i].ending,
                fs::path(script).replace_extension(pictures[i].extension));
}

/// With names of joints that leave room for the curves.
Figure with_short_names(Figure figure) {
  constexpr std::size_t kTitle = 32, kTic = 20;  // letters
  for (Panel& panel : figure.panels) {
    panel.title = shortened(panel.title, kTitle);
    for (auto* tics : {&panel.x_tics, &panel.y_tics})
      for (auto& [place, name] : *tics) name = shortened(name, kTic);
  }
  return figure;
}

/// A file that is gone at the end of a block; empty: none.
struct Removed {
  fs::path file;
  ~Removed() {
    std::error_code ignored;
    if (!file.empty()) fs::remove(file, ignored);
  }
};

}  // namespace

std::vector<fs::path> write_figure(const Figure& wanted, const fs::path& folder) {
  const Figure figure = with_short_names(wanted);
  const auto path = [&](std::string_view extension) {
    return folder / (figure.name + std::string(extension));
  };
  const fs::path script = path(".gp");
  std::vector<fs::path> pictures{path(".pdf"), path(".svg"), path(".png")};
  const std::string text = script_of(figure), shown = with_known_letters(text);
  write_file_atomically(script, text);
  const fs::path drawn = shown == text ? script : path(".drawn.gp");
  const Removed at_the_end{drawn == script ? fs::path() : drawn};
  if (drawn != script) write_file_atomically(drawn, shown);
  write_file_atomically(pictures[0], [&](const fs::path& pdf) {
    write_file_atomically(pictures[1], [&](const fs::path& svg) {
      write_file_atomically(pictures[2], [&](const fs::path& png) {
        draw(figure, script, drawn, {pdf, svg, png});
      });
    });
  });
  pictures.insert(pictures.begin(), script);
  return pictures;
}

}  // namespace fricid::render
