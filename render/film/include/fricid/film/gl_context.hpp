// OpenGL without a window. GL is not linked: the library that makes the context is opened at run
// time, because libmujoco uses the GL functions of the one loaded in the process.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/enum_names.hpp"

namespace fricid::film {

/// kOsmesa: in memory, on the CPU. kEgl: surfaceless EGL, on a GPU if there is one.
enum class GlBackend { kOsmesa, kEgl };
constexpr std::string_view names(GlBackend) { return "osmesa|egl"; }

/// @throws UserError on another name
GlBackend backend_of(std::string_view name);

/// Address of a function of the current context, null when there is none.
using GlLookup = std::function<void*(const char*)>;

/// Renderer of the current context: "llvmpipe (LLVM 15.0.6, 256 bits)".
std::string renderer_of(const GlLookup& function);
/// Whether that is Mesa's software renderer on the CPU.
bool draws_by_processor(const GlLookup& function);

/// A current OpenGL context (compatibility profile, as mjr needs) of the thread that made it.
class GlContext {
 public:
  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  virtual GlBackend backend() const = 0;
  /// Address of a GL function, null when there is none.
  virtual void* function(const char* name) const = 0;
  GlLookup functions() const {
    return [this](const char* name) { return function(name); };
  }
  std::string renderer() const { return renderer_of(functions()); }

 protected:
  GlContext() = default;
};

/// Makes a context of one kind. Its own frame buffer has `width` x `height` pixels; arms are drawn
/// into another.
/// @throws UserError naming the library that is missing and its package, or when libmujoco in this
///         process is bound to the other kind already
std::unique_ptr<GlContext> make_gl_context(GlBackend backend, int width = 16, int height = 16);

/// The kind to use: `wanted`, else the environment variable FRICID_GL, else the first that works of
/// egl and osmesa. `wanted` and FRICID_GL: osmesa, egl, or empty.
/// @throws UserError as make_gl_context, or saying what to install when none works
std::unique_ptr<GlContext> make_gl_context(std::string_view wanted = {}, int width = 16,
                                           int height = 16);

/// Whether this process has made a context.
bool gl_was_used();

/// One line per kind: "osmesa: llvmpipe (...)" or "osmesa: libOSMesa.so.8 is missing; ...". Each is
/// tried in a process of its own.
std::vector<std::string> describe_gl_backends();

}  // namespace fricid::film
