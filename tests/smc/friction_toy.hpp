#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/smc/kalman.hpp"
#include "fricid/smc/model.hpp"

namespace fricid::smc::test {

/// One joint with a Dahl bristle under a given torque u, the smallest model that has what makes
/// friction hard: memory, and a rate that depends on |v|. x = (q, v, z), y = q.
///
///     z' = e^{-r dt} z + (1 - e^{-r dt}) / r v,  r = |v| / length
///     v' = v + dt / J (u_t - stiffness z - damping v),  q' = q + dt v'
class FrictionToy {
 public:
  double dt = 4e-3;                    // [s]
  double inertia = 0.1;                // [kg m^2]
  double length = 3e-3;                // [rad]
  double stiffness = 330;              // [N m/rad]
  double damping = 0.3;                // [N m s/rad]
  double amplitude = 2, period = 0.9;  // of the torque [N m], [s]
  Gaussian start{Eigen::Vector3d::Zero(), Eigen::Vector3d(1e-8, 1e-4, 1e-8).asDiagonal()};
  Eigen::MatrixXd noise, observe = Eigen::MatrixXd{{1, 0, 0}}, error{{1e-10}};

  /// Noise of the velocity [rad/s]; position and bristle have a little of their own.
  explicit FrictionToy(double sd_v = 3e-3) { set_noise(1e-6, sd_v, 1e-6); }
  void set_noise(double sd_q, double sd_v, double sd_z) {
    noise = Eigen::Vector3d(sd_q * sd_q, sd_v * sd_v, sd_z * sd_z).asDiagonal();
  }

  int state_size() const { return 3; }
  int observation_size() const { return 1; }
  const Gaussian& initial() const { return start; }
  const Eigen::MatrixXd& Q() const { return noise; }
  const Eigen::MatrixXd& C() const { return observe; }
  const Eigen::MatrixXd& R() const { return error; }

  double torque(int t) const {
    const double phase = 2 * M_PI * t * dt / period;
    return amplitude * (std::sin(phase) + 0.3 * std::sin(2.3 * phase));
  }

  template <class S>
  void transition(int t, std::span<S> x) const {
    const S q = x[0], v = x[1], z = x[2];
    const S exponent = S(Real(-dt / length)) * abs(v);
    x[2] = z + (S(Real(dt)) * v + exponent * z) * phi1(exponent);
    const S force = S(Real(torque(t))) - S(Real(stiffness)) * z - S(Real(damping)) * v;
    x[1] = v + S(Real(dt / inertia)) * force;
    x[0] = q + S(Real(dt)) * x[1];
  }

  void linearise(int t, const Eigen::VectorXd& x, Eigen::VectorXd& f, Eigen::MatrixXd& A) const {
    f = x;
    transition(t, std::span<double>(f.data(), 3));
    const double v = x(1), z = x(2), r = std::abs(v) / length, h = r * dt;
    const double E = std::exp(-h), phi = phi1(-h);
    // d/dh of phi1(-h) = (1 - e^-h) / h
    const double dphi = h < 1e-4 ? -0.5 + h / 3 : (E - phi) / h;
    const double dh = (v > 0 ? 1 : v < 0 ? -1 : 0) * dt / length;
    A.setZero();
    A(2, 1) = dt * phi - E * dh * z + dt * v * dphi * dh;
    A(2, 2) = E;
    A(1, 1) = 1 - dt / inertia * damping;
    A(1, 2) = -dt / inertia * stiffness;
    A(0, 0) = 1;
    A(0, 1) = dt * A(1, 1);
    A(0, 2) = dt * A(1, 2);
  }

 private:
  using Real = double;
};
static_assert(StateSpaceModel<FrictionToy>);

/// States and observations drawn from a model; x_0 at its mean or drawn.
struct ToyData {
  RowMatrix x, y;
};
inline ToyData simulate_toy(const FrictionToy& toy, int T, std::uint64_t seed) {
  Rng rng(seed, 77);
  ToyData data{RowMatrix(T, 3), RowMatrix(T, 1)};
  std::vector<double> x(3);
  for (int i = 0; i < 3; ++i) {
    const double sd = std::sqrt(toy.start.covariance(i, i));
    x[static_cast<std::size_t>(i)] = toy.start.mean(i) + sd * rng.normal();
  }
  for (int t = 0; t < T; ++t) {
    if (t > 0) {
      toy.transition(t - 1, std::span<double>(x));
      for (int i = 0; i < 3; ++i) {
        x[static_cast<std::size_t>(i)] += std::sqrt(toy.noise(i, i)) * rng.normal();
      }
    }
    for (int i = 0; i < 3; ++i) data.x(t, i) = x[static_cast<std::size_t>(i)];
    data.y(t, 0) = x[0] + std::sqrt(toy.error(0, 0)) * rng.normal();
  }
  return data;
}

}  // namespace fricid::smc::test
