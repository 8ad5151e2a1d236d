#include "fricid/film/chart.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fricid::film {
namespace {

using ::testing::DoubleEq;
using ::testing::DoubleNear;
using ::testing::ElementsAre;

TEST(TicksOf, AreRoundNumbersInside) {
  EXPECT_THAT(ticks_of({0, 10}, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(ticks_of({-1.2, 1.1}, 5), ElementsAre(-1, -0.5, 0, 0.5, 1));
  EXPECT_THAT(ticks_of({0.31, 0.44}, 3),
              ElementsAre(DoubleNear(0.35, 1e-12), DoubleNear(0.4, 1e-12)));
}

TEST(TicksOf, AreDecadesOnALogAxis) {
  EXPECT_THAT(ticks_of({0.01, 1000, true}, 6),
              ElementsAre(DoubleEq(0.01), DoubleEq(0.1), 1, 10, 100, 1000));
  EXPECT_LE(ticks_of({1e-9, 1e3, true}, 4).size(), 5u);
}

TEST(RangeOf, LeavesOutWhatIsNotFiniteAndAddsAMargin) {
  const auto [low, high] = range_of(std::vector<double>{1, NAN, 3, HUGE_VAL}, 0.1);
  EXPECT_DOUBLE_EQ(low, 0.8);
  EXPECT_DOUBLE_EQ(high, 3.2);
  EXPECT_LT(range_of(std::vector<double>{2, 2}, 0.1).first,
            range_of(std::vector<double>{2, 2}, 0.1).second);
  EXPECT_EQ(range_of({}, 0.1), (std::pair{-1.0, 1.0}));
}

/// Rows of the canvas in which a curve of constant y leaves red.
std::pair<int, int> red_rows(const Axis& y_axis, double y) {
  Canvas canvas(200, 200);
  const Chart chart({0, 0, 200, 200}, "", {0, 1}, y_axis);
  chart.draw_curve(canvas, std::vector<double>{0, 1}, std::vector<double>{y, y},
                   {.width = 1, .paint = {1, 0, 0, 1}});
  const Image image = canvas.image();
  std::pair<int, int> rows{200, -1};
  for (int row = 0; row < 200; ++row)
    if (image.row(row)[3 * 100 + 1] < 200)
      rows = {std::min(rows.first, row), std::max(rows.second, row)};
  return rows;
}

TEST(Chart, PutsValuesWhereTheAxisSays) {
  const int bottom = red_rows({0, 10}, 0).second, top = red_rows({0, 10}, 10).first;
  EXPECT_GT(bottom - top, 100);
  EXPECT_NEAR(red_rows({0, 10}, 2.5).first, bottom + (top - bottom) / 4.0, 2);
  EXPECT_NEAR(red_rows({1, 1e4, true}, 10).first, bottom + (top - bottom) / 4.0, 2);
}

TEST(Chart, CutsOffWhatIsOutside) { EXPECT_EQ(red_rows({0, 10}, 11).second, -1); }

}  // namespace
}  // namespace fricid::film
