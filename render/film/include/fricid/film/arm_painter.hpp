// Pictures of an arm by MuJoCo's renderer.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fricid/film/gl_context.hpp"
#include "fricid/film/image.hpp"
#include "fricid/film/paint.hpp"
#include "fricid/sim/mujoco_arm.hpp"

namespace fricid::film {

/// A camera that looks at a point. Azimuth 0 looks along +x, 90 along +y; a negative elevation
/// looks down.
struct View {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< in the world [m]
  double distance = 2;                               ///< to the target [m]
  double azimuth_deg = 135, elevation_deg = -12;

  bool operator==(const View&) const = default;
};

/// One arm in a picture. Without a tint it is drawn in the colours of its model, with its
/// surroundings; with one, only the moving links are drawn, all in that colour.
struct PaintedArm {
  std::span<const double> q;  ///< (n) [rad]
  std::optional<Paint> tint = {};
};

/// A line in space.
struct Trail {
  std::vector<Eigen::Vector3d> points;  ///< in the world [m]
  Paint paint;
  double width = 2.5;  ///< [pixels]
};

/// Quality of a picture: draft is fast, standard has smooth edges, final has shadows too.
struct PaintQuality {
  int samples = 0;        ///< per pixel, for smooth edges
  int shadow_pixels = 0;  ///< side of the shadow map; 0: no shadows
  static PaintQuality draft() { return {}; }
  static PaintQuality standard() { return {4, 0}; }
  static PaintQuality final() { return {4, 2048}; }
};

/// Owns a copy of the model, the scene and their GPU resources. Use it on the thread of its GL
/// context, which must outlive it.
class ArmPainter {
 public:
  /// @param tip  site of the MJCF whose path is followed; when there is none, the last link
  /// @param width, height  largest picture expected; a larger one costs a new buffer
  /// @param function  looks up functions of the current GL context
  ArmPainter(const sim::MujocoArm& arm, const std::string& tip, int width, int height,
             PaintQuality quality, const GlLookup& function);
  ~ArmPainter();

  /// Floor, base and light are those of the first arm. Translucent arms are drawn over opaque ones,
  /// each over those before it, and the trails over the arms. @pre `arms` is not empty
  Image paint(const View& view, int width, int height, std::span<const PaintedArm> arms,
              std::span<const Trail> trails = {});

  /// Draws the static surroundings once, for all following pictures of this view and size; one
  /// backdrop is kept at a time. It is used when all arms have a tint. Does nothing if the backdrop
  /// exists already, or if arms affect it by shadows or a mirror.
  void keep_backdrop(const View& view, int width, int height);

  /// Position of the tip in the world [m].
  Eigen::Vector3d tip(std::span<const double> q);

  /// Positions of the base, all joints and the tip (n + 2) [m].
  std::vector<Eigen::Vector3d> joints(std::span<const double> q);

  /// Share of `points` that simple shapes of the surroundings hide from a camera.
  double hidden_share(const View& view, std::span<const Eigen::Vector3d> points) const;

  /// Full vertical angle of the camera [rad].
  double field_of_view() const;

 private:
  struct Gl;  // resources of the context

  /// A picture of the static surroundings.
  struct Backdrop {
    View view;
    int width, height;
    bool operator==(const Backdrop&) const = default;
  };

  void pose(std::span<const double> q);
  /// Binds the buffer of the pictures, which holds two of this size if backdrops are kept.
  void open_buffer(int width, int height);
  /// Sets the scene: the geoms of the first arm that are in `categories`, then the moving links of
  /// the others.
  /// @param meshes  meshes of one colour that the overlay draws: all, or the translucent ones
  void set_scene(const View& view, double aspect, std::span<const PaintedArm> arms, int categories,
                 bool all_meshes, std::vector<mjvGeom>& meshes);
  /// Removes from the scene, from `first` on, geoms that are neither in the picture nor cast a
  /// shadow into it.
  void drop_unseen(int first, const View& view, double aspect);
  /// Moves meshes from the scene, from `first` on, to `meshes`, from far to near.
  void take_meshes(int first, const View& view, bool all, std::vector<mjvGeom>& meshes);

  const sim::MujocoArm& arm_;
  sim::MjModelPtr model_;
  sim::MjDataPtr data_;
  int tip_site_;
  bool keeps_backdrops_;
  std::unique_ptr<Gl> gl_;
  std::optional<Backdrop> backdrop_;
};

}  // namespace fricid::film
