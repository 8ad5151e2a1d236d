// OSMesa: Mesa's software rasteriser drawing into memory of the program.
#include <array>
#include <cstdint>
#include <vector>

#include "fricid/base/error.hpp"
#include "gl_backends.hpp"
#include "shared_library.hpp"

namespace fricid::film {
namespace {

// <GL/osmesa.h>
constexpr int kFormat = 0x22, kDepthBits = 0x30, kStencilBits = 0x31, kProfile = 0x33;
constexpr int kCompatProfile = 0x35, kRgba = 0x1908, kUnsignedByte = 0x1401;
using Handle = void*;

class OsmesaContext : public GlContext {
 public:
  OsmesaContext(int width, int height)
      : library_("libOSMesa.so.8", "libosmesa6"),
        buffer_(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    const std::array<int, 9> attributes{kFormat, kRgba,    kDepthBits,     24, kStencilBits,
                                        8,       kProfile, kCompatProfile, 0};
    context_ = library_.function<Handle(const int*, Handle)>("OSMesaCreateContextAttribs")(
        attributes.data(), nullptr);
    if (!context_) throw UserError("OSMesa cannot make a context");
    if (!library_.function<unsigned char(Handle, void*, int, int, int)>("OSMesaMakeCurrent")(
            context_, buffer_.data(), kUnsignedByte, width, height)) {
      destroy();
      throw UserError("OSMesa cannot make its context current");
    }
    library_.publish();
  }
  ~OsmesaContext() override { destroy(); }

  GlBackend backend() const override { return GlBackend::kOsmesa; }
  void* function(const char* name) const override {
    return library_.function<void*(const char*)>("OSMesaGetProcAddress")(name);
  }

 private:
  void destroy() { library_.function<void(Handle)>("OSMesaDestroyContext")(context_); }

  SharedLibrary library_;
  std::vector<std::uint8_t> buffer_;
  Handle context_ = nullptr;
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context(int width, int height) {
  return std::make_unique<OsmesaContext>(width, height);
}

}  // namespace fricid::film
