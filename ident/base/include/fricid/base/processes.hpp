// Other programs that this one started, and how to end them.
#pragma once

#include <string>
#include <vector>

namespace fricid {

/// Descriptors of a program; -1: /dev/null.
struct Streams {
  int input = -1, output = -1, errors = -1;
};

/// Starts a program from the PATH, without a shell. It is killed when the calling thread ends,
/// however that happens: a program that outlived us would write files that nobody waits for.
/// @return its process id; 0 when it cannot be started
int start_program(const std::vector<std::string>& argv, const Streams& streams);

/// Waits until a child process has ended. After Ctrl-C or SIGTERM it is asked to end too, and
/// killed when it has not done so within two seconds.
/// @return its status, as waitpid gives it
int wait_for_process(int id);

/// Waits until a descriptor can be read, or be written, or has come to its end.
/// @throws Stopped on Ctrl-C or SIGTERM
void wait_until_readable(int descriptor);
void wait_until_writable(int descriptor);

}  // namespace fricid
