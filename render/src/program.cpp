#include "program.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "fricid/base/processes.hpp"
#include "fricid/base/progress.hpp"

namespace fricid::render {

ProgramResult run_program(const std::vector<std::string>& argv) {
  ProgramResult result;
  std::array<int, 2> errors{};
  if (pipe2(errors.data(), O_CLOEXEC) != 0) return result;

  const int child = start_program(argv, {.errors = errors[1]});
  close(errors[1]);
  result.found = child > 0;

  std::array<char, 4096> part{};
  for (ssize_t got = 0; result.found;) {
    try {
      wait_until_readable(errors[0]);
    } catch (const Stopped&) {
      break;
    }
    got = read(errors[0], part.data(), part.size());
    if (got > 0) result.errors.append(part.data(), static_cast<std::size_t>(got));
    if (got == 0 || (got < 0 && errno != EINTR)) break;
  }
  close(errors[0]);
  if (!result.found) return result;

  const int status = wait_for_process(child);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  return result;
}

}  // namespace fricid::render
