#include "fricid/system/noise.hpp"

namespace fricid {

Eigen::MatrixXd LatentNoise::Q() const {
  const Eigen::Index n = v.size(), nz = z.size();
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(2 * n + nz, 2 * n + nz);
  Q.topLeftCorner(n, n) = (q + 0.25 * dt * dt * v).asDiagonal();
  Q.block(0, n, n, n) = (0.5 * dt * v).asDiagonal();
  Q.block(n, 0, n, n) = Q.block(0, n, n, n);
  Q.block(n, n, n, n) = v.asDiagonal();
  Q.bottomRightCorner(nz, nz) = z.asDiagonal();
  return Q;
}

}  // namespace fricid
