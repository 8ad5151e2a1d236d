// A hanging KR6 with hysteretic friction under control, made by the engine alone: recordings with a
// truth for tests and benchmarks that must not know the simulator.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string_view>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/friction/sum.hpp"
#include "fricid/system/arm.hpp"
#include "fricid/system/driven_friction.hpp"
#include "source_dir.hpp"

namespace fricid::test {

inline constexpr double kSamplePeriod = 0.004;  // [s]

/// The KR6 of models/, hanging from the ceiling.
inline dynamics::RobotModel hanging_kr6() {
  const Eigen::Matrix3d ceiling = Eigen::Vector3d(1, -1, -1).asDiagonal();
  return dynamics::load_urdf(source_dir() / "models" / "kr6_r700" / "kr6_r700.urdf", ceiling);
}

/// Middle-sized magnitudes of the joints of a KR6.
struct JointScale {
  double Fc, Fv, sigma0, sigma1;  // [N m], [N m s/rad], [N m/rad], [N m s/rad]
};
inline constexpr std::array<JointScale, 6> kJointScales{{{10, 6, 2e4, 60},
                                                         {11, 6.5, 2.2e4, 60},
                                                         {6, 2.6, 1.5e4, 30},
                                                         {2.8, 1.4, 6e3, 8},
                                                         {2.5, 1.2, 5.5e3, 7},
                                                         {1.6, 0.5, 4e3, 4}}};
inline constexpr double kStaticOverCoulomb = 1.08;
inline constexpr double kStribeckVelocity = 0.05;  // [rad/s]

/// Friction of the same laws in every joint, `value(joint, owner, symbol)` where it is not NaN,
/// else the typical one of the table.
template <class Value>
friction::Friction make_friction(int n, const friction::JointSpec& spec, const Value& value) {
  friction::Friction friction{
      friction::RobotFriction(std::vector(static_cast<std::size_t>(n), spec)), {}};
  for (const friction::ParameterRef& p : friction.model.parameters()) {
    const double given = value(p.joint, std::string_view(p.owner), std::string_view(p.symbol));
    friction.theta.push_back(std::isnan(given) ? p.info.typical : given);
  }
  return friction;
}

/// Geometric ladder of presliding lengths [rad] for element i of n.
inline double ladder(int i, int n, double shortest, double longest) {
  return shortest * std::pow(longest / shortest, static_cast<double>(i) / (n - 1));
}

inline int element_of(std::string_view symbol) {
  return symbol.back() >= '0' && symbol.back() <= '9'
             ? std::stoi(std::string(symbol.substr(symbol.find_first_of("0123456789"))))
             : 0;
}

/// "coulomb_viscous", "lugre", "gms" (4 elements of 0.6 to 10 mrad) or "maxwell_slip" (10 of 0.2 to
/// 10 mrad and viscous |v|^0.8).
inline friction::Friction kr6_friction(std::string_view law) {
  const bool gms = law == "gms", maxwell = law == "maxwell_slip", sum = law == friction::kLvm;
  const int elements = gms ? 4 : maxwell ? 10 : sum ? friction::LvmParts().elements : 0;
  friction::JointSpec spec{{{std::string(law), elements, {}}}};
  if (maxwell) spec.laws.push_back({"viscous_power", 0, {}});
  if (sum) spec = friction::lvm_sum({});
  return make_friction(6, spec, [&](int joint, std::string_view owner, std::string_view symbol) {
    if (sum && symbol == "Fc" && owner != "gms") return 1e-4;  // the bank holds it
    const JointScale& scale = kJointScales[static_cast<std::size_t>(joint)];
    const double Fs = kStaticOverCoulomb * scale.Fc;
    if (symbol == "Fc") return scale.Fc;
    if (symbol == "Fs") return Fs;
    if (symbol == "vs") return kStribeckVelocity;
    if (symbol == "Fv" || symbol == "sigma2" || symbol == "c") return scale.Fv;
    if (symbol == "sigma0") return scale.sigma0;
    if (symbol == "sigma1") return scale.sigma1;
    if (symbol == "C") return 30 * scale.Fc;
    const int i = element_of(symbol) - 1;
    if (symbol.starts_with("k")) return Fs / elements / ladder(i, elements, 0.6e-3, 10e-3);
    if (symbol.starts_with("K")) return scale.Fc / elements / ladder(i, elements, 0.2e-3, 10e-3);
    if (symbol.starts_with("W")) return scale.Fc / elements;
    return std::nan("");
  });
}

/// Finite Fourier series from rest inside a hanging box: 20 harmonics of 0.2 rad/s, velocity
/// spectrum k^0.5.
class HangingMotion {
 public:
  HangingMotion(std::uint64_t seed, double share = 1) {
    Rng rng(seed, 0x6d6f74696f6e);
    for (std::size_t j = 0; j < 6; ++j) {
      for (int k = 0; k < kHarmonics; ++k)
        for (double& x : coefficients_[j][static_cast<std::size_t>(k)])
          x = std::sqrt(k + 1.0) * rng.normal();
      // from rest: sum a_k = 0, sum k b_k = 0 by the last harmonic
      double a = 0, b = 0;
      for (int k = 0; k + 1 < kHarmonics; ++k) {
        a += coefficients_[j][static_cast<std::size_t>(k)][0];
        b += (k + 1) * coefficients_[j][static_cast<std::size_t>(k)][1];
      }
      coefficients_[j][kHarmonics - 1] = {-a, -b / kHarmonics};
      double low = 0, high = 0;
      for (double t = 0; t < 2 * std::numbers::pi / kBase; t += 0.02) {
        low = std::min(low, shape(j, t).q);
        high = std::max(high, shape(j, t).q);
      }
      scale_[j] = share * 2 * kHalfRange[j] / (high - low);
      offset_[j] = kCentre[j] - scale_[j] * (low + high) / 2;
    }
  }

  struct Point {
    double q, v, a;
  };
  Point at(int joint, double t) const {
    const auto j = static_cast<std::size_t>(joint);
    const Point p = shape(j, t);
    return {offset_[j] + scale_[j] * p.q, scale_[j] * p.v, scale_[j] * p.a};
  }

 private:
  static constexpr int kHarmonics = 20;
  static constexpr double kBase = 0.2;  // [rad/s]
  static constexpr std::array<double, 6> kCentre{0, -1.57, 0.7, 0, 0, 0};
  static constexpr std::array<double, 6> kHalfRange{1.0, 0.5, 0.6, 1.5, 1.0, 2.0};

  Point shape(std::size_t j, double t) const {
    Point p{0, 0, 0};
    for (int k = 1; k <= kHarmonics; ++k) {
      const auto [a, b] = coefficients_[j][static_cast<std::size_t>(k - 1)];
      const double w = k * kBase, c = std::cos(w * t), s = std::sin(w * t);
      p.q += a / w * s - b / w * c;
      p.v += a * c + b * s;
      p.a += w * (b * c - a * s);
    }
    return p;
  }

  std::array<std::array<std::array<double, 2>, kHarmonics>, 6> coefficients_{};
  std::array<double, 6> scale_{}, offset_{};
};

/// A controlled recording: state and friction at each sample and the torque held after it.
struct Recording {
  RowMatrix q, v, tau, tau_f, z;  // (T, .)
};

/// Follows a motion by PD and the rigid body's inverse dynamics, stepped by the engine.
inline Recording record(const Arm& arm, const HangingMotion& motion, int T, StepOptions options) {
  const int n = arm.robot.n(), nz = arm.friction.model.state_size();
  const auto size = static_cast<std::size_t>(n);
  Recording out{RowMatrix(T, n), RowMatrix(T, n), RowMatrix(T, n), RowMatrix(T, n),
                RowMatrix(T, nz)};
  ArmStepper<double> stepper(arm, options);
  dynamics::Workspace<double> ws(arm.robot);
  const std::span<const double> pi(arm.robot.pi.data(),
                                   static_cast<std::size_t>(arm.robot.pi.size()));
  std::vector<double> q(size), v(size, 0.0), z(static_cast<std::size_t>(nz), 0.0), a(size),
      tau(size), tau_f(size), temperature(size, kRoomTemperature);
  for (int j = 0; j < n; ++j) q[static_cast<std::size_t>(j)] = motion.at(j, 0).q;
  for (int k = 0; k < T; ++k) {
    for (int j = 0; j < n; ++j) {
      const auto i = static_cast<std::size_t>(j);
      const auto wanted = motion.at(j, k * kSamplePeriod);
      a[i] = wanted.a + 2500 * (wanted.q - q[i]) + 90 * (wanted.v - v[i]);
    }
    dynamics::rnea<double>(arm.robot, ws, pi, q, v, a, tau);
    stepper.friction_torque(tau, temperature, q, v, z, tau_f);
    const auto put = [k](RowMatrix& matrix, const std::vector<double>& row) {
      std::copy(row.begin(), row.end(), matrix.row(k).data());
    };
    put(out.q, q);
    put(out.v, v);
    put(out.tau, tau);
    put(out.tau_f, tau_f);
    put(out.z, z);
    stepper.step(tau, temperature, kSamplePeriod, q, v, z);
  }
  return out;
}

}  // namespace fricid::test
