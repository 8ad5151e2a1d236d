#include "fricid/film/image.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "cairo_pixels.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"

namespace fricid::film {

SurfacePtr surface_of(const Image& image) {
  SurfacePtr surface(cairo().image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
  cairo().surface_flush(surface.get());
  unsigned char* pixels = cairo().image_surface_get_data(surface.get());
  const std::ptrdiff_t stride = cairo().image_surface_get_stride(surface.get());
  for (int y = 0; y < image.height; ++y) {
    auto* to = reinterpret_cast<std::uint32_t*>(pixels + stride * y);
    const std::uint8_t* from = image.row(y);
    for (int x = 0; x < image.width; ++x, from += 3)
      to[x] = static_cast<std::uint32_t>(from[0] << 16 | from[1] << 8 | from[2]);
  }
  cairo().surface_mark_dirty(surface.get());
  return surface;
}

Image image_of(cairo_surface_t& surface) {
  cairo().surface_flush(&surface);
  Image image(cairo().image_surface_get_width(&surface),
              cairo().image_surface_get_height(&surface));
  const unsigned char* pixels = cairo().image_surface_get_data(&surface);
  const std::ptrdiff_t stride = cairo().image_surface_get_stride(&surface);
  for (int y = 0; y < image.height; ++y) {
    const auto* from = reinterpret_cast<const std::uint32_t*>(pixels + stride * y);
    std::uint8_t* to = image.row(y);
    for (int x = 0; x < image.width; ++x, to += 3) {
      to[0] = static_cast<std::uint8_t>(from[x] >> 16);
      to[1] = static_cast<std::uint8_t>(from[x] >> 8);
      to[2] = static_cast<std::uint8_t>(from[x]);
    }
  }
  return image;
}

std::vector<std::uint8_t> yuv420_of(const Image& image) {
  // BT.709 from 0..255 to 16..235 and 16..240, times 2^16
  constexpr int kYR = 11966, kYG = 40254, kYB = 4064;
  constexpr int kBR = -6596, kBG = -22188, kBB = 28784;
  constexpr int kRR = 28784, kRG = -26145, kRB = -2639;
  const auto width = static_cast<std::size_t>(image.width),
             height = static_cast<std::size_t>(image.height);
  std::vector<std::uint8_t> planes(width * height * 3 / 2);
  std::uint8_t* luma = planes.data();
  std::uint8_t* blue = luma + width * height;
  std::uint8_t* red = blue + width * height / 4;
  std::vector<int> sum(3 * width);  // of two rows, colour by colour
  for (int y = 0; y < image.height; y += 2) {
    const std::uint8_t *upper = image.row(y), *lower = image.row(y + 1);
    for (const std::uint8_t* row : {upper, lower}) {
      for (std::size_t x = 0; x < width; ++x)
        luma[x] = static_cast<std::uint8_t>(
            (kYR * row[3 * x] + kYG * row[3 * x + 1] + kYB * row[3 * x + 2] + (33 << 15)) >> 16);
      luma += width;
    }
    int *r = sum.data(), *g = r + width, *b = g + width;
    for (std::size_t x = 0; x < width; ++x) {
      r[x] = upper[3 * x] + lower[3 * x];
      g[x] = upper[3 * x + 1] + lower[3 * x + 1];
      b[x] = upper[3 * x + 2] + lower[3 * x + 2];
    }
    for (std::size_t x = 0; x < width / 2; ++x) {
      const int four_r = r[2 * x] + r[2 * x + 1], four_g = g[2 * x] + g[2 * x + 1],
                four_b = b[2 * x] + b[2 * x + 1];
      constexpr int kMiddle = 257 << 17;  // 128 and a half, for four pixels
      blue[x] =
          static_cast<std::uint8_t>((kBR * four_r + kBG * four_g + kBB * four_b + kMiddle) >> 18);
      red[x] =
          static_cast<std::uint8_t>((kRR * four_r + kRG * four_g + kRB * four_b + kMiddle) >> 18);
    }
    blue += width / 2;
    red += width / 2;
  }
  return planes;
}

void save_png(const Image& image, const std::filesystem::path& path) {
  const SurfacePtr surface = surface_of(image);
  write_file_atomically(path, [&](const std::filesystem::path& part) {
    errno = 0;
    const cairo_status_t status = cairo().surface_write_to_png(surface.get(), part.c_str());
    if (status != CAIRO_STATUS_SUCCESS)
      throw UserError("{}: cannot be written: {}", path.string(),
                      errno != 0 ? std::strerror(errno) : cairo().status_to_string(status));
  });
}

Image load_png(const std::filesystem::path& path) {
  const SurfacePtr surface(cairo().image_surface_create_from_png(path.c_str()));
  if (const cairo_status_t status = cairo().surface_status(surface.get());
      status != CAIRO_STATUS_SUCCESS)
    throw UserError("{}: {}", path.string(), cairo().status_to_string(status));
  const cairo_format_t format = cairo().image_surface_get_format(surface.get());
  if (format != CAIRO_FORMAT_RGB24 && format != CAIRO_FORMAT_ARGB32)
    throw UserError("{}: found a PNG without 8-bit colours", path.string());
  return image_of(*surface);
}

double share_differing(const Image& a, const Image& b, int levels) {
  if (a.width != b.width || a.height != b.height) return 1;
  std::size_t differing = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) {
    int largest = 0;
    for (std::size_t c = 0; c < 3; ++c)
      largest = std::max(largest, std::abs(int{a.rgb[i + c]} - int{b.rgb[i + c]}));
    differing += largest > levels ? 1 : 0;
  }
  return a.rgb.empty() ? 0 : 3 * static_cast<double>(differing) / static_cast<double>(a.rgb.size());
}

}  // namespace fricid::film
