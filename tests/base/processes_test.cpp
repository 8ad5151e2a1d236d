#include "fricid/base/processes.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "fricid/base/progress.hpp"

namespace fricid {
namespace {

/// A shell that runs `command`.
pid_t start(const char* command) {
  const pid_t id = ::fork();
  if (id == 0) {
    ::execl("/bin/sh", "sh", "-c", command, nullptr);
    ::_exit(127);
  }
  return id;
}

TEST(Processes, GivesTheStatusOfWhatEnded) {
  EXPECT_EQ(WEXITSTATUS(wait_for_process(start("exit 3"))), 3);
  EXPECT_EQ(WTERMSIG(wait_for_process(start("kill -9 $$"))), 9);
}

/// For a child, since a request to stop cannot be taken back: how `command` ended after one.
int signal_after_a_request_to_stop(const char* command) {
  install_stop_handler();
  const pid_t id = start(command);
  ::usleep(200'000);  // until the shell has set its trap
  std::raise(SIGTERM);
  const int status = wait_for_process(id);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST(Processes, ARequestToStopEndsThemToo) {
  EXPECT_EXIT(std::exit(signal_after_a_request_to_stop("exec sleep 1000")),
              testing::ExitedWithCode(SIGTERM), "");
}

TEST(Processes, OneThatDoesNotListenIsKilled) {
  EXPECT_EXIT(std::exit(signal_after_a_request_to_stop("trap '' TERM; sleep 10")),
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
