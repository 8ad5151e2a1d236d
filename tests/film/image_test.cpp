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

TEST(Yuv420, ColoursOfBt709InItsLimitedRange) {
  // ITU-R BT.709-6, items 3.2 to 3.5
  const auto planes_of = [](std::uint8_t r, std::uint8_t g, std::uint8_t b) {
    Image image(2, 2);
    for (std::size_t i = 0; i < 12; i += 3) {
      image.rgb[i] = r;
      image.rgb[i + 1] = g;
      image.rgb[i + 2] = b;
    }
    return yuv420_of(image);
  };
  using Planes = std::vector<std::uint8_t>;
  EXPECT_EQ(planes_of(0, 0, 0), (Planes{16, 16, 16, 16, 128, 128}));
  EXPECT_EQ(planes_of(255, 255, 255), (Planes{235, 235, 235, 235, 128, 128}));
  EXPECT_EQ(planes_of(255, 0, 0), (Planes{63, 63, 63, 63, 102, 240}));
  EXPECT_EQ(planes_of(0, 255, 0), (Planes{173, 173, 173, 173, 42, 26}));
  EXPECT_EQ(planes_of(0, 0, 255), (Planes{32, 32, 32, 32, 240, 118}));
}

TEST(Yuv420, AColourStandsForFourPixels) {
  Image image(4, 4);  // its upper right quarter half red, half black
  for (int y = 0; y < 2; ++y) image.row(y)[6] = 255;
  EXPECT_EQ(yuv420_of(image),
            (std::vector<std::uint8_t>{16, 16, 63, 16, 16,  16,  63,  16,  16,  16,  16,  16,
                                       16, 16, 16, 16, 128, 115, 128, 128, 128, 184, 128, 128}));
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
