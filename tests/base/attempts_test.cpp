#include "fricid/base/attempts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fricid {
namespace {

using ::testing::StrEq;
using ::testing::ThrowsMessage;

TEST(Attempts, DoAllThatCanBeDone) {
  Attempts attempts;
  int done = 0;
  for (int k = 0; k < 5; ++k)
    attempts.try_to([&] {
      if (k % 2 == 0) throw UserError("{} is even", k);
      ++done;
    });
  EXPECT_EQ(done, 2);
  EXPECT_THAT([&] { attempts.finish(); },
              ThrowsMessage<UserError>(StrEq("0 is even; 2 more likewise")));
}

TEST(Attempts, SayACommonReasonOnce) {
  Attempts attempts;
  for (int k = 0; k < 5; ++k) attempts.try_to([] { throw UserError("the disk is full"); });
  EXPECT_THAT([&] { attempts.finish(); }, ThrowsMessage<UserError>(StrEq("the disk is full")));
  EXPECT_NO_THROW(Attempts().finish());
}

}  // namespace
}  // namespace fricid
