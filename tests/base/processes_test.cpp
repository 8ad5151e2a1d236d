#include "fricid/base/processes.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "fricid/base/progress.hpp"

namespace fricid {
namespace {

using namespace std::chrono_literals;

/// A shell that runs `command`.
pid_t start(const char* command) {
  const pid_t id = ::fork();
  if (id == 0) {
    ::execl("/bin/sh", "sh", "-c", command, nullptr);
    ::_exit(127);
  }
  return id;
}

TEST(Processes, ProgramsAreStartedWithTheStreamsGiven) {
  int out[2], in[2];
  ASSERT_EQ(::pipe2(out, O_CLOEXEC) + ::pipe2(in, O_CLOEXEC), 0);
  const int id = start_program({"sh", "-c", "cat; echo \"$1\"", "sh", "an 'argument'"},
                               {.input = in[0], .output = out[1]});
  ASSERT_GT(id, 0);
  ::close(in[0]);
  ::close(out[1]);
  ASSERT_EQ(::write(in[1], "input ", 6), 6);
  ::close(in[1]);
  std::string said(100, '\0');
  std::size_t size = 0;
  for (ssize_t got; (got = ::read(out[0], said.data() + size, 100 - size)) > 0;)
    size += static_cast<std::size_t>(got);
  ::close(out[0]);
  EXPECT_EQ(said.substr(0, size), "input an 'argument'\n");
  EXPECT_EQ(wait_for_process(id), 0);
  EXPECT_EQ(start_program({"/no/such/program"}, {}), 0);
}

// The descriptor of a pipe is open as long as the program lives.
TEST(Processes, ProgramsEndWithTheProcessThatStartedThem) {
  int alive[2];
  ASSERT_EQ(::pipe2(alive, O_CLOEXEC), 0);
  const pid_t starter = ::fork();
  if (starter == 0) {
    start_program({"sleep", "1000"}, {.output = alive[1]});
    std::raise(SIGKILL);
  }
  ::close(alive[1]);
  ::waitpid(starter, nullptr, 0);
  char none = 0;
  pollfd end{alive[0], POLLIN, 0};
  ASSERT_EQ(::poll(&end, 1, 20'000), 1) << "the program lives on";
  EXPECT_EQ(::read(alive[0], &none, 1), 0);
  ::close(alive[0]);
}

TEST(Processes, GivesTheStatusOfWhatEnded) {
  EXPECT_EQ(WEXITSTATUS(wait_for_process(start("exit 3"))), 3);
  EXPECT_EQ(WTERMSIG(wait_for_process(start("kill -9 $$"))), 9);
}

/// Work that does what a text says, and how often it was done in this process and its copies.
struct Work {
  int done = 0;

  void operator()(const std::string& text) {
    ++done;
    if (text == "throw") throw std::runtime_error("refused");
    if (text == "crash") std::raise(SIGSEGV);
    if (text == "abort" || (text == "abort the second time" && done > 1)) std::abort();
    const auto spent = [began = std::clock()] {
      return 1000ms * (std::clock() - began) / CLOCKS_PER_SEC;
    };
    while (text == "take 50 ms" && spent() < 50ms) {
    }
    for (volatile bool on = text == "go on for ever"; on;) {
    }
  }
};

TEST(Processes, WorkOfAChildLeavesUsAsWeWere) {
  Work work;
  TrialProcess trial(std::ref(work));
  EXPECT_EQ(trial("nothing", 1s), Trial::kEnded);
  EXPECT_EQ(trial("throw", 1s), Trial::kEnded);
  EXPECT_EQ(trial("crash", 1s), Trial::kCrashed);
  EXPECT_EQ(trial("nothing", 1s), Trial::kEnded);
  EXPECT_EQ(trial("abort", 1s), Trial::kCrashed);
  EXPECT_EQ(trial("go on for ever", 1s), Trial::kTooLong);
  EXPECT_EQ(trial("nothing", 1s), Trial::kEnded);
  EXPECT_EQ(work.done, 0);
}

/// Processor time of the children that have ended.
std::chrono::microseconds time_of_children() {
  rusage spent{};
  ::getrusage(RUSAGE_CHILDREN, &spent);
  return std::chrono::seconds(spent.ru_utime.tv_sec + spent.ru_stime.tv_sec) +
         std::chrono::microseconds(spent.ru_utime.tv_usec + spent.ru_stime.tv_usec);
}

TEST(Processes, AChildHasTheTimeOfEachPieceOfWork) {
  Work work;
  TrialProcess trial(std::ref(work));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(trial("take 50 ms", 100ms), Trial::kEnded);
  const auto before = time_of_children();
  EXPECT_EQ(trial("go on for ever", 100ms), Trial::kTooLong);
  EXPECT_LT(time_of_children() - before, 500ms);
}

TEST(Processes, AChildIsNotBlamedForItsEarlierWork) {
  Work work;
  TrialProcess trial(std::ref(work));
  EXPECT_EQ(trial("nothing", 1s), Trial::kEnded);
  EXPECT_EQ(trial("abort the second time", 1s), Trial::kEnded);
}

TEST(Processes, AChildHoldsNothingOfOurs) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  Work work;
  TrialProcess trial(std::ref(work));
  ASSERT_EQ(trial("nothing", 1s), Trial::kEnded);
  ::close(pipe[1]);
  pollfd end{pipe[0], POLLIN, 0};
  EXPECT_EQ(::poll(&end, 1, 5000), 1) << "the child keeps the pipe open";
  ::close(pipe[0]);
}

/// For a child, since a request to stop cannot be taken back: how `command` ended after one that
/// came when the shell was through with `first`.
int signal_after_a_request_to_stop(const std::string& first, const std::string& command) {
  install_stop_handler();
  const std::string ready = fmt::format("{}/fricid_ready_{}", testing::TempDir(), ::getpid());
  const pid_t id = start(fmt::format("{}; : > {}; {}", first, ready, command).c_str());
  while (!std::filesystem::exists(ready)) ::usleep(1000);
  std::filesystem::remove(ready);
  std::raise(SIGTERM);
  const int status = wait_for_process(id);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST(Processes, ARequestToStopEndsThemToo) {
  EXPECT_EXIT(std::exit(signal_after_a_request_to_stop(":", "exec sleep 1000")),
              testing::ExitedWithCode(SIGTERM), "");
}

TEST(Processes, OneThatDoesNotListenIsKilled) {
  EXPECT_EXIT(std::exit(signal_after_a_request_to_stop("trap '' TERM", "sleep 10")),
              testing::ExitedWithCode(SIGKILL), "");
}

/// For a child: whether waiting for a pipe that nobody writes ends with a request to stop.
int waiting_stops() {
  install_stop_handler();
  int ends[2];
  if (::pipe(ends) != 0) return 2;
  std::raise(SIGTERM);
  try {
    wait_until_readable(ends[0]);
  } catch (const Stopped&) {
    return 0;
  }
  return 1;
}

TEST(Processes, ARequestToStopEndsTheWaitForAPipe) {
  EXPECT_EXIT(std::exit(waiting_stops()), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace fricid
