// Parts of MuJoCo's renderer done with fewer OpenGL operations, which saves time in software
// rendering.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <span>

#include "fricid/film/arm_painter.hpp"
#include "fricid/film/gl_context.hpp"

namespace fricid::film {

/// Draws into the frame buffer, with the camera and the lights, that mjr_render left.
class GlOverlay {
 public:
  /// @throws UserError naming a function that this OpenGL lacks
  explicit GlOverlay(const GlLookup& function);
  ~GlOverlay();
  GlOverlay(const GlOverlay&) = delete;
  GlOverlay& operator=(const GlOverlay&) = delete;

  /// Gives each infinite plane fewer cells than mjr's 200 x 200, fine below the camera and coarse
  /// far away, which looks the same under distant light.
  void coarsen_planes(const mjModel& model, const mjrContext& context) const;

  /// Draws meshes in their order, each once; mjr draws translucent ones twice.
  /// @param translucent_scale  of the size of translucent ones
  /// @pre every geom is a mesh with a dataid and without a texture, opaque ones before others
  void draw_meshes(std::span<const mjvGeom> geoms, int lights, float translucent_scale,
                   const mjrContext& context) const;

  /// Draws lines in their order, hidden by what is opaque.
  void draw_trails(std::span<const Trail> trails, const mjrContext& context) const;

  /// Copies colours and depths of a rectangle of the frame buffer to the one that begins at the
  /// row `bottom`. @pre they do not overlap
  void copy(const mjrRect& from, int bottom) const;

 private:
  struct Calls;
  std::unique_ptr<Calls> gl_;
};

}  // namespace fricid::film
