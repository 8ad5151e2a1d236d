#include "fricid/film/canvas.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "fricid/base/error.hpp"

namespace fricid::film {
namespace {

using Rgb = std::array<int, 3>;
constexpr Rgb kWhite{255, 255, 255}, kRed{255, 0, 0};

Rgb at(const Image& image, int x, int y) {
  const std::uint8_t* pixel = image.row(y) + 3 * x;
  return {pixel[0], pixel[1], pixel[2]};
}

int inked(const Image& image, const Box& box) {
  int count = 0;
  for (int y = static_cast<int>(box.y); y < box.y + box.height; ++y)
    for (int x = static_cast<int>(box.x); x < box.x + box.width; ++x)
      count += at(image, x, y) != kWhite ? 1 : 0;
  return count;
}

TEST(Canvas, FillsTheBoxAndNothingElse) {
  Canvas canvas(20, 10);
  canvas.fill({5, 2, 4, 3}, {1, 0, 0, 1});
  const Image image = canvas.image();
  EXPECT_EQ(at(image, 5, 2), kRed);
  EXPECT_EQ(at(image, 8, 4), kRed);
  EXPECT_EQ(inked(image, {0, 0, 20, 10}), 12);
}

TEST(Canvas, ScaleMultipliesPixels) {
  Canvas canvas(20, 10, 1.5);
  canvas.fill({10, 0, 10, 10}, {1, 0, 0, 1});
  const Image image = canvas.image();
  EXPECT_EQ(image.width, 30);
  EXPECT_EQ(image.height, 15);
  EXPECT_EQ(at(image, 14, 7), kWhite);
  EXPECT_EQ(at(image, 15, 7), kRed);
}

TEST(Canvas, NanBreaksALine) {
  Canvas canvas(40, 10);
  const std::array<Point, 5> points{{{0, 5}, {10, 5}, {20, NAN}, {30, 5}, {40, 5}}};
  canvas.line(points, {.width = 2, .paint = {1, 0, 0, 1}});
  const Image image = canvas.image();
  EXPECT_EQ(at(image, 5, 5), kRed);
  EXPECT_EQ(at(image, 20, 5), kWhite);
  EXPECT_EQ(at(image, 35, 5), kRed);
}

TEST(Canvas, PicturesOfTheSameSizeAreCopied) {
  Image picture(4, 3);
  for (std::size_t i = 0; i < picture.rgb.size(); ++i)
    picture.rgb[i] = static_cast<std::uint8_t>(i * 7);
  Canvas canvas(10, 10);
  canvas.picture(picture, {3, 2, 4, 3});
  const Image image = canvas.image();
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) EXPECT_EQ(at(image, 3 + x, 2 + y), at(picture, x, y));
  EXPECT_EQ(at(image, 2, 2), kWhite);
}

TEST(Canvas, TextEndsWhereItIsAligned) {
  const TextStyle style{.size = 20, .align = Align::kRight};
  Canvas canvas(200, 40);
  canvas.text({150, 30}, "Coulomb", style);
  const Image image = canvas.image();
  const double width = canvas.text_width("Coulomb", style);
  EXPECT_GT(width, 60);
  EXPECT_GT(inked(image, {150 - width, 5, width, 30}), 200);
  EXPECT_EQ(inked(image, {152, 0, 48, 40}), 0);
  EXPECT_EQ(inked(image, {0, 0, 148 - width, 40}), 0);
}

TEST(Canvas, ClipHoldsUntilUnclip) {
  Canvas canvas(10, 10);
  canvas.clip({0, 0, 5, 10});
  canvas.fill({0, 0, 10, 10}, {1, 0, 0, 1});
  canvas.unclip();
  EXPECT_EQ(inked(canvas.image(), {0, 0, 10, 10}), 50);
}

TEST(PaintOf, ReadsHexadecimalColours) {
  const Paint paint = paint_of("#ff8000", 0.5f);
  EXPECT_FLOAT_EQ(paint.red, 1);
  EXPECT_FLOAT_EQ(paint.green, 128.0f / 255);
  EXPECT_FLOAT_EQ(paint.blue, 0);
  EXPECT_FLOAT_EQ(paint.alpha, 0.5f);
  for (const char* wrong : {"red", "#12345", "#1234567", "#12345g", "1234567"})
    EXPECT_THROW(paint_of(wrong), UserError) << wrong;
}

}  // namespace
}  // namespace fricid::film
