#include "fricid/film/image.hpp"

#include <gtest/gtest.h>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "temporary_folder.hpp"

namespace fricid::film {
namespace {

/// Every byte differs from its neighbours.
Image pattern(int width, int height) {
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgb.size(); ++i)
    image.rgb[i] = static_cast<std::uint8_t>(i * 37 % 251);
  return image;
}

using Png = TemporaryFolder;

TEST_F(Png, RoundTripKeepsEveryByte) {
  const Image image = pattern(13, 7);
  save_png(image, folder / "a.png");
  const Image back = load_png(folder / "a.png");
  EXPECT_EQ(back.width, 13);
  EXPECT_EQ(back.height, 7);
  EXPECT_EQ(back.rgb, image.rgb);
}

TEST_F(Png, MissingAndBrokenFilesAreNamed) {
  EXPECT_THROW(load_png(folder / "none.png"), UserError);
  write_file_atomically(folder / "broken.png", "no picture");
  EXPECT_THROW(load_png(folder / "broken.png"), UserError);
}

TEST(ShareDiffering, CountsPixelsNotChannels) {
  const Image a = pattern(10, 10);
  Image b = a;
  EXPECT_EQ(share_differing(a, b, 0), 0);
  b.rgb[0] = static_cast<std::uint8_t>(b.rgb[0] + 5);
  b.rgb[1] = static_cast<std::uint8_t>(b.rgb[1] + 5);
  EXPECT_DOUBLE_EQ(share_differing(a, b, 4), 0.01);
  EXPECT_EQ(share_differing(a, b, 5), 0);
  EXPECT_EQ(share_differing(a, pattern(10, 9), 255), 1);
}

}  // namespace
}  // namespace fricid::film
