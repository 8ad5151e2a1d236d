#include "fricid/base/processes.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
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

/// In the new process: ends with the thread that started it.
void die_with(pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);
}

/// In the new process: becomes the program, or tells `failure` why not.
[[noreturn]] void become(char* const* arguments, const Streams& streams, pid_t parent,
                         int failure) {
  die_with(parent);
  const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const std::array<int, 3> from{streams.input, streams.output, streams.errors};
  for (int to = 0; to < 3; ++to) {
    const int given = from[static_cast<std::size_t>(to)];
    ::dup2(given < 0 ? null : given, to);
  }
  ::execvp(arguments[0], arguments);
  const int reason = errno;
  [[maybe_unused]] const ssize_t told = ::write(failure, &reason, sizeof reason);
  ::_exit(127);
}

}  // namespace

int start_program(const std::vector<std::string>& argv, const Streams& streams) {
  std::vector<char*> arguments;
  for (const std::string& argument : argv)
    arguments.push_back(const_cast<char*>(argument.c_str()));  // NOLINT: not written to
  arguments.push_back(nullptr);
  std::array<int, 2> failure{};
  if (::pipe2(failure.data(), O_CLOEXEC) != 0) return 0;
  const pid_t parent = ::getpid(), child = ::fork();
  if (child == 0) become(arguments.data(), streams, parent, failure[1]);
  ::close(failure[1]);
  int reason = 0;
  const bool failed = child < 0 || ::read(failure[0], &reason, sizeof reason) > 0;
  ::close(failure[0]);
  if (!failed) return child;
  if (child > 0) ::waitpid(child, nullptr, 0);
  return 0;
}

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

Trial try_in_child(const std::function<void()>& work, int most_s) {
  const pid_t parent = ::getpid(), child = ::fork();
  if (child == 0) {
    die_with(parent);
    const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    ::dup2(null, STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
    const auto most = static_cast<rlim_t>(most_s);
    const rlimit time{most, most + 1}, no_core{0, 0};
    ::setrlimit(RLIMIT_CPU, &time);
    ::setrlimit(RLIMIT_CORE, &no_core);
    for (const int signal : {SIGXCPU, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
      ::signal(signal, SIG_DFL);
    try {
      work();
    } catch (const std::exception&) {
      ::_exit(0);
    }
    ::_exit(0);
  }
  if (child < 0) return Trial::kEnded;
  const int status = wait_for_process(child);
  throw_if_stopped();
  if (status == 0) return Trial::kEnded;
  const bool late =
      WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
  return late ? Trial::kTooLong : Trial::kCrashed;
}

void wait_until_readable(int descriptor) { wait_until(descriptor, POLLIN); }
void wait_until_writable(int descriptor) { wait_until(descriptor, POLLOUT); }

}  // namespace fricid
