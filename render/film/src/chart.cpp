#include "fricid/film/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/render/simplify.hpp"

namespace fricid::film {
namespace {

constexpr double kLeft = 58, kRight = 14, kTop = 28, kBottom = 36;
constexpr double kUnseen = 0.1;  // [pixels]
constexpr Point kBreak{std::numeric_limits<double>::quiet_NaN(), 0};
constexpr Paint kLetters{0.2f, 0.2f, 0.22f, 1}, kGrid{0.88f, 0.88f, 0.89f, 1},
    kScale{0.4f, 0.4f, 0.42f, 1};

double share_of(const Axis& axis, double value) {
  if (!axis.log) return (value - axis.low) / (axis.high - axis.low);
  return std::log(std::max(value, 1e-300) / axis.low) / std::log(axis.high / axis.low);
}

std::string label_of(const Axis& axis, double value) {
  if (axis.log && (value < 0.01 || value > 1000)) return fmt::format("{:.0e}", value);
  return fmt::format("{:g}", std::abs(value) < 1e-12 ? 0.0 : value);
}

}  // namespace

std::vector<double> ticks_of(const Axis& axis, int count) {
  std::vector<double> ticks;
  if (axis.log) {
    const int first = static_cast<int>(std::ceil(std::log10(axis.low) - 1e-9)),
              last = static_cast<int>(std::floor(std::log10(axis.high) + 1e-9));
    const int stride = std::max(1, (last - first + count) / std::max(count, 1));
    for (int exponent = first; exponent <= last; exponent += stride)
      ticks.push_back(std::pow(10, exponent));
    return ticks;
  }
  const double least = (axis.high - axis.low) / count,
               decade = std::pow(10, std::floor(std::log10(least)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * decade >= least * (1 - 1e-9)) step = factor * decade;
  for (double k = std::ceil(axis.low / step - 1e-9); k * step <= axis.high + 1e-9 * step; ++k)
    ticks.push_back(k * step);
  return ticks;
}

std::pair<double, double> range_of(std::span<const double> values, double margin) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low > high) return {-1, 1};
  const double extent = std::max(high - low, 1e-9 * std::max(1.0, std::abs(high)));
  return {low - margin * extent, high + margin * extent};
}

Chart::Chart(Box box, std::string title, Axis x, Axis y)
    : plot_{box.x + kLeft, box.y + kTop, box.width - kLeft - kRight, box.height - kTop - kBottom},
      title_(std::move(title)),
      x_(std::move(x)),
      y_(std::move(y)) {}

Point Chart::at(double x, double y) const {
  return {plot_.x + plot_.width * share_of(x_, x), plot_.y + plot_.height * (1 - share_of(y_, y))};
}

void Chart::draw_axes(Canvas& canvas) const {
  constexpr double kLetter = 11.5;
  const double bottom = plot_.y + plot_.height, right = plot_.x + plot_.width;
  const LineStyle grid{.width = 1, .paint = kGrid}, border{.width = 1, .paint = kLetters};

  for (const double tick : ticks_of(x_, static_cast<int>(plot_.width / 55))) {
    const double x = at(tick, y_.low).x;
    canvas.line(std::vector<Point>{{x, plot_.y}, {x, bottom}}, grid);
    canvas.text({x, bottom + 15}, label_of(x_, tick),
                {.size = kLetter, .paint = kScale, .align = Align::kCentre});
  }
  for (const double tick : ticks_of(y_, static_cast<int>(plot_.height / 30))) {
    const double y = at(x_.low, tick).y;
    canvas.line(std::vector<Point>{{plot_.x, y}, {right, y}}, grid);
    canvas.text({plot_.x - 6, y + 4}, label_of(y_, tick),
                {.size = kLetter, .paint = kScale, .align = Align::kRight});
  }
  canvas.line(std::vector<Point>{{plot_.x, plot_.y}, {plot_.x, bottom}, {right, bottom}}, border);

  canvas.text({plot_.x, plot_.y - 10}, title_, {.size = 13, .paint = kLetters, .bold = true});
  canvas.text({plot_.x + plot_.width / 2, bottom + 30}, x_.label,
              {.size = 12, .paint = kLetters, .align = Align::kCentre});
  canvas.text({plot_.x - 42, plot_.y + plot_.height / 2}, y_.label,
              {.size = 12, .paint = kLetters, .align = Align::kCentre}, 1);
}

void Chart::draw_curve(Canvas& canvas, std::span<const double> x, std::span<const double> y,
                       const LineStyle& style) const {
  // in pixels, to skip invisible detail; a NaN breaks the line
  std::vector<double> px, py;
  std::vector<Point> points;
  for (std::size_t i = 0; i <= x.size(); ++i) {
    const Point point = i < x.size() ? at(x[i], y[i]) : kBreak;
    if (std::isfinite(point.x) && std::isfinite(point.y)) {
      px.push_back(point.x);
      py.push_back(point.y);
      continue;
    }
    for (const std::size_t k : render::simplified(px, py, kUnseen))
      points.push_back({px[k], py[k]});
    points.push_back(kBreak);
    px.clear();
    py.clear();
  }
  canvas.clip(plot_);
  canvas.line(points, style);
  canvas.unclip();
}

void Chart::draw_point(Canvas& canvas, double x, double y, double radius,
                       const Paint& paint) const {
  if (std::isfinite(x) && std::isfinite(y)) canvas.disc(at(x, y), radius, paint);
}

void Chart::draw_mark(Canvas& canvas, double x, const LineStyle& style) const {
  canvas.line(std::vector<Point>{at(x, y_.low), at(x, y_.high)}, style);
}

}  // namespace fricid::film
