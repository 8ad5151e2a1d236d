// Suggestions for misspelt words.
#include "fricid/base/text.hpp"

#include <gtest/gtest.h>

#include <array>

namespace fricid {
namespace {

TEST(EditDistance, CountsTheFewestEdits) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("lugre", "lugre"), 0);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("abc", ""), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("lurge", "lugre"), 1);  // two neighbours swapped
  EXPECT_EQ(edit_distance("dhal", "dahl"), 1);
  EXPECT_EQ(edit_distance("ca", "abc"), 3);  // no part changed twice
}

TEST(Nearest, FindsTheWordMeant) {
  const std::array<std::string_view, 5> known = {"coulomb_Nm", "stribeck_velocity_rad_s",
                                                 "harmonics", "period_s", "seed"};
  EXPECT_EQ(nearest("harmoncis", known), "harmonics");
  EXPECT_EQ(nearest("Coulomb_nm", known), "coulomb_Nm");
  EXPECT_EQ(nearest("coulomb", known), "coulomb_Nm");
  EXPECT_EQ(nearest("stribeck_velocity", known), "stribeck_velocity_rad_s");
  EXPECT_EQ(nearest("seeds", known), "seed");
}

TEST(Nearest, IsEmptyWhenNothingIsNear) {
  const std::array<std::string_view, 2> known = {"harmonics", "seed"};
  EXPECT_EQ(nearest("robot", known), "");
  EXPECT_EQ(nearest("", known), "");
  EXPECT_EQ(nearest("seed", {}), "");
}

TEST(Enumeration, PutsAndBeforeTheLast) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(first_of(Words{"a", "b", "c"}, 3), "a, b, c");
  EXPECT_EQ(first_of(Words{"a", "b", "c"}, 1), "a and 2 more");
  EXPECT_EQ(enumeration(Words{}), "");
  EXPECT_EQ(enumeration(Words{"a"}), "a");
  EXPECT_EQ(enumeration(Words{"a", "b"}), "a and b");
  EXPECT_EQ(enumeration(Words{"a", "b", "c"}), "a, b and c");
}

TEST(Nearest, PrefersTheFirstOfEqualDistance) {
  const std::array<std::string_view, 2> known = {"sigma0", "sigma1"};
  EXPECT_EQ(nearest("sigma", known), "sigma0");
}

}  // namespace
}  // namespace fricid
