#include "fricid/film/arm_painter.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fricid/base/error.hpp"
#include "gl_overlay.hpp"

namespace fricid::film {
namespace {

constexpr int kGeoms = 5000;
constexpr double kGhostLead = 0.03;  // [m]
constexpr double kRadians = std::numbers::pi / 180;

Eigen::Vector3d vector_at(const mjtNum* values, int index) {
  return Eigen::Vector3d::Map(values + 3 * static_cast<std::ptrdiff_t>(index));
}

Eigen::Vector3d eye_of(const View& view) {
  const double azimuth = view.azimuth_deg * kRadians, elevation = view.elevation_deg * kRadians;
  return view.target - view.distance * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                                                       std::sin(azimuth) * std::cos(elevation),
                                                       std::sin(elevation));
}

/// View cone of a camera, unlimited in depth.
struct Sight {
  Eigen::Vector3d eye, forward, right, up;
  double across, upright;  ///< half angles [rad]

  bool holds(const Eigen::Vector3d& centre, double radius) const {
    const Eigen::Vector3d from_eye = centre - eye;
    const double depth = forward.dot(from_eye);
    const auto within = [&](const Eigen::Vector3d& axis, double angle) {
      const double aside = std::abs(axis.dot(from_eye));
      return aside * std::cos(angle) - depth * std::sin(angle) <= radius;
    };
    return within(right, across) && within(up, upright);
  }
};

Sight sight_of(const View& view, double field_of_view, double aspect) {
  Sight sight;
  sight.eye = eye_of(view);
  sight.forward = (view.target - sight.eye).normalized();
  const double azimuth = view.azimuth_deg * kRadians;
  sight.right = {std::sin(azimuth), -std::cos(azimuth), 0};
  sight.up = sight.right.cross(sight.forward);
  sight.upright = field_of_view / 2;
  sight.across = std::atan(aspect * std::tan(sight.upright));
  return sight;
}

/// Whether a geom is a moving mesh of one colour.
bool is_plain_mesh(const mjvGeom& geom) {
  return geom.category == mjCAT_DYNAMIC && geom.type == mjGEOM_MESH && geom.matid < 0 &&
         geom.objtype == mjOBJ_GEOM && geom.dataid >= 0;
}

/// Gives moving links one colour. Translucent links cast no shadow.
void tint(std::span<mjvGeom> links, const Paint& paint) {
  for (mjvGeom& geom : links) {
    if (geom.category != mjCAT_DYNAMIC) continue;
    std::copy_n(std::array{paint.red, paint.green, paint.blue, paint.alpha}.data(), 4, geom.rgba);
    geom.matid = geom.texid = -1;
    geom.specular = 0.2f;
    geom.transparent = paint.alpha < 1;
    geom.castshadow = paint.alpha >= 1;
    if (!is_plain_mesh(geom)) geom.rgba[3] = 1 - std::sqrt(1 - paint.alpha);  // mjr draws it twice
  }
}

/// Scale of a ghost about the eye. It looks the same but is nearer by kGhostLead at the view's
/// target, so that an arm with nearly the same surface does not show through in patches.
float ghost_scale(const View& view) {
  return static_cast<float>(1 - std::min(kGhostLead / view.distance, 0.2));
}

/// Shrinks translucent moving links about the eye. Overlay's meshes take their size when drawn.
void bring_forward(std::span<mjvGeom> links, const View& view) {
  const Eigen::Vector3f eye = eye_of(view).cast<float>();
  const float scale = ghost_scale(view);
  for (mjvGeom& geom : links) {
    if (geom.category != mjCAT_DYNAMIC || !geom.transparent) continue;
    Eigen::Map<Eigen::Vector3f> position(geom.pos), size(geom.size);
    position = eye + scale * (position - eye);
    size *= scale;
  }
}

/// Whether a static geom mirrors moving ones.
bool has_mirror(const mjModel& model) {
  return std::any_of(model.mat_reflectance, model.mat_reflectance + model.nmat,
                     [](float reflectance) { return reflectance > 0; });
}

}  // namespace

struct ArmPainter::Gl {
  explicit Gl(const GlLookup& function) : overlay(function) {}

  mjvScene scene;
  mjvOption option;
  mjvPerturb nobody;
  mjrContext context;
  GlOverlay overlay;
};

ArmPainter::ArmPainter(const sim::MujocoArm& arm, const std::string& tip, int width, int height,
                       PaintQuality quality, const GlLookup& function)
    : arm_(arm),
      model_(mj_copyModel(nullptr, &arm.model())),
      data_(arm.make_data()),
      tip_site_(mj_name2id(model_.get(), mjOBJ_SITE, tip.c_str())),
      keeps_backdrops_(quality.shadow_pixels == 0 && !has_mirror(*model_)),
      gl_(std::make_unique<Gl>(function)) {
  model_->vis.global.offwidth = width;
  model_->vis.global.offheight = keeps_backdrops_ ? 2 * height : height;
  model_->vis.quality.offsamples = quality.samples;
  model_->vis.quality.shadowsize = quality.shadow_pixels;

  mjv_defaultScene(&gl_->scene);
  mjv_makeScene(model_.get(), &gl_->scene, kGeoms);
  gl_->scene.flags[mjRND_SHADOW] = quality.shadow_pixels > 0;
  mjv_defaultOption(&gl_->option);
  mjv_defaultPerturb(&gl_->nobody);
  mjr_defaultContext(&gl_->context);
  mjr_makeContext(model_.get(), &gl_->context, mjFONTSCALE_100);
  gl_->overlay.coarsen_planes(*model_, gl_->context);
}

ArmPainter::~ArmPainter() {
  mjr_freeContext(&gl_->context);
  mjv_freeScene(&gl_->scene);
}

void ArmPainter::pose(std::span<const double> q) {
  for (int j = 0; j < arm_.n(); ++j) data_->qpos[arm_.qpos(j)] = q[static_cast<std::size_t>(j)];
  mj_kinematics(model_.get(), data_.get());
  mj_comPos(model_.get(), data_.get());
  mj_camlight(model_.get(), data_.get());
}

Eigen::Vector3d ArmPainter::tip(std::span<const double> q) { return joints(q).back(); }

std::vector<Eigen::Vector3d> ArmPainter::joints(std::span<const double> q) {
  pose(q);
  std::vector<Eigen::Vector3d> points{vector_at(data_->xpos, model_->body_parentid[arm_.body(0)])};
  for (int j = 0; j < arm_.n(); ++j) points.push_back(vector_at(data_->xpos, arm_.body(j)));
  points.push_back(tip_site_ >= 0 ? vector_at(data_->site_xpos, tip_site_) : points.back());
  return points;
}

double ArmPainter::hidden_share(const View& view, std::span<const Eigen::Vector3d> points) const {
  // static simple shapes; links do not count as obstacles
  std::vector<int> obstacles;
  for (int g = 0; g < model_->ngeom; ++g)
    if (model_->body_weldid[model_->geom_bodyid[g]] == 0 && model_->geom_type[g] != mjGEOM_MESH &&
        model_->geom_type[g] != mjGEOM_HFIELD)
      obstacles.push_back(g);
  const Eigen::Vector3d eye = eye_of(view);
  const auto hidden = std::count_if(points.begin(), points.end(), [&](const auto& point) {
    const Eigen::Vector3d ray = point - eye;
    return std::any_of(obstacles.begin(), obstacles.end(), [&](int g) {
      const double hit =
          mju_rayGeom(data_->geom_xpos + 3 * g, data_->geom_xmat + 9 * g, model_->geom_size + 3 * g,
                      eye.data(), ray.data(), model_->geom_type[g], nullptr);
      return hit >= 0 && hit < 1;
    });
  });
  return points.empty() ? 0 : static_cast<double>(hidden) / static_cast<double>(points.size());
}

double ArmPainter::field_of_view() const {
  return static_cast<double>(model_->vis.global.fovy) * kRadians;
}

void ArmPainter::take_meshes(int first, const View& view, bool all, std::vector<mjvGeom>& meshes) {
  mjvScene& scene = gl_->scene;
  mjvGeom* const end = scene.geoms + scene.ngeom;
  mjvGeom* const taken = std::stable_partition(scene.geoms + first, end, [&](const mjvGeom& geom) {
    return !is_plain_mesh(geom) || !(all || geom.transparent);
  });
  const Eigen::Vector3f eye = eye_of(view).cast<float>();
  const auto distance = [&](const mjvGeom& geom) {
    return (Eigen::Map<const Eigen::Vector3f>(geom.pos) - eye).norm() -
           static_cast<float>(model_->geom_rbound[geom.objid]);
  };
  std::sort(taken, end,
            [&](const mjvGeom& a, const mjvGeom& b) { return distance(a) > distance(b); });
  meshes.insert(meshes.end(), taken, end);
  scene.ngeom = static_cast<int>(taken - scene.geoms);
}

void ArmPainter::drop_unseen(int first, const View& view, double aspect) {
  mjvScene& scene = gl_->scene;
  const Sight sight = sight_of(view, field_of_view(), aspect);
  mjvGeom* const end =
      std::remove_if(scene.geoms + first, scene.geoms + scene.ngeom, [&](const mjvGeom& geom) {
        if (geom.objtype != mjOBJ_GEOM || geom.objid < 0) return false;
        const double radius = model_->geom_rbound[geom.objid];  // 0: without end
        const bool shades = scene.flags[mjRND_SHADOW] && geom.castshadow;
        return radius > 0 && !shades &&
               !sight.holds(Eigen::Map<const Eigen::Vector3f>(geom.pos).cast<double>(), radius);
      });
  scene.ngeom = static_cast<int>(end - scene.geoms);
}

void ArmPainter::open_buffer(int width, int height) {
  mjrContext& context = gl_->context;
  const int rows = keeps_backdrops_ ? 2 * height : height;
  if (width > context.offWidth || rows > context.offHeight) {
    mjr_resizeOffscreen(std::max(width, context.offWidth), std::max(rows, context.offHeight),
                        &context);
    backdrop_.reset();
  }
  mjr_setBuffer(mjFB_OFFSCREEN, &context);
}

void ArmPainter::set_scene(const View& view, double aspect, std::span<const PaintedArm> arms,
                           int categories, bool all_meshes, std::vector<mjvGeom>& meshes) {
  mjvScene& scene = gl_->scene;
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  Eigen::Vector3d::Map(camera.lookat) = view.target;
  camera.distance = view.distance;
  camera.azimuth = view.azimuth_deg;
  camera.elevation = view.elevation_deg;

  meshes.clear();
  pose(arms.front().q);
  mjv_updateCamera(model_.get(), data_.get(), &camera, &scene);  // sets the headlight
  mjv_updateScene(model_.get(), data_.get(), &gl_->option, &gl_->nobody, &camera, categories,
                  &scene);
  for (mjvGeom& geom : std::span(scene.geoms, static_cast<std::size_t>(scene.ngeom)))
    if (geom.type == mjGEOM_PLANE) geom.castshadow = 0;  // a floor would shade itself, in dots
  for (std::size_t a = 0, first = 0; a < arms.size(); ++a) {
    if (a > 0) {
      first = static_cast<std::size_t>(scene.ngeom);
      pose(arms[a].q);
      mjv_addGeoms(model_.get(), data_.get(), &gl_->option, &gl_->nobody, mjCAT_DYNAMIC, &scene);
    }
    const std::span links(scene.geoms + first, scene.geoms + scene.ngeom);
    if (arms[a].tint) {
      tint(links, *arms[a].tint);
      bring_forward(links, view);
    }
    drop_unseen(static_cast<int>(first), view, aspect);
    take_meshes(static_cast<int>(first), view, all_meshes, meshes);
  }
}

void ArmPainter::keep_backdrop(const View& view, int width, int height) {
  if (!keeps_backdrops_ || backdrop_ == Backdrop{view, width, height}) return;
  const std::vector<double> anywhere(static_cast<std::size_t>(arm_.n()));
  std::vector<mjvGeom> none;
  set_scene(view, static_cast<double>(width) / height, std::array{PaintedArm{anywhere}},
            mjCAT_STATIC, false, none);
  open_buffer(width, height);
  mjr_render({0, 0, width, height}, &gl_->scene, &gl_->context);
  gl_->overlay.copy({0, 0, width, height}, height);
  backdrop_ = {view, width, height};
}

Image ArmPainter::paint(const View& view, int width, int height, std::span<const PaintedArm> arms,
                        std::span<const Trail> trails) {
  mjvScene& scene = gl_->scene;
  const mjrRect viewport{0, 0, width, height};
  const double aspect = static_cast<double>(width) / height;
  open_buffer(width, height);

  // onto the backdrop if the overlay draws everything that moves
  std::vector<mjvGeom> meshes;
  const bool kept = backdrop_ == Backdrop{view, width, height};
  if (kept) set_scene(view, aspect, arms, mjCAT_DYNAMIC, true, meshes);
  if (kept && scene.ngeom == 0) {
    scene.flags[mjRND_SKYBOX] = 0;
    mjr_render(viewport, &scene, &gl_->context);
    gl_->overlay.copy({0, height, width, height}, 0);
    scene.flags[mjRND_SKYBOX] = 1;
  } else {
    set_scene(view, aspect, arms, mjCAT_ALL, false, meshes);
    mjr_render(viewport, &scene, &gl_->context);
  }
  std::stable_partition(meshes.begin(), meshes.end(),
                        [](const mjvGeom& geom) { return !geom.transparent; });
  gl_->overlay.draw_meshes(meshes, scene.nlight, ghost_scale(view), gl_->context);
  gl_->overlay.draw_trails(trails, gl_->context);
  Image image(width, height);
  mjr_readPixels(image.rgb.data(), nullptr, viewport, &gl_->context);
  for (int y = 0; y < height / 2; ++y)
    std::swap_ranges(image.row(y), image.row(y) + std::ptrdiff_t{3} * width,
                     image.row(height - 1 - y));
  return image;
}

}  // namespace fricid::film
