#include "fricid/dynamics/nominal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/physical_inertia.hpp"

namespace fricid::dynamics {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRiseTime = 0.03;        // [s]
constexpr double kShareOfLinks = 1. / 3;  // of the links' inertia, where there are no limits
constexpr double kNothing = 1e-9;         // of the robot's largest inertia; below it counts as zero
constexpr double kDensity = 2000;         // of a link, hollows included [kg/m^3]
constexpr double kStrictly = 1e-6;        // least eigenvalue of a pseudo-inertia over the mass
constexpr int kPoses = 20;
constexpr std::uint64_t kSamplesSeed = 1993;

/// Largest inertia of each joint over random poses, with the other joints held and with them free.
struct JointInertia {
  VectorXd held, free;  // (n) [kg m^2 or kg]
};

JointInertia joint_inertia(const RobotModel& robot) {
  const auto n = static_cast<std::size_t>(robot.n());
  JointInertia largest{VectorXd::Zero(robot.n()), VectorXd::Zero(robot.n())};
  Workspace<double> ws(robot);
  Rng rng(kSamplesSeed, 0);
  const MatrixXd C = robot.motors_of_joints();
  VectorXd q(robot.n());
  std::vector<double> M(n * n);
  for (int pose = 0; pose < kPoses; ++pose) {
    for (std::size_t j = 0; j < n; ++j) {
      const Joint& joint = robot.joints[j];
      const auto [lower, upper] = travel_of(joint);
      q[static_cast<Eigen::Index>(j)] = lower + (upper - lower) * rng.uniform();
    }
    const VectorXd motors = C * q;
    crba<double>(robot, ws, {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())},
                 {motors.data(), n}, M);
    MatrixXd A = Eigen::Map<MatrixXd>(M.data(), robot.n(), robot.n());
    largest.held = largest.held.cwiseMax(A.diagonal());
    // free one joint after another, from the tips
    const double scale = A.diagonal().maxCoeff();
    for (int j = robot.n() - 1; j >= 0; --j) {
      largest.free[j] = std::max(largest.free[j], A(j, j));
      if (A(j, j) > kNothing * scale)
        A.topLeftCorner(j, j) -= A.col(j).head(j) * A.row(j).head(j) / A(j, j);
    }
  }
  return largest;
}

}  // namespace

VectorXd usual_armature(const RobotModel& robot) {
  const VectorXd of_links = joint_inertia(robot).held;
  VectorXd usual(robot.n());
  for (int j = 0; j < robot.n(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    const double by_limits = joint.velocity > 0 ? kRiseTime * joint.effort / joint.velocity : 0;
    const double by_links = of_links[j] > 0 ? of_links[j] : of_links.maxCoeff();
    usual[j] = by_limits > 0 ? by_limits : kShareOfLinks * by_links;
  }
  return usual;
}

void require_inertia(const RobotModel& robot, const std::string& source) {
  const JointInertia inertia = joint_inertia(robot);
  for (int j = robot.n() - 1; j >= 0; --j) {
    if (inertia.free[j] > kNothing * inertia.held.maxCoeff()) continue;
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    throw UserError(
        "{}: joint {} has no armature and its link {} has no inertia about its axis: any torque "
        "would accelerate it infinitely; give the joint <fricid armature=\"{:.2g}\"/> (kg m^2, "
        "typical for its limits), state it in a scene as robot.armature, or give the link its "
        "inertia",
        source, joint.name, joint.link, usual_armature(robot)[j]);
  }
}

Nominal complete(const RobotModel& robot) {
  Nominal out{robot, {}};
  VectorXd& pi = out.robot.pi;
  const VectorXd usual = usual_armature(robot);
  for (int j = 0; j < robot.n(); ++j) {
    if (double& armature = pi[robot.armature_begin() + j]; armature == 0) {
      armature = usual[j];
      out.guesses.armature.push_back(j);
    }
    auto link = pi.segment<10>(10 * j);
    const bool mended = std::ranges::any_of(robot.frames, [&](const Frame& frame) {
      return frame.link == j && std::ranges::count(robot.mended_links, frame.name) > 0;
    });
    if (mended) out.guesses.inertia.push_back(j);
    if (mended || is_physical(link, kStrictly)) continue;
    const double m = link[0];
    const double radius = std::cbrt(m / (4. / 3 * std::numbers::pi * kDensity));
    const double ball = 0.4 * m * radius * radius;
    for (const int diagonal : {4, 6, 9}) link[diagonal] += ball;
    out.guesses.inertia.push_back(j);
  }
  return out;
}

}  // namespace fricid::dynamics
