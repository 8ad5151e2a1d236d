#include "fricid/system/driven_friction.hpp"

#include <algorithm>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/system/arm.hpp"

namespace fricid {
namespace {

void check_shape(ConstRowMatrix matrix, Eigen::Index rows, Eigen::Index cols, const char* what) {
  if (matrix.rows() != rows || matrix.cols() != cols)
    throw UserError("friction driven by motion: {} is {} x {}, expected {} x {}", what,
                    matrix.rows(), matrix.cols(), rows, cols);
}

}  // namespace

DrivenFriction drive_friction(const friction::Friction& friction, double dt, ConstRowMatrix q,
                              ConstRowMatrix v, ConstRowMatrix load, ConstRowMatrix temperature,
                              std::span<const double> z0) {
  const friction::RobotFriction& model = friction.model;
  const Eigen::Index T = q.rows(), n = model.joint_count(), nz = model.state_size();
  check_shape(q, T, n, "q");
  check_shape(v, T, n, "v");
  check_shape(load, T, n, "load");
  if (temperature.size() > 0) check_shape(temperature, T, n, "temperature");
  if (!z0.empty() && std::ssize(z0) != nz)
    throw UserError("friction driven by motion: z0 has {} values, expected {}", z0.size(), nz);

  DrivenFriction out{RowMatrix::Zero(T, n), RowMatrix::Zero(T, nz)};
  std::vector<double> z(static_cast<std::size_t>(nz), 0.0);
  std::copy(z0.begin(), z0.end(), z.begin());
  std::vector<friction::Input<double>> in(static_cast<std::size_t>(n));
  for (Eigen::Index k = 0; k < T; ++k) {
    for (Eigen::Index j = 0; j < n; ++j)
      in[static_cast<std::size_t>(j)] = {
          q(k, j), v(k, j), load(k, j),
          temperature.size() > 0 ? temperature(k, j) : kRoomTemperature};
    model.torque<double>(friction.theta, in, z,
                         {out.tau_f.row(k).data(), static_cast<std::size_t>(n)});
    std::copy(z.begin(), z.end(), out.z.row(k).data());
    if (k + 1 == T) break;
    for (Eigen::Index j = 0; j < n; ++j) {
      auto& joint = in[static_cast<std::size_t>(j)];
      joint.q = q(k + 1, j);
      joint.v = (q(k + 1, j) - q(k, j)) / dt;
    }
    model.step<double>(friction.theta, in, dt, z);
  }
  return out;
}

}  // namespace fricid
