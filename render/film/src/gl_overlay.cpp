#include "gl_overlay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "fricid/film/gl_calls.hpp"

namespace fricid::film {
namespace {

// <GL/gl.h>
enum : unsigned {
  kLineStrip = 0x0003,
  kQuads = 0x0007,
  kSpecular = 0x1202,
  kCompile = 0x1300,
  kEmission = 0x1600,
  kShininess = 0x1601,
  kNearest = 0x2600,
  kLight0 = 0x4000,
  kAllBuffers = 0x4500  // colours, depths and stencils
};

constexpr int kCells = 40;  // of a plane, in each direction

/// Whether all lights are so far away that a plane is evenly lit.
bool lit_from_far(const mjModel& model) {
  return std::all_of(model.light_type, model.light_type + model.nlight,
                     [](int type) { return type == mjLIGHT_DIRECTIONAL; });
}

}  // namespace

struct GlOverlay::Calls {
  void (*Enable)(unsigned);
  void (*Disable)(unsigned);
  void (*BlendFunc)(unsigned, unsigned);
  void (*DepthMask)(unsigned char);
  void (*PushMatrix)();
  void (*PopMatrix)();
  void (*MultMatrixf)(const float*);
  void (*Materialfv)(unsigned, unsigned, const float*);
  void (*Materialf)(unsigned, unsigned, float);
  void (*Color4fv)(const float*);
  void (*CallList)(unsigned);
  void (*NewList)(unsigned, unsigned);
  void (*EndList)();
  void (*Begin)(unsigned);
  void (*End)();
  void (*Normal3d)(double, double, double);
  void (*TexCoord2d)(double, double);
  void (*Vertex3d)(double, double, double);
  void (*LineWidth)(float);
  void (*BlitFramebuffer)(int, int, int, int, int, int, int, int, unsigned, unsigned);

  explicit Calls(const GlLookup& function) {
    const auto find = [&](auto& call, const char* name) { find_call(function, call, name); };
    find(Enable, "glEnable");
    find(Disable, "glDisable");
    find(BlendFunc, "glBlendFunc");
    find(DepthMask, "glDepthMask");
    find(PushMatrix, "glPushMatrix");
    find(PopMatrix, "glPopMatrix");
    find(MultMatrixf, "glMultMatrixf");
    find(Materialfv, "glMaterialfv");
    find(Materialf, "glMaterialf");
    find(Color4fv, "glColor4fv");
    find(CallList, "glCallList");
    find(NewList, "glNewList");
    find(EndList, "glEndList");
    find(Begin, "glBegin");
    find(End, "glEnd");
    find(Normal3d, "glNormal3d");
    find(TexCoord2d, "glTexCoord2d");
    find(Vertex3d, "glVertex3d");
    find(LineWidth, "glLineWidth");
    find(BlitFramebuffer, "glBlitFramebuffer");
  }

  void begin_blending() const {
    DepthMask(0);
    Enable(kBlend);
    BlendFunc(kSrcAlpha, kOneMinusSrcAlpha);
  }
  void end_blending() const {
    Disable(kBlend);
    DepthMask(1);
  }
};

GlOverlay::GlOverlay(const GlLookup& function) : gl_(std::make_unique<Calls>(function)) {}
GlOverlay::~GlOverlay() = default;

void GlOverlay::coarsen_planes(const mjModel& model, const mjrContext& context) const {
  if (!lit_from_far(model)) return;
  unsigned list = context.basePlane;
  for (int g = 0; g < model.ngeom; ++g) {
    if (model.geom_type[g] != mjGEOM_PLANE) continue;
    ++list;
    if (model.geom_size[3 * g] > 0 || model.geom_size[3 * g + 1] > 0) continue;
    // mjr moves the plane by steps of the texture, to stay below the camera
    const int material = model.geom_matid[g];
    const double sight = model.vis.map.zfar * model.stat.extent;
    double step = 0.02 * sight;
    for (int axis = 0; material >= 0 && axis < 2; ++axis)
      if (const float repeat = model.mat_texrepeat[2 * material + axis]; repeat > 0)
        step = std::max(step, 2.0 / repeat);
    const double half = 1.05 * sight + step;
    std::array<double, kCells + 1> line{};
    for (int i = 0; i <= kCells; ++i) {
      const double share = 2.0 * i / kCells - 1;
      line[static_cast<std::size_t>(i)] = half * share * std::abs(share);
    }
    const auto vertex = [&](std::size_t x, std::size_t y) {
      gl_->TexCoord2d(0.5 * line[x], -0.5 * line[y]);
      gl_->Vertex3d(line[x], line[y], 0);
    };
    gl_->NewList(list, kCompile);
    gl_->Begin(kQuads);
    gl_->Normal3d(0, 0, 1);
    for (std::size_t x = 0; x < kCells; ++x)
      for (std::size_t y = 0; y < kCells; ++y) {
        vertex(x, y);
        vertex(x + 1, y);
        vertex(x + 1, y + 1);
        vertex(x, y + 1);
      }
    gl_->End();
    gl_->EndList();
  }
}

void GlOverlay::draw_meshes(std::span<const mjvGeom> geoms, int lights, float translucent_scale,
                            const mjrContext& context) const {
  const auto each_light = [&](void (*call)(unsigned)) {
    for (unsigned i = 0; i < static_cast<unsigned>(lights); ++i) call(kLight0 + i);
  };
  each_light(gl_->Enable);
  bool blending = false;
  for (const mjvGeom& geom : geoms) {
    if (geom.transparent && !std::exchange(blending, true)) gl_->begin_blending();
    gl_->Color4fv(geom.rgba);
    gl_->Materialf(kFrontAndBack, kShininess, geom.shininess * 128);
    const std::array<float, 4> specular{geom.specular, geom.specular, geom.specular, 1};
    gl_->Materialfv(kFrontAndBack, kSpecular, specular.data());
    const std::array<float, 4> emission{geom.emission * geom.rgba[0], geom.emission * geom.rgba[1],
                                        geom.emission * geom.rgba[2], 1};
    gl_->Materialfv(kFrontAndBack, kEmission, emission.data());
    const float size = geom.transparent ? translucent_scale : 1;
    std::array<float, 16> pose{};
    for (std::size_t column = 0; column < 3; ++column)
      for (std::size_t row = 0; row < 3; ++row)
        pose[4 * column + row] = size * geom.mat[3 * row + column];
    std::copy_n(geom.pos, 3, &pose[12]);
    pose[15] = 1;
    gl_->PushMatrix();
    gl_->MultMatrixf(pose.data());
    gl_->CallList(context.baseMesh + static_cast<unsigned>(geom.dataid));
    gl_->PopMatrix();
  }
  if (blending) gl_->end_blending();
  each_light(gl_->Disable);
}

void GlOverlay::draw_trails(std::span<const Trail> trails, const mjrContext& context) const {
  gl_->Disable(kLighting);
  gl_->Enable(kScissorTest);  // a wide line reaches beyond the viewport
  gl_->begin_blending();
  for (const Trail& trail : trails) {
    const Paint& paint = trail.paint;
    const std::array<float, 4> rgba{paint.red, paint.green, paint.blue, paint.alpha};
    gl_->Color4fv(rgba.data());
    gl_->LineWidth(static_cast<float>(trail.width) * context.lineWidth);
    gl_->Begin(kLineStrip);
    for (const Eigen::Vector3d& point : trail.points)
      gl_->Vertex3d(point.x(), point.y(), point.z());
    gl_->End();
  }
  gl_->LineWidth(context.lineWidth);
  gl_->end_blending();
  gl_->Disable(kScissorTest);
  gl_->Enable(kLighting);
}

void GlOverlay::copy(const mjrRect& from, int bottom) const {
  gl_->Disable(kScissorTest);
  const int right = from.left + from.width;
  gl_->BlitFramebuffer(from.left, from.bottom, right, from.bottom + from.height, from.left, bottom,
                       right, bottom + from.height, kAllBuffers, kNearest);
}

}  // namespace fricid::film
