#include "drawing_processes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

#include "fricid/base/error.hpp"

namespace fricid::film {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Its number and which process drew it.
Draw numbered() {
  return [](int k) {
    return PictureBytes{static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(getpid() % 251)};
  };
}

TEST(DrawingProcesses, HandOverInOrderWhatEachDraws) {
  DrawingProcesses pictures(7, 3, numbered);
  std::vector<std::uint8_t> from;
  for (int k = 0; k < 7; ++k) {
    const PictureBytes picture = pictures.next();
    ASSERT_EQ(picture[0], k);
    from.push_back(picture[1]);
  }
  EXPECT_EQ(from[0], from[3]);
  EXPECT_NE(from[0], from[1]);
  EXPECT_NE(from[1], from[2]);
}

TEST(DrawingProcesses, OneDrawsWithoutAFork) {
  DrawingProcesses pictures(2, 1, numbered);
  pictures.next();
  const PictureBytes second = pictures.next();
  EXPECT_EQ(second[0], 1);
  EXPECT_EQ(second[1], getpid() % 251);
}

TEST(DrawingProcesses, PassOnWhyThereIsNoPicture) {
  DrawingProcesses unopened(9, 2, []() -> Draw { throw UserError("no GL, install it"); });
  EXPECT_THAT([&] { unopened.next(); }, ThrowsMessage<UserError>(HasSubstr("no GL, install it")));
  DrawingProcesses undrawn(9, 2, [] {
    return [draw = numbered()](int k) { return k == 3 ? throw UserError("too late") : draw(k); };
  });
  for (int k = 0; k < 3; ++k) EXPECT_EQ(undrawn.next()[0], k);
  EXPECT_THAT([&] { undrawn.next(); }, ThrowsMessage<UserError>(HasSubstr("too late")));
}

TEST(DrawingProcesses, SayThatOneWasKilled) {
  DrawingProcesses pictures(9, 2, [] {
    return [draw = numbered()](int k) {
      if (k == 1) raise(SIGKILL);
      return draw(k);
    };
  });
  pictures.next();
  EXPECT_THAT([&] { pictures.next(); }, ThrowsMessage<UserError>(HasSubstr("killed")));
}

TEST(DrawingProcesses, EndWithTheirReader) {
  // pictures too large for a pipe: each process still waits for its first to be read
  DrawingProcesses pictures(1000, 3, [] { return [](int) { return PictureBytes(3000000); }; });
  EXPECT_EQ(pictures.next().size(), 3000000u);
}

}  // namespace
}  // namespace fricid::film
