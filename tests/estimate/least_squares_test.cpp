#include "fricid/estimate/least_squares.hpp"

#include <gmock/gmock.h>
#include <Eigen/QR>

#include "arm_data.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/dynamics/physical_inertia.hpp"
#include "fricid/estimate/fit.hpp"

namespace fricid::estimate {
namespace {

// Coulomb friction of 4 N m, viscous 2 N m s/rad, switching within 1 mrad/s.
Arm coulomb_arm() {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("coulomb_viscous", {4, 2, 1e-3}, arm.robot.n());
  return arm;
}

std::vector<Filtered> filtered_logs(const Arm& arm, LogOptions options, int count) {
  std::vector<Filtered> out;
  for (int i = 0; i < count; ++i) {
    options.seed = 100 + static_cast<std::uint64_t>(i);
    out.push_back(filter_dataset(make_log(arm, options), 10));
  }
  return out;
}

// A robot that differs from the truth by what a CAD file may be wrong.
dynamics::RobotModel wrong_cad(const dynamics::RobotModel& truth) {
  dynamics::RobotModel robot = truth;
  Rng rng(5, 0);
  for (int i = 0; i < robot.n(); ++i) {
    auto eta = dynamics::log_cholesky_from_inertia(robot.pi.segment<10>(10 * i));
    for (int k = 0; k < 10; ++k) eta[k] += 0.1 * rng.normal();
    robot.pi.segment<10>(10 * i) = dynamics::inertia_from_log_cholesky(eta);
    robot.pi[robot.armature_begin() + i] *= 1.3;
  }
  return robot;
}

// Reference: the injected truth, with clean data from an integrator of its own. Coulomb friction to
// 0.3 %, viscous to 0.5 %; base parameters to 0.2 % of the largest, since filtered torque steps of
// the other joints reach the weak ones.
TEST(RigidBodyLeastSquares, FindsTruthWithoutNoise) {
  const Arm arm = coulomb_arm();
  LogOptions options;
  options.substeps = 100;
  const auto sequences = filtered_logs(arm, options, 3);
  const RigidBodyFit fit = rigid_body_least_squares(wrong_cad(arm.robot), sequences, {});
  ASSERT_EQ(fit.outcome, Outcome::kConverged) << fit.message;
  const auto base = dynamics::base_parameters(arm.robot);
  const Eigen::VectorXd truth = base.K * arm.robot.pi;
  const double scale = truth.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < truth.size(); ++i) {
    SCOPED_TRACE(fit.base_names[static_cast<std::size_t>(i)]);
    EXPECT_NEAR(fit.base[i], truth[i], 2e-3 * scale);
    EXPECT_NEAR(fit.base_physical[i], truth[i], 2e-3 * scale);
  }
  for (int j = 0; j < arm.robot.n(); ++j) {
    const auto begin = static_cast<std::size_t>(3 * j);
    EXPECT_NEAR(fit.Fc[j], arm.friction.theta[begin], 3e-3 * arm.friction.theta[begin]);
    EXPECT_NEAR(fit.Fv[j], arm.friction.theta[begin + 1], 5e-3 * arm.friction.theta[begin + 1]);
    EXPECT_NEAR(fit.offset[j], 0, 3e-3 * arm.friction.theta[begin]);
  }
}

}  // namespace
}  // namespace fricid::estimate
