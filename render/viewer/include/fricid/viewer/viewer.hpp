// The interactive viewer.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace fricid::viewer {

/// kReplay: the open loops of a run folder, with scrubbing. kLive: the true arm under the scene's
/// friction, or that of an identified model, simulated in real time.
enum class Mode { kReplay, kLive };

struct ViewerOptions {
  std::string renderer{};              ///< off screen: egl, osmesa or empty, as film
  std::filesystem::path screenshot{};  ///< write this PNG and end; no display needed
  std::optional<double> at{};      ///< time of the screenshot [s]; none: replay's middle, live 5 s
  std::filesystem::path script{};  ///< commands to run and then end, see docs/rendering.md
  bool offscreen = false;          ///< run the script without a window, as without a display
  int width = 1280, height = 800;
};

/// Opens a run folder, a scene or a model file and shows it until the window is closed.
/// @throws UserError when the target cannot be shown, there is no display, or a command of the
///         script is wrong
void view(const std::filesystem::path& target, const ViewerOptions& options);

}  // namespace fricid::viewer
