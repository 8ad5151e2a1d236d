#include "fricid/sim/clearance.hpp"

#include <algorithm>
#include <set>

namespace fricid::sim {
namespace {

// Whether two bodies cannot move against each other, or one carries the other's joint. Bodies
// welded to the world count as carrying none.
bool neighbours(const mjModel& model, int body1, int body2) {
  const int weld1 = model.body_weldid[body1], weld2 = model.body_weldid[body2];
  if (weld1 == weld2) return true;
  const auto carries = [&](int carrier, int weld) {
    for (int parent = model.body_parentid[weld]; parent != 0;
         parent = model.body_parentid[parent]) {
      if (parent == carrier) return true;
      if (model.body_weldid[parent] != 0)
        return model.body_weldid[parent] == model.body_weldid[carrier];
    }
    return false;
  };
  return carries(body1, weld2) || carries(body2, weld1);
}

std::string geom_owner(const mjModel& model, int geom) {
  const int body = model.geom_bodyid[geom];
  const char* name =
      body == 0 ? mj_id2name(&model, mjOBJ_GEOM, geom) : mj_id2name(&model, mjOBJ_BODY, body);
  return name ? name : "geom " + std::to_string(geom);
}

}  // namespace

Clearance::Clearance(const MujocoArm& arm, double range)
    : arm_(arm), data_(arm.make_data()), range_(range) {
  const mjModel& model = arm.model();
  const std::set<int> excluded(model.exclude_signature, model.exclude_signature + model.nexclude);
  for (int i = 0; i < model.ngeom; ++i) {
    for (int j = i + 1; j < model.ngeom; ++j) {
      const int body1 = model.geom_bodyid[i], body2 = model.geom_bodyid[j];
      const bool masks = (model.geom_contype[i] & model.geom_conaffinity[j]) ||
                         (model.geom_contype[j] & model.geom_conaffinity[i]);
      const int signature = (std::min(body1, body2) << 16) + std::max(body1, body2);
      if (masks && !neighbours(model, body1, body2) && !excluded.contains(signature))
        pairs_.emplace_back(i, j);
    }
  }
}

Clearance::Pair Clearance::closest(std::span<const double> q) {
  const mjModel& model = arm_.model();
  for (int j = 0; j < arm_.n(); ++j) data_->qpos[arm_.qpos(j)] = q[static_cast<std::size_t>(j)];
  mj_kinematics(&model, data_.get());
  Pair best{range_, -1, -1};
  for (const auto& [geom1, geom2] : pairs_) {
    // bounding spheres; a plane has radius 0 and is never skipped
    const double r1 = model.geom_rbound[geom1], r2 = model.geom_rbound[geom2];
    if (r1 > 0 && r2 > 0) {
      const Eigen::Vector3d p1(data_->geom_xpos + 3 * geom1), p2(data_->geom_xpos + 3 * geom2);
      if ((p1 - p2).norm() - r1 - r2 >= best.distance) continue;
    }
    const double distance =
        mj_geomDistance(&model, data_.get(), geom1, geom2, best.distance, nullptr);
    if (distance < best.distance) best = {distance, geom1, geom2};
  }
  return best;
}

std::string Clearance::name(const Pair& pair) const {
  if (pair.geom1 < 0) return "none";
  return geom_owner(arm_.model(), pair.geom1) + " - " + geom_owner(arm_.model(), pair.geom2);
}

}  // namespace fricid::sim
