#include "seeds.hpp"

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"

namespace fricid::cli {
namespace {

using testing::ElementsAre;

TEST(Seeds, NumbersAndRanges) {
  EXPECT_THAT(parse_seeds("7"), ElementsAre(7));
  EXPECT_THAT(parse_seeds("1-4"), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(parse_seeds("5,1-2,0"), ElementsAre(5, 1, 2, 0));
  EXPECT_THAT(parse_seeds("1000000000"), ElementsAre(1'000'000'000));
  EXPECT_EQ(parse_seeds("0-999").size(), 1000u);
}

TEST(Seeds, RefusesEverythingElse) {
  for (const char* text : {"",
                           ",",
                           "1,",
                           ",1",
                           "1,,2",
                           "1-",
                           "-1",
                           "2-1",
                           "1-2-3",
                           "a",
                           "1a",
                           " 1",
                           "1 ",
                           "+1",
                           "1.5",
                           "1e3",
                           "0x1",
                           "99999999999",
                           "1000000001",
                           "2147483647",
                           "0-2147483647",
                           "1-99999999999",
                           "0-1000",
                           "0-999,1000",
                           "1,1",
                           "1-3,2"})
    EXPECT_THROW(parse_seeds(text), UserError) << text;
}

TEST(Seeds, SaysWhatIsAllowed) {
  try {
    parse_seeds("1,");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_STREQ(
        error.what(),
        "--seeds \"1,\": allowed: up to 1000 numbers from 0 to 1000000000, each once, such "
        "as 1-5 or 1,3");
  }
}

}  // namespace
}  // namespace fricid::cli
