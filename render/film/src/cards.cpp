#include "cards.hpp"

#include <algorithm>
#include <cmath>

#include "film_style.hpp"
#include "fricid/base/error.hpp"
#include "fricid/film/comparison.hpp"
#include "fricid/render/palette.hpp"

namespace fricid::film {
namespace {

constexpr Paint kRule{0.8f, 0.8f, 0.82f, 1}, kShade{0.955f, 0.96f, 0.965f, 1};

/// Words that fit into lines of `width`.
std::vector<std::string> wrapped(const Canvas& canvas, const std::string& text, double width,
                                 const TextStyle& style) {
  std::vector<std::string> lines;
  std::string line;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    const std::string longer = line.empty() ? word : line + " " + word;
    if (!line.empty() && canvas.text_width(longer, style) > width) {
      lines.push_back(line);
      line = word;
    } else {
      line = longer;
    }
    at = end + 1;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

/// 3.2e-5 as "3.2e-5"; 0.0123 as "0.012".
std::string two_digits(double value) {
  if (!std::isfinite(value)) return "–";
  if (value >= 0.01 && value < 1000) return fmt::format("{:.2g}", value);
  std::string text = fmt::format("{:.1e}", value);
  const std::size_t e = text.find('e');
  return text.substr(0, e + 1) + std::to_string(std::stoi(text.substr(e + 1)));
}

}  // namespace

Image draw_opening_card(const RunFilm& film, const Image& arm) {
  constexpr double kLeft = 56, kWidth = kFilmWidth / 2.0 - 2 * kLeft + 20;
  Canvas canvas(kFilmWidth, kFilmHeight);
  canvas.picture(arm, {kFilmWidth / 2.0, 0, kFilmWidth / 2.0, kFilmHeight});

  double y = 150;
  const auto paragraph = [&](const std::string& text, const TextStyle& style, double gap) {
    for (const std::string& line : wrapped(canvas, text, kWidth, style)) {
      canvas.text({kLeft, y}, line, style);
      y += 1.4 * style.size;
    }
    y += gap;
  };
  const TextStyle head{.size = 15, .paint = kFaint, .bold = true};
  const TextStyle body{.size = 19, .paint = kInk};
  paragraph(film.scene, {.size = 38, .paint = kInk, .bold = true}, 2);
  paragraph(film.description, {.size = 19, .paint = kFaint}, 26);
  paragraph(film.friction.empty() ? "RECORDED ON A REAL ARM" : "FRICTION INJECTED INTO EVERY JOINT",
            head, 6);
  paragraph(film.friction, body, 24);
  paragraph("IN OPEN LOOP", head, 10);
  const auto actor = [&](const Paint& paint, const std::string& label) {
    canvas.fill({kLeft, y - 15, 30, 17}, paint, 4);
    canvas.text({kLeft + 44, y}, label, body);
    y += 32;
  };
  actor(paint_of(render::kTruthColour), film.has_truth() ? "the true arm" : "the arm as measured");
  for (const FilmModel& model : film.models) actor(paint_of(model.colour), model.label);
  y += 16;
  paragraph(fmt::format("All are driven by the torques recorded in {}. A model never sees the true "
                        "motion again after t = 0.",
                        film.trajectory),
            {.size = 16, .paint = kFaint}, 0);
  return canvas.image();
}

Image draw_closing_card(const RunFilm& film) {
  constexpr double kLeft = 120, kRight = kFilmWidth - 120;
  Canvas canvas(kFilmWidth, kFilmHeight);
  canvas.text({kLeft, 100}, film.scene + ": how far the open loops drift",
              {.size = 30, .paint = kInk, .bold = true});
  canvas.text({kLeft, 134},
              "Mean squared error of the joint angles [rad²] from the start of a rollout to the "
              "horizon, held-out data",
              {.size = 16, .paint = kFaint});

  const double columns = static_cast<double>(std::max<std::size_t>(film.horizons.size(), 1));
  const double first = kLeft + 330, column = (kRight - first) / columns;
  const double row_height = std::min(46.0, 470.0 / static_cast<double>(film.table.size() + 1));
  const double size = std::min(21.0, 0.46 * row_height);
  double y = 200;
  for (std::size_t h = 0; h < film.horizons.size(); ++h)
    canvas.text({first + column * static_cast<double>(h + 1) - 16, y},
                fmt::format("{:g} s", std::round(10 * film.horizons[h]) / 10),
                {.size = size, .paint = kFaint, .align = Align::kRight, .bold = true});
  y += 14;
  canvas.line(std::vector<Point>{{kLeft, y}, {kRight, y}}, {.width = 1.5, .paint = kInk});

  // the best of each horizon, the oracle apart
  std::vector<double> best(film.horizons.size(), HUGE_VAL);
  for (const FilmRow& row : film.table)
    if (!row.is_oracle)
      for (std::size_t h = 0; h < row.mse.size() && h < best.size(); ++h)
        if (std::isfinite(row.mse[h])) best[h] = std::min(best[h], row.mse[h]);

  for (const FilmRow& row : film.table) {
    if (row.shown) canvas.fill({kLeft, y, kRight - kLeft, row_height}, kShade);
    const double base = y + row_height / 2 + 0.35 * size;
    canvas.fill({kLeft + 12, base - 0.72 * size, 30, 0.8 * size}, paint_of(row.colour), 4);
    canvas.text({kLeft + 56, base}, row.label, {.size = size, .paint = kInk, .bold = row.shown});
    for (std::size_t h = 0; h < row.mse.size() && h < film.horizons.size(); ++h)
      canvas.text(
          {first + column * static_cast<double>(h + 1) - 16, base}, two_digits(row.mse[h]),
          {.size = size, .paint = kInk, .align = Align::kRight, .bold = row.mse[h] == best[h]});
    y += row_height;
    canvas.line(std::vector<Point>{{kLeft, y}, {kRight, y}}, {.width = 1, .paint = kRule});
  }
  canvas.text({kLeft, y + 34},
              film.oracle.q.size() > 0
                  ? "The oracle is the true model under the same noisy torques: no model can do "
                    "better. Bold: best of the others."
                  : "Bold: best of all.",
              {.size = 16, .paint = kFaint});
  return canvas.image();
}

}  // namespace fricid::film
