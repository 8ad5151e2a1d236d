// `fricid view`.
#include "commands.hpp"
#include "fricid/base/error.hpp"
#ifdef FRICID_HAS_VIEWER
#include "fricid/viewer/viewer.hpp"
#endif

namespace fricid::cli {

#ifdef FRICID_HAS_VIEWER
Verdict view(const ViewOptions& options) {
  viewer::ViewerOptions how;
  how.renderer = options.renderer;
  how.screenshot = options.screenshot;
  how.at = options.at;
  how.script = options.script;
  viewer::view(options.target, how);
  return Verdict::kDone;
}
#else
Verdict view(const ViewOptions&) {
  throw UserError(
      "this program was built without the viewer; install libglfw3-dev and libimgui-dev, then "
      "configure and build again");
}
#endif

}  // namespace fricid::cli
