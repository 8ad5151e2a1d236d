// Text, lines and pictures on an image, by cairo.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "fricid/film/image.hpp"
#include "fricid/film/paint.hpp"

namespace fricid::film {

struct Point {
  double x = 0, y = 0;
};

/// Rectangle with its upper left corner; y grows downwards.
struct Box {
  double x = 0, y = 0, width = 0, height = 0;
};

enum class Align { kLeft, kCentre, kRight };

struct TextStyle {
  double size = 14;
  Paint paint = {};
  Align align = Align::kLeft;
  bool bold = false;
};

struct LineStyle {
  double width = 1.5;
  Paint paint = {};
  bool dashed = false;
};

/// A white page of `width` x `height` units, drawn at `scale` pixels per unit.
class Canvas {
 public:
  Canvas(int width, int height, double scale = 1);
  ~Canvas();
  Canvas(Canvas&&) noexcept;

  void fill(const Box& box, const Paint& paint, double corner_radius = 0);
  /// Lines through the points; a NaN breaks them.
  void line(std::span<const Point> points, const LineStyle& style);
  void disc(Point centre, double radius, const Paint& paint);
  /// `at` is the left, middle or right end of the base line, turned by `quarter_turns` to the left.
  void text(Point at, const std::string& text, const TextStyle& style, int quarter_turns = 0);
  double text_width(const std::string& text, const TextStyle& style) const;
  /// Draws an image into a box; pixel by pixel when the box has its size in pixels.
  void picture(const Image& image, const Box& box);
  /// Clips drawing to the box, until `unclip`.
  void clip(const Box& box);
  void unclip();

  Image image() const;

 private:
  struct Cairo;
  std::unique_ptr<Cairo> cairo_;
};

}  // namespace fricid::film
