// The functions of cairo that pictures are drawn with. The library is opened at run time, so that
// it is needed only for drawing.
#pragma once

#include <cairo.h>

namespace fricid::film {

// clang-format off
#define FRICID_CAIRO_FUNCTIONS(F) \
  F(arc) F(clip) F(close_path) F(create) F(destroy) F(fill) F(get_source) \
  F(image_surface_create) F(image_surface_create_from_png) F(image_surface_get_data) \
  F(image_surface_get_format) F(image_surface_get_height) F(image_surface_get_stride) \
  F(image_surface_get_width) F(line_to) F(move_to) F(new_sub_path) F(paint) \
  F(pattern_set_filter) F(rectangle) F(restore) F(rotate) F(save) F(scale) F(select_font_face) \
  F(set_dash) F(set_font_size) F(set_line_join) F(set_line_width) F(set_source_rgb) \
  F(set_source_rgba) F(set_source_surface) F(show_text) F(status_to_string) F(stroke) \
  F(surface_destroy) F(surface_flush) F(surface_mark_dirty) F(surface_status) \
  F(surface_write_to_png) F(text_extents) F(translate) F(user_to_device_distance)
// clang-format on

/// cairo_NAME of the library as member NAME.
struct CairoLibrary {
#define FRICID_CAIRO_MEMBER(name) decltype(&cairo_##name) name;
  FRICID_CAIRO_FUNCTIONS(FRICID_CAIRO_MEMBER)
#undef FRICID_CAIRO_MEMBER
};

/// @throws UserError when the machine has no cairo
const CairoLibrary& cairo();

}  // namespace fricid::film
