// Progress on a terminal, in a file and when quiet; stopping by signals.
#include "fricid/base/progress.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <csignal>
#include <thread>
#include <vector>

namespace fricid {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::internal::CaptureStderr;
using ::testing::internal::GetCapturedStderr;

TEST(ProgressLine, TellsShareRateAndTimeLeft) {
  EXPECT_EQ(progress_line("simulate", 30, 120, 10, "rmse 0.12 N m"),
            "simulate  25 %  3/s  ETA 0:30  rmse 0.12 N m");
  EXPECT_EQ(progress_line("fit", 1, 3701, 1, ""), "fit   0 %  1/s  ETA 1:01:40");
  EXPECT_EQ(progress_line("fit", 5, 5, 2, ""), "fit 100 %  2.5/s  ETA 0:00");
}

/// Nothing done, no work at all, more than all: no NaN, no negative time.
TEST(ProgressLine, HoldsAtTheEnds) {
  EXPECT_EQ(progress_line("fit", 0, 10, 3, ""), "fit   0 %");
  EXPECT_EQ(progress_line("fit", 0, 0, 0, ""), "fit   0 %");
  EXPECT_EQ(progress_line("fit", 50, 10, 1, ""), "fit 100 %  50/s  ETA 0:00");
}

/// stderr of `action` when it is a terminal.
template <class Action>
std::string on_terminal(Action action) {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY);
  ::grantpt(master);
  ::unlockpt(master);
  const int terminal = ::open(::ptsname(master), O_RDWR | O_NOCTTY);
  const int before = ::dup(STDERR_FILENO);
  ::dup2(terminal, STDERR_FILENO);
  action();
  ::dup2(before, STDERR_FILENO);
  ::fcntl(master, F_SETFL, O_NONBLOCK);
  std::string text;
  char buffer[1024];
  for (ssize_t size; (size = ::read(master, buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(size));
  for (const int descriptor : {before, terminal, master}) ::close(descriptor);
  return text;
}

void work(int steps, std::chrono::milliseconds pause) {
  Progress progress("simulate", steps);
  for (int i = 0; i < steps; ++i) {
    std::this_thread::sleep_for(pause);
    progress.advance(1, i + 1 == steps ? "rmse 0.5" : "");
  }
}

TEST(Progress, DrawsABarOnATerminal) {
  const std::string text = on_terminal([] { work(10, std::chrono::milliseconds(30)); });
  EXPECT_THAT(text, AllOf(HasSubstr("\r[####"), HasSubstr("simulate"), HasSubstr("ETA"),
                          HasSubstr("100 %"), HasSubstr("rmse 0.5")));
  // redrawn in place: one line feed, at the end
  EXPECT_EQ(text.find('\n'), text.size() - 1);
}

TEST(Progress, QuietIsQuiet) {
  Progress::set_quiet(true);
  const std::string text = on_terminal([] { work(10, std::chrono::milliseconds(30)); });
  Progress::set_quiet(false);
  EXPECT_EQ(text, "");
}

TEST(Progress, ShortStagesWriteNothingToAFile) {
  CaptureStderr();
  work(10, std::chrono::milliseconds(30));
  EXPECT_EQ(GetCapturedStderr(), "");
}

TEST(Progress, WritesALineEveryTenSecondsToAFile) {
  CaptureStderr();
  work(105, std::chrono::milliseconds(100));
  const std::string text = GetCapturedStderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;  // at 10 s and at the end
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_THAT(text, AllOf(HasSubstr("simulate  9"), HasSubstr("simulate 100 %")));
}

TEST(Progress, ThreadsMayShareOne) {
  CaptureStderr();
  {
    Progress progress("simulate", 4000);
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&] {
        for (int i = 0; i < 1000; ++i) progress.advance(1, "figure");
      });
  }
  EXPECT_EQ(GetCapturedStderr(), "");
}

TEST(Progress, TellsAListenerInsteadOfStderr) {
  CaptureStderr();
  std::vector<Progress::Report> reports;
  std::string figure;
  Progress::set_listener([&](const Progress::Report& report) {
    reports.push_back(report);
    figure = report.figure;
  });
  Progress::set_quiet(true);  // which is for stderr
  work(10, std::chrono::milliseconds(30));
  Progress::set_quiet(false);
  Progress::set_listener({});
  EXPECT_EQ(GetCapturedStderr(), "");
  ASSERT_GE(reports.size(), 2u);
  EXPECT_LE(reports.size(), 5u);  // ten a second, and the end
  EXPECT_LT(reports.front().done, 10);
  EXPECT_EQ(reports.back().done, 10);
  EXPECT_EQ(reports.back().total, 10);
  EXPECT_GT(reports.back().seconds, reports.front().seconds);
  EXPECT_EQ(figure, "rmse 0.5");
}

TEST(StopRequest, IsMadeAndForgotten) {
  request_stop();
  EXPECT_TRUE(stop_requested());
  EXPECT_THROW(throw_if_stopped(), Stopped);
  forget_stop_request();
  EXPECT_FALSE(stop_requested());
  EXPECT_NO_THROW(throw_if_stopped());
}

/// In children: a request stays for the rest of the process.
class Stop : public ::testing::Test {
 protected:
  Stop() { ::testing::FLAGS_gtest_death_test_style = "threadsafe"; }
};
using StopDeathTest = Stop;

TEST_F(StopDeathTest, TheFirstSignalIsARequest) {
  EXPECT_FALSE(stop_requested());
  EXPECT_NO_THROW(throw_if_stopped());
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(
        {
          install_stop_handler();
          std::raise(signal);
          if (!stop_requested()) std::_Exit(1);
          try {
            throw_if_stopped();
          } catch (const Stopped&) {
            std::_Exit(130);
          }
          std::_Exit(2);
        },
        ::testing::ExitedWithCode(130), "");
  }
}

TEST_F(StopDeathTest, TheSecondSignalKills) {
  EXPECT_EXIT(
      {
        install_stop_handler();
        std::raise(SIGINT);
        std::raise(SIGINT);
        std::_Exit(0);
      },
      ::testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace fricid
