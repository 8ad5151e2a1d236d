#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fricid/film/canvas.hpp"

namespace fricid::film {

struct Axis {
  double low = 0, high = 1;
  bool log = false;
  std::string label{};
};

/// Values of an axis that get a label: multiples of 1, 2 or 5 times a power of ten, at most `count`
/// of them; powers of ten on a log axis.
std::vector<double> ticks_of(const Axis& axis, int count);

/// Range of values widened by `margin` of itself; a range without extent gets one.
std::pair<double, double> range_of(std::span<const double> values, double margin);

/// A pair of axes with a title, drawn into a box of a canvas.
class Chart {
 public:
  Chart(Box box, std::string title, Axis x, Axis y);

  /// Axes, grid and labels.
  void draw_axes(Canvas& canvas) const;
  /// y against x; what lies outside of the axes is cut off.
  void draw_curve(Canvas& canvas, std::span<const double> x, std::span<const double> y,
                  const LineStyle& style) const;
  void draw_point(Canvas& canvas, double x, double y, double radius, const Paint& paint) const;
  /// A vertical line.
  void draw_mark(Canvas& canvas, double x, const LineStyle& style) const;

 private:
  Point at(double x, double y) const;

  Box plot_;
  std::string title_;
  Axis x_, y_;
};

}  // namespace fricid::film
