#pragma once

#include <memory>

#include "cairo_library.hpp"

#include "fricid/film/image.hpp"

namespace fricid::film {

struct SurfaceDeleter {
  void operator()(cairo_surface_t* surface) const { cairo().surface_destroy(surface); }
};
using SurfacePtr = std::unique_ptr<cairo_surface_t, SurfaceDeleter>;

SurfacePtr surface_of(const Image& image);
/// @pre an image surface of 32 bits per pixel
Image image_of(cairo_surface_t& surface);

}  // namespace fricid::film
