#include "fricid/base/processes.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstring>
#include <optional>
#include <thread>
#include <utility>

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

/// Lets SIGPROF end this process after so much more of its processor time; zero: never.
void end_after(std::chrono::milliseconds time) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
  const std::chrono::microseconds rest = time - seconds;
  const itimerval once{{}, {seconds.count(), rest.count()}};
  ::setitimer(ITIMER_PROF, &once, nullptr);
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

TrialProcess::TrialProcess(std::function<void(const std::string&)> work) : work_(std::move(work)) {}

TrialProcess::~TrialProcess() { end(); }

Trial TrialProcess::operator()(const std::string& text, std::chrono::milliseconds most) {
  // A process forked from the owner must not listen to the owner's child.
  const bool used = child_ > 0 && owner_ == ::getpid();
  if (!used && !start()) return Trial::kEnded;
  const Trial trial = ask(text, most);
  if (trial != Trial::kCrashed || !used) return trial;
  return start() ? ask(text, most) : Trial::kEnded;
}

bool TrialProcess::start() {
  end();
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) return false;
  const pid_t child = ::fork();
  if (child == 0) serve(ends[1]);
  ::close(ends[1]);
  if (child < 0) {
    ::close(ends[0]);
    return false;
  }
  child_ = child;
  owner_ = ::getpid();
  messages_ = ends[0];
  return true;
}

// The child ends when nobody holds the other end of its socket.
void TrialProcess::end() {
  if (messages_ >= 0) ::close(messages_);
  if (child_ > 0 && owner_ == ::getpid()) {
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  messages_ = -1;
  child_ = 0;
}

void TrialProcess::serve(int messages) {
  const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int to : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null, to);
  // locks and pipes of the parent are not kept
  constexpr int kMessages = STDERR_FILENO + 1;
  ::dup2(messages, kMessages);
  ::close_range(kMessages + 1, ~0U, 0);
  for (const int signal : {SIGPROF, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
    ::signal(signal, SIG_DFL);
  for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, SIG_IGN);  // the parent ends us
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  std::chrono::milliseconds most{};
  std::string text(PATH_MAX, '\0');
  std::array<iovec, 2> parts{{{&most, sizeof most}, {text.data(), text.size()}}};
  for (;;) {
    const ssize_t size = ::readv(kMessages, parts.data(), static_cast<int>(parts.size())) -
                         static_cast<ssize_t>(sizeof most);
    if (size < 0) ::_exit(0);
    end_after(most);
    try {
      work_(text.substr(0, static_cast<std::size_t>(size)));
    } catch (const std::exception&) {  // a refusal is no crash
    }
    end_after({});
    const char done = 0;
    if (::send(kMessages, &done, sizeof done, MSG_NOSIGNAL) < 0) ::_exit(0);
  }
}

Trial TrialProcess::ask(const std::string& text, std::chrono::milliseconds most) {
  char done = 0;
  std::string message(sizeof most, '\0');
  std::memcpy(message.data(), &most, sizeof most);
  message += text;
  if (::send(messages_, message.data(), message.size(), MSG_NOSIGNAL) >= 0) {
    try {
      wait_until_readable(messages_);
    } catch (...) {
      end();  // its answer would be taken for the next one's
      throw;
    }
    if (::recv(messages_, &done, sizeof done, 0) > 0) return Trial::kEnded;
  }
  int status = 0;
  ::waitpid(std::exchange(child_, 0), &status, 0);
  const bool late = WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF;
  return late ? Trial::kTooLong : Trial::kCrashed;
}

void wait_until_readable(int descriptor) { wait_until(descriptor, POLLIN); }
void wait_until_writable(int descriptor) { wait_until(descriptor, POLLOUT); }

}  // namespace fricid
