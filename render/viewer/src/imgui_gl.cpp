#include "imgui_gl.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>

#include "fricid/film/gl_calls.hpp"

namespace fricid::viewer {
namespace {

using film::kBlend;
using film::kFrontAndBack;
using film::kLighting;
using film::kOneMinusSrcAlpha;
using film::kScissorTest;
using film::kSrcAlpha;

// <GL/gl.h>
enum : unsigned {
  kTriangles = 0x0004,
  kTexture2d = 0x0DE1,
  kCullFace = 0x0B44,
  kDepthTest = 0x0B71,
  kStencilTest = 0x0B90,
  kFog = 0x0B60,
  kNormalize = 0x0BA1,
  kColorMaterial = 0x0B57,
  kVertexArray = 0x8074,
  kColorArray = 0x8076,
  kNormalArray = 0x8075,
  kTextureCoordArray = 0x8078,
  kModelview = 0x1700,
  kProjection = 0x1701,
  kFloat = 0x1406,
  kUnsignedByte = 0x1401,
  kUnsignedShort = 0x1403,
  kUnsignedInt = 0x1405,
  kRgb = 0x1907,
  kRgba = 0x1908,
  kLinear = 0x2601,
  kTextureMagFilter = 0x2800,
  kTextureMinFilter = 0x2801,
  kTextureWrapS = 0x2802,
  kTextureWrapT = 0x2803,
  kClampToEdge = 0x812F,
  kUnpackAlignment = 0x0CF5,
  kPackAlignment = 0x0D05,
  kTextureEnv = 0x2300,
  kTextureEnvMode = 0x2200,
  kModulate = 0x2100,
  kColorBufferBit = 0x4000,
  kFramebuffer = 0x8D40,
  kFill = 0x1B02,
  kAllAttributes = 0x000FFFFF,
  kAllClientAttributes = 0xFFFFFFFF
};

const void* at_byte(const void* begin, std::size_t offset) {
  return static_cast<const std::byte*>(begin) + offset;
}

/// ImGui passes the name of a texture as a pointer, which is never dereferenced.
ImTextureID texture_id(unsigned name) {
  return reinterpret_cast<ImTextureID>(  // NOLINT(performance-no-int-to-ptr): see above
      static_cast<std::uintptr_t>(name));
}

}  // namespace

struct ImguiGl::Calls {
  void (*Enable)(unsigned);
  void (*Disable)(unsigned);
  void (*EnableClientState)(unsigned);
  void (*DisableClientState)(unsigned);
  void (*BlendFunc)(unsigned, unsigned);
  void (*PolygonMode)(unsigned, unsigned);
  void (*Viewport)(int, int, int, int);
  void (*Scissor)(int, int, int, int);
  void (*MatrixMode)(unsigned);
  void (*LoadIdentity)();
  void (*Ortho)(double, double, double, double, double, double);
  void (*VertexPointer)(int, unsigned, int, const void*);
  void (*TexCoordPointer)(int, unsigned, int, const void*);
  void (*ColorPointer)(int, unsigned, int, const void*);
  void (*DrawElements)(unsigned, int, unsigned, const void*);
  void (*GenTextures)(int, unsigned*);
  void (*DeleteTextures)(int, const unsigned*);
  void (*BindTexture)(unsigned, unsigned);
  void (*TexParameteri)(unsigned, unsigned, int);
  void (*TexEnvi)(unsigned, unsigned, int);
  void (*TexImage2D)(unsigned, int, int, int, int, int, unsigned, unsigned, const void*);
  void (*PixelStorei)(unsigned, int);
  void (*ReadPixels)(int, int, int, int, unsigned, unsigned, void*);
  void (*ClearColor)(float, float, float, float);
  void (*Clear)(unsigned);
  void (*UseProgram)(unsigned);
  void (*BindFramebuffer)(unsigned, unsigned);
  void (*PushAttrib)(unsigned);
  void (*PopAttrib)();
  void (*PushClientAttrib)(unsigned);
  void (*PopClientAttrib)();
  unsigned (*GetError)();

  explicit Calls(const film::GlLookup& function) {
    const auto find = [&](auto& call, const char* name) { film::find_call(function, call, name); };
    find(Enable, "glEnable");
    find(Disable, "glDisable");
    find(EnableClientState, "glEnableClientState");
    find(DisableClientState, "glDisableClientState");
    find(BlendFunc, "glBlendFunc");
    find(PolygonMode, "glPolygonMode");
    find(Viewport, "glViewport");
    find(Scissor, "glScissor");
    find(MatrixMode, "glMatrixMode");
    find(LoadIdentity, "glLoadIdentity");
    find(Ortho, "glOrtho");
    find(VertexPointer, "glVertexPointer");
    find(TexCoordPointer, "glTexCoordPointer");
    find(ColorPointer, "glColorPointer");
    find(DrawElements, "glDrawElements");
    find(GenTextures, "glGenTextures");
    find(DeleteTextures, "glDeleteTextures");
    find(BindTexture, "glBindTexture");
    find(TexParameteri, "glTexParameteri");
    find(TexEnvi, "glTexEnvi");
    find(TexImage2D, "glTexImage2D");
    find(PixelStorei, "glPixelStorei");
    find(ReadPixels, "glReadPixels");
    find(ClearColor, "glClearColor");
    find(Clear, "glClear");
    find(UseProgram, "glUseProgram");
    find(BindFramebuffer, "glBindFramebuffer");
    find(PushAttrib, "glPushAttrib");
    find(PopAttrib, "glPopAttrib");
    find(PushClientAttrib, "glPushClientAttrib");
    find(PopClientAttrib, "glPopClientAttrib");
    find(GetError, "glGetError");
  }
};

ImguiGl::ImguiGl(const film::GlLookup& function) : gl_(std::make_unique<Calls>(function)) {
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  fonts.GetTexDataAsRGBA32(&pixels, &width, &height);
  font_ = make_texture();
  gl_->TexImage2D(kTexture2d, 0, kRgba, width, height, 0, kRgba, kUnsignedByte, pixels);
  fonts.SetTexID(texture_id(font_));
  picture_ = make_texture();
}

ImguiGl::~ImguiGl() {
  gl_->DeleteTextures(1, &font_);
  gl_->DeleteTextures(1, &picture_);
}

unsigned ImguiGl::make_texture() const {
  unsigned texture = 0;
  gl_->GenTextures(1, &texture);
  gl_->BindTexture(kTexture2d, texture);
  for (const unsigned filter : {kTextureMinFilter, kTextureMagFilter})
    gl_->TexParameteri(kTexture2d, filter, kLinear);
  for (const unsigned wrap : {kTextureWrapS, kTextureWrapT})
    gl_->TexParameteri(kTexture2d, wrap, kClampToEdge);
  return texture;
}

ImTextureID ImguiGl::show(const film::Image& picture) {
  gl_->BindTexture(kTexture2d, picture_);
  gl_->PixelStorei(kUnpackAlignment, 1);
  gl_->TexImage2D(kTexture2d, 0, kRgb, picture.width, picture.height, 0, kRgb, kUnsignedByte,
                  picture.rgb.data());
  return texture_id(picture_);
}

void ImguiGl::draw(const ImDrawData& data) {
  const int width = static_cast<int>(data.DisplaySize.x * data.FramebufferScale.x);
  const int height = static_cast<int>(data.DisplaySize.y * data.FramebufferScale.y);

  // saves the state of MuJoCo's renderer, to be restored
  gl_->BindFramebuffer(kFramebuffer, 0);  // first: its draw buffer is part of the state
  gl_->PushAttrib(kAllAttributes);
  gl_->PushClientAttrib(kAllClientAttributes);
  gl_->UseProgram(0);
  for (const unsigned off :
       std::initializer_list<unsigned>{kCullFace, kDepthTest, kStencilTest, kLighting, kFog,
                                       kNormalize, kColorMaterial, kScissorTest})
    gl_->Disable(off);
  for (const unsigned on : std::initializer_list<unsigned>{kBlend, kTexture2d}) gl_->Enable(on);
  gl_->BlendFunc(kSrcAlpha, kOneMinusSrcAlpha);
  gl_->PolygonMode(kFrontAndBack, kFill);
  gl_->TexEnvi(kTextureEnv, kTextureEnvMode, kModulate);
  gl_->DisableClientState(kNormalArray);
  for (const unsigned array : {kVertexArray, kColorArray, kTextureCoordArray})
    gl_->EnableClientState(array);
  gl_->Viewport(0, 0, width, height);
  gl_->ClearColor(0.94f, 0.94f, 0.95f, 1);
  gl_->Clear(kColorBufferBit);
  gl_->MatrixMode(kModelview);
  gl_->LoadIdentity();
  gl_->MatrixMode(kProjection);
  gl_->LoadIdentity();
  gl_->Ortho(data.DisplayPos.x, data.DisplayPos.x + data.DisplaySize.x,
             data.DisplayPos.y + data.DisplaySize.y, data.DisplayPos.y, -1, 1);

  gl_->Enable(kScissorTest);
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ImVec4& clip = command.ClipRect;
      const float left = (clip.x - data.DisplayPos.x) * data.FramebufferScale.x,
                  top = (clip.y - data.DisplayPos.y) * data.FramebufferScale.y,
                  right = (clip.z - data.DisplayPos.x) * data.FramebufferScale.x,
                  bottom = (clip.w - data.DisplayPos.y) * data.FramebufferScale.y;
      if (right <= left || bottom <= top) continue;
      gl_->Scissor(static_cast<int>(left), height - static_cast<int>(bottom),
                   static_cast<int>(right - left), static_cast<int>(bottom - top));
      const void* vertices = list.VtxBuffer.Data + command.VtxOffset;
      gl_->VertexPointer(2, kFloat, sizeof(ImDrawVert),
                         at_byte(vertices, offsetof(ImDrawVert, pos)));
      gl_->TexCoordPointer(2, kFloat, sizeof(ImDrawVert),
                           at_byte(vertices, offsetof(ImDrawVert, uv)));
      gl_->ColorPointer(4, kUnsignedByte, sizeof(ImDrawVert),
                        at_byte(vertices, offsetof(ImDrawVert, col)));
      const auto texture = reinterpret_cast<std::uintptr_t>(command.GetTexID());
      gl_->BindTexture(kTexture2d, static_cast<unsigned>(texture));
      gl_->DrawElements(kTriangles, static_cast<int>(command.ElemCount),
                        sizeof(ImDrawIdx) == 2 ? kUnsignedShort : kUnsignedInt,
                        list.IdxBuffer.Data + command.IdxOffset);
    }
  }
  gl_->PopClientAttrib();
  gl_->PopAttrib();
}

film::Image ImguiGl::read(int width, int height) {
  film::Image upside_down(width, height), image(width, height);
  gl_->BindFramebuffer(kFramebuffer, 0);
  gl_->PixelStorei(kPackAlignment, 1);
  gl_->ReadPixels(0, 0, width, height, kRgb, kUnsignedByte, upside_down.rgb.data());
  for (int y = 0; y < height; ++y)
    std::copy_n(upside_down.row(height - 1 - y), 3 * static_cast<std::size_t>(width), image.row(y));
  return image;
}

unsigned ImguiGl::error() { return gl_->GetError(); }

}  // namespace fricid::viewer
