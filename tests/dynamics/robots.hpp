// Robots and random states that the tests of rigid-body dynamics share.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "source_dir.hpp"

namespace fricid::dynamics::test {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

inline constexpr int kStates = 1000;  // random states per robot and claim

/// TOL_SCALE=0 in the environment shows every residual.
inline double tolerance(double value) {
  static const char* const scale = std::getenv("TOL_SCALE");
  return scale ? value * std::atof(scale) : value;
}

inline RobotModel load(const std::string& path_below_models) {
  return load_urdf(source_dir() / "models" / path_below_models);
}

/// Every robot of the tree, the KR6 with payload, counterbalance and springs, and that with a
/// coupled wrist and further motors that turn two joints.
inline std::vector<RobotModel> all_robots() {
  std::vector<RobotModel> robots;
  for (const char* path : {"test/pendulum.urdf", "test/planar_2r.urdf", "test/scara.urdf",
                           "test/branched.urdf", "test/arm_7r.urdf", "kr6_r700/kr6_r700.urdf"})
    robots.push_back(load(path));
  RobotModel loaded = robots.back();
  loaded.name = "kr6 with payload and linear torques";
  add_payload(loaded, Frame{.name = "tool", .link = 5, .p = {0.05, 0.01, 0.02}}, 3,
              {0.06, -0.02, 0.08}, Vector3d(0.01, 0.012, 0.009).asDiagonal());
  using Shape = LinearTorque::Shape;
  add_linear_torque(loaded, {.name = "sin", .joint = 1, .shape = Shape::kSin, .k = 2}, 20);
  add_linear_torque(loaded, {.name = "cos", .joint = 1, .shape = Shape::kCos, .k = 1}, -35);
  add_linear_torque(loaded, {.name = "spring", .joint = 2, .shape = Shape::kLinear}, 4);
  add_linear_torque(loaded, {.name = "offset", .joint = 4, .shape = Shape::kConstant}, 0.3);
  robots.push_back(loaded);
  loaded.name = "kr6 with coupled motors";
  loaded.couplings = {{5, 4, -1}, {4, 3, 0.2}, {1, 0, 0.5}, {2, 5, -0.3}};
  robots.push_back(loaded);
  return robots;
}

/// A tree of n links with random masses, and joints of random kind whose axes and placements are
/// quarter turns, half turns or anything.
inline RobotModel random_tree(int n, std::uint64_t seed, bool chain = false) {
  Rng rng(seed, 0);
  const auto pick = [&rng](int count) { return static_cast<int>(count * rng.uniform()); };
  const auto vector = [&rng] { return Vector3d(rng.normal(), rng.normal(), rng.normal()); };
  RobotModel model;
  model.name = fmt::format("random tree {}", seed);
  model.pi.resize(11 * n);
  for (int i = 0; i < n; ++i) {
    Joint joint;
    joint.name = fmt::format("j{}", i);
    joint.link = fmt::format("l{}", i);
    joint.type = pick(4) == 0 ? JointType::kPrismatic : JointType::kRevolute;
    joint.parent = chain ? i - 1 : pick(i + 1) - 1;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    for (int turns = pick(4); turns > 0; --turns)
      R = R * Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::Unit(pick(3))).toRotationMatrix();
    if (pick(3) == 0) R = Eigen::AngleAxisd(rng.normal(), vector().normalized()).toRotationMatrix();
    joint.R0 = R;
    joint.p0 = pick(2) == 0 ? Vector3d(0.3 * vector()) : Vector3d(0.4 * Vector3d::Unit(pick(3)));
    joint.axis = pick(3) == 0 ? vector().normalized()
                              : Vector3d((pick(2) ? 1 : -1) * Vector3d::Unit(pick(3)));
    joint.lower = -2.5;
    joint.upper = 2.5;
    model.joints.push_back(joint);

    // a box of random sides about a random point
    const double m = 0.5 + 3 * rng.uniform();
    const Vector3d side = Vector3d(rng.uniform(), rng.uniform(), rng.uniform()) * 0.3;
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(rng.normal(), vector().normalized()).toRotationMatrix();
    const Eigen::Matrix3d about_com =
        turn * Vector3d(m / 12 * (side.squaredNorm() - side.array().square())).asDiagonal() *
        turn.transpose();
    model.pi.segment<10>(10 * i).setZero();
    add_payload(model, Frame{.name = "", .link = i}, m, 0.1 * vector(), about_com);
    model.pi(10 * n + i) = 0.2 * rng.uniform();
  }
  return model;
}

struct State {
  VectorXd q, v, a, tau;
};

/// State k of a robot: inside its limits, every tenth at rest, every seventh at quarter turns,
/// where wrists and elbows are singular.
inline State random_state(const RobotModel& model, int k) {
  Rng rng(7, static_cast<std::uint64_t>(k));
  const int n = model.n();
  State state{VectorXd(n), VectorXd(n), VectorXd(n), VectorXd(n)};
  for (int i = 0; i < n; ++i) {
    const Joint& joint = model.joints[static_cast<size_t>(i)];
    const double lower = joint.continuous ? -std::numbers::pi : joint.lower;
    const double upper = joint.continuous ? std::numbers::pi : joint.upper;
    double q = lower + (upper - lower) * rng.uniform();
    if (k % 7 == 0 && joint.type == JointType::kRevolute)
      q = std::round(q / (std::numbers::pi / 2)) * (std::numbers::pi / 2);
    state.q(i) = q;
    state.v(i) = k % 10 == 0 ? 0.0 : 2 * rng.normal();
    state.a(i) = 5 * rng.normal();
    state.tau(i) = 20 * rng.normal();
  }
  return state;
}

inline std::span<const double> view(const VectorXd& x) {
  return {x.data(), static_cast<size_t>(x.size())};
}
inline std::span<double> view(VectorXd& x) { return {x.data(), static_cast<size_t>(x.size())}; }

/// Eigen in, Eigen out, for one model at its nominal parameters unless told otherwise.
class Robot {
 public:
  explicit Robot(const RobotModel& model) : Robot(model, model.pi) {}
  Robot(const RobotModel& model, VectorXd pi) : model_(model), ws_(model), pi_(std::move(pi)) {}

  VectorXd rnea(const VectorXd& q, const VectorXd& v, const VectorXd& a) {
    VectorXd tau(model_.n());
    dynamics::rnea<double>(model_, ws_, view(pi_), view(q), view(v), view(a), view(tau));
    return tau;
  }
  VectorXd gravity(const VectorXd& q) {
    const VectorXd zero = VectorXd::Zero(model_.n());
    return rnea(q, zero, zero);
  }
  MatrixXd mass(const VectorXd& q) {
    Eigen::Matrix<double, -1, -1, Eigen::RowMajor> M(model_.n(), model_.n());
    dynamics::crba<double>(model_, ws_, view(pi_), view(q),
                           {M.data(), static_cast<size_t>(M.size())});
    return M;
  }
  VectorXd forward(const VectorXd& q, const VectorXd& v, const VectorXd& tau) {
    VectorXd a(model_.n());
    forward_dynamics<double>(model_, ws_, view(pi_), view(q), view(v), view(tau), view(a));
    return a;
  }
  VectorXd solve(const VectorXd& b) {
    VectorXd x(model_.n());
    solve_with_last_factor<double>(model_, ws_, view(b), view(x));
    return x;
  }
  MatrixXd regressor(const VectorXd& q, const VectorXd& v, const VectorXd& a) {
    MatrixXd Y(model_.n(), model_.parameter_count());
    dynamics::regressor(model_, ws_, view(q), view(v), view(a), Y);
    return Y;
  }
  double kinetic(const VectorXd& q, const VectorXd& v) {
    return kinetic_energy(model_, ws_, view(pi_), view(q), view(v));
  }
  double potential(const VectorXd& q) { return potential_energy(model_, ws_, view(pi_), view(q)); }

 private:
  const RobotModel& model_;
  Workspace<double> ws_;
  VectorXd pi_;
};

/// |x - y| <= tol max(|y|, floor), largest components.
inline ::testing::AssertionResult close(const VectorXd& x, const VectorXd& y, double tol,
                                        double floor = 1) {
  const double error = (x - y).cwiseAbs().maxCoeff();
  const double scale = std::max(y.cwiseAbs().maxCoeff(), floor);
  if (error <= tolerance(tol) * scale) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << "relative error " << error / scale << " > " << tolerance(tol) << "\n  " << x.transpose()
         << "\n  " << y.transpose();
}
inline ::testing::AssertionResult close(double x, double y, double tol, double floor = 1) {
  return close(VectorXd::Constant(1, x), VectorXd::Constant(1, y), tol, floor);
}

}  // namespace fricid::dynamics::test
