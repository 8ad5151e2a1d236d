#include "fricid/system/driven_friction.hpp"

#include <algorithm>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/system/arm.hpp"

namespace fricid {
namespace {

// Friction that is part of its own load. An error falls by mu F < 1 in each pass; it is settled
// when that changes it by less than this share.
constexpr double kSettled = 1e-4;
constexpr int kMostPasses = 30;

void check_shape(ConstRowMatrix matrix, Eigen::Index rows, Eigen::Index cols, const char* what) {
  if (matrix.rows() != rows || matrix.cols() != cols)
    throw UserError("friction driven by motion: {} is {} x {}, expected {} x {}", what,
                    matrix.rows(), matrix.cols(), rows, cols);
}

}  // namespace

FrictionFollower::FrictionFollower(const friction::Friction& friction, double dt,
                                   std::span<const double> z0)
    : friction_(friction), dt_(dt) {
  const auto n = static_cast<std::size_t>(friction.model.joint_count());
  in_.resize(n);
  tau_f_.resize(n);
  z_.assign(static_cast<std::size_t>(friction.model.state_size()), 0.0);
  if (!z0.empty() && z0.size() != z_.size())
    throw UserError("friction driven by motion: z0 has {} values, expected {}", z0.size(),
                    z_.size());
  std::copy(z0.begin(), z0.end(), z_.begin());
}

std::span<const double> FrictionFollower::follow(std::span<const double> q,
                                                 std::span<const double> v,
                                                 std::span<const double> load,
                                                 std::span<const double> temperature) {
  // load and temperature are those of the sample before
  for (std::size_t j = 0; j < in_.size(); ++j) {
    in_[j].v = (q[j] - in_[j].q) / dt_;
    in_[j].q = q[j];
  }
  if (begun_) friction_.model.step<double>(friction_.theta, in_, dt_, z_);
  begun_ = true;
  for (std::size_t j = 0; j < in_.size(); ++j) in_[j] = {q[j], v[j], load[j], temperature[j]};
  friction_.model.torque<double>(friction_.theta, in_, z_, tau_f_);
  return tau_f_;
}

DrivenFriction drive_friction(const friction::Friction& friction, double dt, ConstRowMatrix q,
                              ConstRowMatrix v, ConstRowMatrix load, ConstRowMatrix temperature,
                              std::span<const double> z0) {
  const friction::RobotFriction& model = friction.model;
  const Eigen::Index T = q.rows(), n = model.joint_count(), nz = model.state_size();
  check_shape(q, T, n, "q");
  check_shape(v, T, n, "v");
  check_shape(load, T, n, "load");
  if (temperature.size() > 0) check_shape(temperature, T, n, "temperature");

  DrivenFriction out{RowMatrix::Zero(T, n), RowMatrix::Zero(T, nz)};
  FrictionFollower follower(friction, dt, z0);
  const std::vector<double> room(static_cast<std::size_t>(n), kRoomTemperature);
  const auto row = [n](const ConstRowMatrix& x, Eigen::Index k) {
    return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(n));
  };
  for (Eigen::Index k = 0; k < T; ++k) {
    const std::span<const double> tau_f =
        follower.follow(row(q, k), row(v, k), row(load, k),
                        temperature.size() > 0 ? row(temperature, k) : std::span(room));
    std::copy(tau_f.begin(), tau_f.end(), out.tau_f.row(k).data());
    std::copy(follower.z().begin(), follower.z().end(), out.z.row(k).data());
  }
  return out;
}

DrivenFriction drive_under_own_load(const friction::Friction& friction, double dt, ConstRowMatrix q,
                                    ConstRowMatrix v, ConstRowMatrix rigid,
                                    ConstRowMatrix temperature, std::span<const double> z0,
                                    const std::function<void(RowMatrix&)>& filter) {
  const auto driven = [&](ConstRowMatrix load) {
    DrivenFriction out = drive_friction(friction, dt, q, v, load, temperature, z0);
    if (filter) filter(out.tau_f);
    return out;
  };
  DrivenFriction out = driven(rigid);
  if (!friction.model.reads_load()) return out;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    DrivenFriction next = driven(rigid + out.tau_f);
    const RowMatrix change = next.tau_f - out.tau_f;
    const bool moves = (change.colwise().squaredNorm().array() >
                        kSettled * kSettled * next.tau_f.colwise().squaredNorm().array())
                           .any();
    out = std::move(next);
    if (!moves) break;
  }
  return out;
}

}  // namespace fricid
