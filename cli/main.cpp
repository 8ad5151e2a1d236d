// The `fricid` program: the command line and, if built, the viewer.
#include <malloc.h>

#include "fricid/cli/command_line.hpp"
#ifdef FRICID_HAS_VIEWER
#include "fricid/viewer/viewer.hpp"
#endif

namespace {

#ifdef FRICID_HAS_VIEWER
void view(const fricid::cli::ViewOptions& options) {
  fricid::viewer::ViewerOptions how;
  how.renderer = options.renderer;
  how.screenshot = options.screenshot;
  how.at = options.at;
  how.script = options.script;
  fricid::viewer::view(options.target, how);
}
#else
constexpr std::nullptr_t view = nullptr;
#endif

/// A fit frees blocks of megabytes and asks for them again. They stay with the program: the kernel
/// would clear each of them anew, a fifth of a fit's time.
void keep_freed_blocks() {
  constexpr int kLargestKept = 1 << 28;  // [B]
  mallopt(M_MMAP_THRESHOLD, kLargestKept);
  mallopt(M_TRIM_THRESHOLD, -1);
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_blocks();
  return fricid::cli::run_command_line(argc, argv, view);
}
