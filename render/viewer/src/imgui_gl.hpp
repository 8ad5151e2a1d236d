#pragma once

#include <imgui.h>

#include <memory>

#include "fricid/film/gl_context.hpp"
#include "fricid/film/image.hpp"

namespace fricid::viewer {

/// Draws the lists of ImGui, by the fixed functions of OpenGL, which every context of this
/// program has. Nothing of GL is linked: `function` finds the calls. Use it on the thread of a
/// current context and an ImGui context.
class ImguiGl {
 public:
  explicit ImguiGl(const film::GlLookup& function);
  ~ImguiGl();
  ImguiGl(const ImguiGl&) = delete;
  ImguiGl& operator=(const ImguiGl&) = delete;

  /// A texture with the picture, the same one every time.
  ImTextureID show(const film::Image& picture);
  /// Draws into the window's frame buffer.
  void draw(const ImDrawData& data);
  /// What is in the window's frame buffer.
  film::Image read(int width, int height);
  /// GL_NO_ERROR (0) or the first error since the last call.
  unsigned error();

 private:
  struct Calls;
  unsigned make_texture() const;

  std::unique_ptr<Calls> gl_;
  unsigned font_ = 0, picture_ = 0;
};

}  // namespace fricid::viewer
