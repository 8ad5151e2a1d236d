// Other programs that this one started, and how to end them.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace fricid {

/// Descriptors of a program; -1: /dev/null.
struct Streams {
  int input = -1, output = -1, errors = -1;
};

/// Starts a program from the PATH, without a shell. It is killed as soon as the calling thread
/// ends, however that happens, so that no program writes files after the end of ours.
/// @return its process id; 0 when it cannot be started
int start_program(const std::vector<std::string>& argv, const Streams& streams);

/// Waits until a child process has ended. After Ctrl-C or SIGTERM it is asked to end too, and
/// killed when it has not done so within two seconds.
/// @return its status, as waitpid gives it
int wait_for_process(int id);

/// How a piece of work in a child process ended: it returned or threw, it crashed, or it took too
/// long.
enum class Trial { kEnded, kCrashed, kTooLong };

/// Does work in a child process that prints nothing: the code of a library that crashes on some
/// files. The child's memory is a copy, so nothing that it changes is seen here. It is started by
/// the first piece of work and serves those that follow until one ends it, so that a piece costs
/// two messages rather than a process. What crashed it is tried again in a new one unless it was
/// new: an earlier piece may have damaged its memory.
class TrialProcess {
 public:
  /// @param work  what the child does with each text that it is given
  explicit TrialProcess(std::function<void(const std::string&)> work);
  ~TrialProcess();
  TrialProcess(const TrialProcess&) = delete;
  TrialProcess& operator=(const TrialProcess&) = delete;

  /// One thread at a time.
  /// @param most  processor time after which the child is killed, to the tick of the system
  ///              (up to 10 ms)
  /// @return kEnded also when no child can be made
  /// @throws Stopped on Ctrl-C or SIGTERM
  Trial operator()(const std::string& text, std::chrono::milliseconds most);

 private:
  bool start();
  void end();
  [[noreturn]] void serve(int messages);
  Trial ask(const std::string& text, std::chrono::milliseconds most);

  std::function<void(const std::string&)> work_;
  int child_ = 0, owner_ = 0, messages_ = -1;
};

/// Waits until a descriptor can be read, or be written, or has come to its end.
/// @throws Stopped on Ctrl-C or SIGTERM
void wait_until_readable(int descriptor);
void wait_until_writable(int descriptor);

}  // namespace fricid
