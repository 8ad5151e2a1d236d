#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace fricid::film {

/// 8-bit RGB picture, row 0 at the top, 3 bytes per pixel and no padding.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb{};  ///< (3 * width * height)

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgb(3 * area(w, h)) {}

  const std::uint8_t* row(int y) const { return rgb.data() + 3 * area(width, y); }
  std::uint8_t* row(int y) { return rgb.data() + 3 * area(width, y); }

 private:
  static std::size_t area(int w, int h) {
    return static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  }
};

/// Planes Y, Cb and Cr one after the other, 4:2:0 and 8-bit, BT.709 in limited range, for videos;
/// one colour sample per 2 x 2 pixels. @pre width and height are even
std::vector<std::uint8_t> yuv420_of(const Image& image);

/// PNG files. Written atomically. @throws UserError naming the path
void save_png(const Image& image, const std::filesystem::path& path);
Image load_png(const std::filesystem::path& path);

/// Share of pixels in which some channel differs by more than `levels`; 1 when the sizes differ.
double share_differing(const Image& a, const Image& b, int levels);

}  // namespace fricid::film
