// The `fricid` program: the command line and, if built, the viewer.
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

}  // namespace

int main(int argc, char** argv) { return fricid::cli::run_command_line(argc, argv, view); }
