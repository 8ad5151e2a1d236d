// Pictures drawn by several processes, since a GL context serves one thread, and software rendering
// does much of its work on that thread.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace fricid::film {

using PictureBytes = std::vector<std::uint8_t>;

/// Draws picture k, encoded for its reader.
using Draw = std::function<PictureBytes(int)>;

/// Pictures 0, 1, ... in order; each process draws every n-th of them, some ahead of `next`.
/// GL drivers do not survive a fork: if this process has used GL, it draws all pictures itself.
class DrawingProcesses {
 public:
  /// @param jobs  processes; <= 0: one per core
  /// @param open  called in each process, which may make its GL context there
  DrawingProcesses(int count, int jobs, const std::function<Draw()>& open);
  ~DrawingProcesses();
  DrawingProcesses(const DrawingProcesses&) = delete;
  DrawingProcesses& operator=(const DrawingProcesses&) = delete;

  /// @throws UserError as `open` and its Draw do, or when a process was killed; Stopped
  PictureBytes next();

 private:
  DrawingProcesses() = default;

  struct Process {
    pid_t id;
    int pipe;
  };
  std::vector<Process> processes_;
  Draw draw_here_;  ///< empty if processes draw
  int next_ = 0;
};

}  // namespace fricid::film
