#include "fricid/film/canvas.hpp"

#include <cairo.h>

#include <array>
#include <cmath>
#include <numbers>

#include "cairo_pixels.hpp"

namespace fricid::film {
namespace {

constexpr const char* kFont = "DejaVu Sans";

void set_paint(cairo_t* cr, const Paint& paint) {
  cairo().set_source_rgba(cr, paint.red, paint.green, paint.blue, paint.alpha);
}

void set_font(cairo_t* cr, const TextStyle& style) {
  cairo().select_font_face(cr, kFont, CAIRO_FONT_SLANT_NORMAL,
                           style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo().set_font_size(cr, style.size);
}

double advance_of(cairo_t* cr, const std::string& text) {
  cairo_text_extents_t extents;
  cairo().text_extents(cr, text.c_str(), &extents);
  return extents.x_advance;
}

void add_rounded_box(cairo_t* cr, const Box& box, double radius) {
  constexpr double kQuarter = std::numbers::pi / 2;
  const double right = box.x + box.width, bottom = box.y + box.height;
  cairo().new_sub_path(cr);
  cairo().arc(cr, right - radius, box.y + radius, radius, -kQuarter, 0);
  cairo().arc(cr, right - radius, bottom - radius, radius, 0, kQuarter);
  cairo().arc(cr, box.x + radius, bottom - radius, radius, kQuarter, 2 * kQuarter);
  cairo().arc(cr, box.x + radius, box.y + radius, radius, 2 * kQuarter, 3 * kQuarter);
  cairo().close_path(cr);
}

}  // namespace

struct Canvas::Cairo {
  SurfacePtr surface;
  cairo_t* cr;

  Cairo(int width, int height)
      : surface(cairo().image_surface_create(CAIRO_FORMAT_RGB24, width, height)),
        cr(cairo().create(surface.get())) {}
  ~Cairo() { cairo().destroy(cr); }
  Cairo(const Cairo&) = delete;
  Cairo& operator=(const Cairo&) = delete;
};

Canvas::Canvas(int width, int height, double scale)
    : cairo_(std::make_unique<Cairo>(static_cast<int>(std::lround(width * scale)),
                                     static_cast<int>(std::lround(height * scale)))) {
  cairo().scale(cairo_->cr, scale, scale);
  cairo().set_source_rgb(cairo_->cr, 1, 1, 1);
  cairo().paint(cairo_->cr);
  cairo().set_line_join(cairo_->cr, CAIRO_LINE_JOIN_ROUND);
}

Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;

void Canvas::fill(const Box& box, const Paint& paint, double corner_radius) {
  cairo_t* cr = cairo_->cr;
  if (corner_radius > 0)
    add_rounded_box(cr, box, corner_radius);
  else
    cairo().rectangle(cr, box.x, box.y, box.width, box.height);
  set_paint(cr, paint);
  cairo().fill(cr);
}

void Canvas::line(std::span<const Point> points, const LineStyle& style) {
  constexpr std::array<double, 2> kDashes{5, 4};
  cairo_t* cr = cairo_->cr;
  bool pen_down = false;
  for (const Point& point : points) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y)) {
      pen_down = false;
    } else if (pen_down) {
      cairo().line_to(cr, point.x, point.y);
    } else {
      cairo().move_to(cr, point.x, point.y);
      pen_down = true;
    }
  }
  set_paint(cr, style.paint);
  cairo().set_line_width(cr, style.width);
  cairo().set_dash(cr, kDashes.data(), style.dashed ? static_cast<int>(kDashes.size()) : 0, 0);
  cairo().stroke(cr);
}

void Canvas::disc(Point centre, double radius, const Paint& paint) {
  cairo_t* cr = cairo_->cr;
  cairo().new_sub_path(cr);
  cairo().arc(cr, centre.x, centre.y, radius, 0, 2 * std::numbers::pi);
  set_paint(cr, paint);
  cairo().fill(cr);
}

void Canvas::text(Point at, const std::string& text, const TextStyle& style, int quarter_turns) {
  cairo_t* cr = cairo_->cr;
  set_font(cr, style);
  set_paint(cr, style.paint);
  const double width = advance_of(cr, text);
  const double shift = style.align == Align::kLeft    ? 0
                       : style.align == Align::kRight ? -width
                                                      : -width / 2;
  cairo().save(cr);
  cairo().translate(cr, at.x, at.y);
  cairo().rotate(cr, -quarter_turns * std::numbers::pi / 2);
  cairo().move_to(cr, shift, 0);
  cairo().show_text(cr, text.c_str());
  cairo().restore(cr);
}

double Canvas::text_width(const std::string& text, const TextStyle& style) const {
  set_font(cairo_->cr, style);
  return advance_of(cairo_->cr, text);
}

void Canvas::picture(const Image& image, const Box& box) {
  cairo_t* cr = cairo_->cr;
  const SurfacePtr surface = surface_of(image);
  cairo().save(cr);
  cairo().translate(cr, box.x, box.y);
  cairo().scale(cr, box.width / image.width, box.height / image.height);
  cairo().set_source_surface(cr, surface.get(), 0, 0);
  double sx = 1, sy = 0;
  cairo().user_to_device_distance(cr, &sx, &sy);
  const bool same_size = std::abs(sx - 1) < 1e-9;
  cairo().pattern_set_filter(cairo().get_source(cr),
                             same_size ? CAIRO_FILTER_NEAREST : CAIRO_FILTER_GOOD);
  cairo().rectangle(cr, 0, 0, image.width, image.height);
  cairo().fill(cr);
  cairo().restore(cr);
}

void Canvas::clip(const Box& box) {
  cairo().save(cairo_->cr);
  cairo().rectangle(cairo_->cr, box.x, box.y, box.width, box.height);
  cairo().clip(cairo_->cr);
}

void Canvas::unclip() { cairo().restore(cairo_->cr); }

Image Canvas::image() const { return image_of(*cairo_->surface); }

}  // namespace fricid::film
