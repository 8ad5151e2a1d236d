// EGL without a window system: a GPU by its device, else Mesa's surfaceless platform.
#include <array>
#include <cstdint>
#include <string_view>

#include "fricid/base/error.hpp"
#include "gl_backends.hpp"
#include "shared_library.hpp"

namespace fricid::film {
namespace {

// <EGL/egl.h>, <EGL/eglext.h>
using Handle = void*;
using Boolean = unsigned;
constexpr std::int32_t kNone = 0x3038, kSurfaceType = 0x3033, kPbufferBit = 0x1,
                       kRenderableType = 0x3040, kOpenglBit = 0x8, kRed = 0x3024, kGreen = 0x3023,
                       kBlue = 0x3022, kDepth = 0x3025, kStencil = 0x3026, kWidth = 0x3057,
                       kHeight = 0x3056, kExtensions = 0x3055;
constexpr unsigned kOpenglApi = 0x30A2, kPlatformDevice = 0x313F, kPlatformSurfaceless = 0x31DD;

class EglContext : public GlContext {
 public:
  EglContext(int width, int height)
      : library_("libEGL.so.1", "libegl1 libegl-mesa0 libgl1-mesa-dri") {
    if (!open_device() && !open_surfaceless())
      throw UserError("EGL finds no device to draw with; install libegl-mesa0 libgl1-mesa-dri");
    try {
      make_context(width, height);
    } catch (...) {
      close();
      throw;
    }
    library_.publish();
  }
  ~EglContext() override { close(); }

  GlBackend backend() const override { return GlBackend::kEgl; }
  void* function(const char* name) const override {
    return library_.function<void*(const char*)>("eglGetProcAddress")(name);
  }

 private:
  bool initialise(Handle display) {
    if (!display) return false;
    if (!library_.function<Boolean(Handle, int*, int*)>("eglInitialize")(display, nullptr, nullptr))
      return false;
    display_ = display;
    return true;
  }

  Handle platform_display(unsigned platform, Handle native) const {
    auto* get = reinterpret_cast<Handle (*)(unsigned, Handle, const std::int32_t*)>(
        function("eglGetPlatformDisplayEXT"));
    return get ? get(platform, native, nullptr) : nullptr;
  }

  bool has_client_extension(std::string_view name) const {
    const char* all =
        library_.function<const char*(Handle, int)>("eglQueryString")(nullptr, kExtensions);
    return all && std::string_view(all).find(name) != std::string_view::npos;
  }

  // The first device that is not Mesa's own software device.
  bool open_device() {
    if (!has_client_extension("EGL_EXT_platform_device")) return false;
    auto* query = reinterpret_cast<Boolean (*)(int, Handle*, int*)>(function("eglQueryDevicesEXT"));
    auto* describe =
        reinterpret_cast<const char* (*)(Handle, int)>(function("eglQueryDeviceStringEXT"));
    std::array<Handle, 16> devices{};
    int count = 0;
    if (!query || !describe || !query(static_cast<int>(devices.size()), devices.data(), &count))
      return false;
    for (int i = 0; i < count; ++i) {
      Handle device = devices[static_cast<std::size_t>(i)];
      const char* extensions = describe(device, kExtensions);
      const bool software =
          extensions &&
          std::string_view(extensions).find("EGL_MESA_device_software") != std::string_view::npos;
      if (!software && initialise(platform_display(kPlatformDevice, device))) return true;
    }
    return false;
  }

  bool open_surfaceless() {
    return has_client_extension("EGL_MESA_platform_surfaceless") &&
           initialise(platform_display(kPlatformSurfaceless, nullptr));
  }

  void make_context(int width, int height) {
    const std::array<std::int32_t, 15> wanted{
        kSurfaceType, kPbufferBit, kRenderableType, kOpenglBit, kRed,     8, kGreen, 8,
        kBlue,        8,           kDepth,          24,         kStencil, 8, kNone};
    Handle config = nullptr;
    int count = 0;
    library_.function<Boolean(Handle, const std::int32_t*, Handle*, int, int*)>("eglChooseConfig")(
        display_, wanted.data(), &config, 1, &count);
    if (count < 1) throw UserError("EGL offers no OpenGL with 8-bit colours and 24-bit depth");
    library_.function<Boolean(unsigned)>("eglBindAPI")(kOpenglApi);
    context_ = library_.function<Handle(Handle, Handle, Handle, const std::int32_t*)>(
        "eglCreateContext")(display_, config, nullptr, nullptr);
    if (!context_) throw UserError("EGL cannot make an OpenGL context");

    const std::array<std::int32_t, 5> size{kWidth, width, kHeight, height, kNone};
    surface_ = library_.function<Handle(Handle, Handle, const std::int32_t*)>(
        "eglCreatePbufferSurface")(display_, config, size.data());
    if (!make_current(surface_, context_)) throw UserError("EGL cannot make its context current");
  }

  Boolean make_current(Handle surface, Handle context) const {
    return library_.function<Boolean(Handle, Handle, Handle, Handle)>("eglMakeCurrent")(
        display_, surface, surface, context);
  }

  void close() {
    make_current(nullptr, nullptr);
    if (surface_)
      library_.function<Boolean(Handle, Handle)>("eglDestroySurface")(display_, surface_);
    if (context_)
      library_.function<Boolean(Handle, Handle)>("eglDestroyContext")(display_, context_);
  }

  SharedLibrary library_;
  Handle display_ = nullptr, surface_ = nullptr, context_ = nullptr;
};

}  // namespace

std::unique_ptr<GlContext> make_egl_context(int width, int height) {
  return std::make_unique<EglContext>(width, height);
}

}  // namespace fricid::film
