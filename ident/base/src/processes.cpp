#include "fricid/base/processes.hpp"

#include <poll.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <optional>
#include <thread>

#include "fricid/base/progress.hpp"

namespace fricid {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kLook = 50;                     // [ms] between looks at whether to stop
constexpr std::chrono::seconds kPatience{2};  // between asking and killing

void wait_until(int descriptor, short event) {
  for (;;) {
    throw_if_stopped();
    pollfd wanted{descriptor, event, 0};
    const int found = ::poll(&wanted, 1, kLook);
    if (found > 0 || (found < 0 && errno != EINTR)) return;
  }
}

}  // namespace

int wait_for_process(int id) {
  std::optional<Clock::time_point> asked;
  auto look = std::chrono::milliseconds(1);
  for (int status = 0;;) {
    const pid_t ended = ::waitpid(id, &status, WNOHANG);
    if (ended == id || (ended < 0 && errno != EINTR)) return status;
    if (stop_requested() && !asked) {
      ::kill(id, SIGTERM);
      asked = Clock::now();
    }
    if (asked && Clock::now() - *asked > kPatience) ::kill(id, SIGKILL);
    std::this_thread::sleep_for(look);
    look = std::min(2 * look, std::chrono::milliseconds(kLook));
  }
}

void wait_until_readable(int descriptor) { wait_until(descriptor, POLLIN); }
void wait_until_writable(int descriptor) { wait_until(descriptor, POLLOUT); }

}  // namespace fricid
