#include "fricid/viewer/latent_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "fricid/base/rng.hpp"

namespace fricid::viewer {

LatentCloud latent_cloud(const friction::Friction& friction, const JointMotion& motion, int row,
                         double age, int copies) {
  const int begin = std::max(row - static_cast<int>(std::lround(age / motion.dt)), 0);
  const int rows = row - begin + 1;
  const auto along = [&](int first, int count, std::span<const double> z0) {
    const RowMatrix temperature =
        motion.temperature.size() > 0 ? motion.temperature.middleRows(first, count) : RowMatrix();
    return drive_friction(friction, motion.dt, motion.q.middleRows(first, count),
                          motion.v.middleRows(first, count), motion.load.middleRows(first, count),
                          temperature, z0);
  };
  const auto states = static_cast<std::size_t>(motion.z.cols());

  LatentCloud cloud;
  cloud.state = motion.z.row(row);
  cloud.state_tau = along(row, 1, {cloud.state.data(), states}).tau_f(0, 0);
  cloud.from.resize(copies, motion.z.cols());
  cloud.to.resize(copies, motion.z.cols());
  cloud.from_tau.resize(copies);
  cloud.tau.resize(copies);
  Rng rng(1, 0);
  for (int i = 0; i < copies; ++i) {
    const auto drawn =
        static_cast<Eigen::Index>(rng.uniform() * static_cast<double>(motion.z.rows()));
    cloud.from.row(i) = motion.z.row(drawn);
    const DrivenFriction driven = along(begin, rows, {motion.z.row(drawn).data(), states});
    cloud.from_tau[i] = driven.tau_f(0, 0);
    cloud.to.row(i) = driven.z.row(rows - 1);
    cloud.tau[i] = driven.tau_f(rows - 1, 0);
  }
  return cloud;
}

double spread(const Eigen::VectorXd& tau) {
  return std::sqrt((tau.array() - tau.mean()).square().mean());
}

}  // namespace fricid::viewer
