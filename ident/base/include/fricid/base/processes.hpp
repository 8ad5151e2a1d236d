// Other programs that this one started, and how to end them.
#pragma once

namespace fricid {

/// Waits until a child process has ended. After Ctrl-C or SIGTERM it is asked to end too, and
/// killed when it has not done so within two seconds.
/// @return its status, as waitpid gives it
int wait_for_process(int id);

/// Waits until a descriptor can be read, or be written, or has come to its end.
/// @throws Stopped on Ctrl-C or SIGTERM
void wait_until_readable(int descriptor);
void wait_until_writable(int descriptor);

}  // namespace fricid
