#include "fricid/system/noise.hpp"

namespace fricid {

double position_per_velocity(double dt, int substeps) { return 0.5 * dt * (1 + 1.0 / substeps); }

Eigen::MatrixXd LatentNoise::Q(int substeps) const {
  const double c = position_per_velocity(dt, substeps);
  const Eigen::Index n = v.size(), nz = z.size();
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(2 * n + nz, 2 * n + nz);
  Q.topLeftCorner(n, n) = (q + c * c * v).asDiagonal();
  Q.block(0, n, n, n) = (c * v).asDiagonal();
  Q.block(n, 0, n, n) = Q.block(0, n, n, n);
  Q.block(n, n, n, n) = v.asDiagonal();
  Q.bottomRightCorner(nz, nz) = z.asDiagonal();
  return Q;
}

}  // namespace fricid
