// Other programs that this one started, and how to end them.
#pragma once

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

/// How work in a child process ended: it returned or threw, it crashed, or it took too long.
enum class Trial { kEnded, kCrashed, kTooLong };

/// Does `work` in a child process that prints nothing: the code of a library that crashes on some
/// files. The child's memory is a copy, so nothing that it changes is seen here.
/// @param most_s  processor time [s] after which the child is killed
/// @return kEnded also when no child can be made
Trial try_in_child(const std::function<void()>& work, int most_s);

/// Waits until a descriptor can be read, or be written, or has come to its end.
/// @throws Stopped on Ctrl-C or SIGTERM
void wait_until_readable(int descriptor);
void wait_until_writable(int descriptor);

}  // namespace fricid
