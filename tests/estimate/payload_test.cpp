// A load from logs without and with it. Reference: the load that the simulator put on the flange.
#include "fricid/estimate/rigid_body/payload.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>

#include "fricid/base/error.hpp"
#include "fricid/dynamics/physical_inertia.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::estimate {
namespace {

using dynamics::Vector10;

struct Load {
  double kg;
  std::array<double, 3> com;
  std::array<double, 6> inertia;  ///< xx yy zz xy xz yz about the centre of mass
};

struct Logs {
  dynamics::RobotModel robot;  ///< as its file has it
  signals::Recording recording;
};

/// Friction of gears that are warm: less of it, and it grows less with the load.
void warm_up(friction::Friction& friction) {
  for (std::size_t i = 0; i < friction.theta.size(); ++i) {
    const friction::ParameterRef& parameter = friction.model.parameters()[i];
    if (friction::is_torque(parameter.info.role)) friction.theta[i] *= 0.6;
    if (parameter.symbol.starts_with("mu")) friction.theta[i] *= 0.5;
  }
}

/// 31 s of the KR 6 with the friction of a scene.
Logs simulate(const Load& load, std::uint64_t seed, const char* scene = "kr6_lugre",
              bool warm = false) {
  scene::Scene s = scene::load_scene(source_dir() / fmt::format("scenes/{}.toml", scene));
  s.seed = seed;
  if (warm) warm_up(*s.friction);
  s.excitation.train = s.excitation.repeats = 1;
  s.excitation.validation = 0;
  s.excitation.criterion = sim::Criterion::kNone;
  s.excitation.harmonics = 10;
  s.sensors.rate_hz = 500;
  s.robot.payload_kg = load.kg;
  s.robot.payload_com = load.com;
  s.robot.payload_inertia = load.inertia;
  const scene::Problem problem = scene::resolve(std::move(s));
  return {problem.robot, signals::make_recording(sim::simulate(problem, 1).train[0],
                                                 problem.scene.identify.cutoff_hz)};
}

/// (m, m c, I about the origin) in the axes of the link that carries the frame.
Vector10 parameters(const Load& load,
                    const dynamics::Frame& frame = {.name = "flange", .link = 0}) {
  dynamics::RobotModel nothing;
  nothing.joints.resize(1);
  nothing.pi = Eigen::VectorXd::Zero(nothing.parameter_count());
  const auto& [xx, yy, zz, xy, xz, yz] = load.inertia;
  Eigen::Matrix3d I;
  I << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  dynamics::add_payload(nothing, frame, load.kg, Eigen::Vector3d(load.com.data()), I);
  return nothing.pi.head<10>();
}

const dynamics::Frame& flange(const dynamics::RobotModel& robot) {
  return *std::ranges::find(robot.frames, std::string("flange"), &dynamics::Frame::name);
}

constexpr Load kNone{0, {}, {}};
constexpr Load kGripper{5, {0.02, -0.04, 0.11}, {0.05, 0.06, 0.03, 0.004, -0.006, 0.005}};

TEST(Payload, IsFoundWithinTwoPercent) {
  Logs bare = simulate(kNone, 1), loaded = simulate(kGripper, 2);
  // Every mass of the arm is 15 % off in its file.
  bare.robot.pi.head(bare.robot.armature_begin()) *= 1.15;
  const PayloadFit fit = payload_least_squares(bare.robot, flange(bare.robot), {&bare.recording, 1},
                                               {&loaded.recording, 1}, {});
  ASSERT_EQ(fit.outcome, Outcome::kConverged) << fit.message;
  const Vector10 truth = parameters(kGripper);
  const char* names[]{"m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"};
  for (int i = 0; i < 10; ++i) {
    SCOPED_TRACE(fmt::format("{}: {} for {}, size {}, standard error {}", names[i], fit.pi[i],
                             truth[i], fit.size[i], fit.standard_error[i]));
    EXPECT_NEAR(fit.pi[i], truth[i], 0.02 * fit.size[i]);
    EXPECT_LT(fit.standard_error[i], 0.02 * fit.size[i]);
    EXPECT_NEAR(fit.free[i], truth[i], 5 * fit.standard_error[i]);
  }
  EXPECT_NEAR(fit.body.m, kGripper.kg, 0.02 * kGripper.kg);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(fit.body.c[k], kGripper.com[static_cast<std::size_t>(k)], 2e-3);
  EXPECT_TRUE(dynamics::is_physical(fit.pi));
}

TEST(Payload, AnUnknownTimingOfTheTorqueIsInItsErrors) {
  Logs bare = simulate(kNone, 1), loaded = simulate(kGripper, 2);
  const auto fitted = [&](double unknown) {
    for (Logs* logs : {&bare, &loaded}) logs->recording.log.torque_delay_sd = unknown;
    return payload_least_squares(bare.robot, flange(bare.robot), {&bare.recording, 1},
                                 {&loaded.recording, 1}, {});
  };
  const PayloadFit exact = fitted(0), late = fitted(1e-3);
  EXPECT_EQ(late.free, exact.free);
  for (Eigen::Index i = 0; i < 10; ++i)
    EXPECT_GE(late.standard_error[i], exact.standard_error[i]) << i;
  EXPECT_GT(late.standard_error.norm(), 1.2 * exact.standard_error.norm());
}

// Friction that grows with the torque of the motor is in part in phase with gravity: as Coulomb
// friction alone it moves the centre of mass by a centimetre.
TEST(Payload, IsFoundUnderFrictionThatGrowsWithTheLoad) {
  const Load load{2.5, {0.02, -0.01, 0.08}, {0.012, 0.014, 0.008, 0.001, 0, -0.001}};
  for (const char* scene : {"kr6_load", "kr6_full"}) {
    const Logs bare = simulate(kNone, 1, scene), loaded = simulate(load, 2, scene);
    const PayloadFit fit = payload_least_squares(bare.robot, flange(bare.robot),
                                                 {&bare.recording, 1}, {&loaded.recording, 1}, {});
    EXPECT_NEAR(fit.body.m, load.kg, 0.02 * load.kg) << scene;
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(fit.body.c[k], load.com[static_cast<std::size_t>(k)], 2e-3) << scene << ' ' << k;
  }
}

TEST(Payload, IsFoundUnderFrictionThatHasWarmed) {
  const Load load{2.5, {0.02, -0.01, 0.08}, {0.012, 0.014, 0.008, 0.001, 0, -0.001}};
  const Logs bare = simulate(kNone, 1, "kr6_load"), loaded = simulate(load, 2, "kr6_load", true);
  const PayloadFit fit = payload_least_squares(bare.robot, flange(bare.robot), {&bare.recording, 1},
                                               {&loaded.recording, 1}, {});
  EXPECT_NEAR(fit.body.m, load.kg, 0.01 * load.kg);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(fit.body.c[k], load.com[static_cast<std::size_t>(k)], 2e-3) << k;
}

// Else the scale is a load: 10 % of 50 kg.
TEST(Payload, AnotherTorqueScaleIsNone) {
  const Logs bare = simulate(kNone, 1), loaded = simulate(kGripper, 2);
  for (const double scale : {0.9, 1.1}) {
    signals::Recording scaled = loaded.recording;
    scaled.log.tau *= scale;
    scaled.filtered_tau *= scale;
    const PayloadFit fit = payload_least_squares(bare.robot, flange(bare.robot),
                                                 {&bare.recording, 1}, {&scaled, 1}, {});
    EXPECT_EQ(fit.outcome, Outcome::kFailed) << fit.body.m;
    EXPECT_THAT(fit.message, ::testing::HasSubstr(" times the torque of the arm")) << scale;
  }
}

// Else a tenth of a radian of the third joint is a quarter of a kilogram.
TEST(Payload, AnotherZeroOfAJointIsNone) {
  const Logs bare = simulate(kNone, 1), loaded = simulate(kGripper, 2);
  for (const auto& [joint, by] : {std::pair{1, 0.02}, {2, 0.1}, {4, -0.05}}) {
    signals::Recording shifted = loaded.recording;
    for (signals::Motion* motion : {&shifted.narrow, &shifted.wide})
      motion->q.col(joint).array() += by;
    const PayloadFit fit = payload_least_squares(bare.robot, flange(bare.robot),
                                                 {&bare.recording, 1}, {&shifted, 1}, {});
    EXPECT_EQ(fit.outcome, Outcome::kFailed) << fit.body.m;
    int number = 0;
    double found = 0;
    std::sscanf(fit.message.c_str(), "the logs with the load show joint_a%d %lf", &number, &found);
    EXPECT_EQ(number, joint + 1) << fit.message;
    EXPECT_NEAR(found, by, 0.1 * std::abs(by)) << fit.message;
    EXPECT_THAT(fit.message, ::testing::HasSubstr("another zero of the joint"));
  }
}

// A small weight has hardly any inertia about itself: free estimates of it are those of no body.
TEST(Payload, IsABody) {
  const Load weight{1, {0, 0, 0.05}, {1e-4, 1e-4, 1e-4, 0, 0, 0}};
  const Logs bare = simulate(kNone, 3), loaded = simulate(weight, 4);
  const PayloadFit fit = payload_least_squares(bare.robot, flange(bare.robot), {&bare.recording, 1},
                                               {&loaded.recording, 1}, {});
  EXPECT_FALSE(dynamics::is_physical(fit.free));
  EXPECT_TRUE(dynamics::is_physical(fit.pi));
  EXPECT_NEAR(fit.body.m, 1, 0.02);
  EXPECT_NEAR(fit.body.c[2], 0.05, 0.01);
}

TEST(Payload, TwoLogsOfTheSameArmHaveNone) {
  const Logs one = simulate(kNone, 5), other = simulate(kNone, 6);
  const PayloadFit fit = payload_least_squares(one.robot, flange(one.robot), {&one.recording, 1},
                                               {&other.recording, 1}, {});
  for (int i = 0; i < 10; ++i) EXPECT_LT(std::abs(fit.free[i]), 5 * fit.standard_error[i]) << i;
  EXPECT_LT(fit.body.m, 0.05);
}

TEST(Payload, InTheOtherLogIsAFailure) {
  const Logs bare = simulate(kNone, 1), loaded = simulate(kGripper, 2);
  const PayloadFit fit = payload_least_squares(bare.robot, flange(bare.robot),
                                               {&loaded.recording, 1}, {&bare.recording, 1}, {});
  EXPECT_EQ(fit.outcome, Outcome::kFailed);
  EXPECT_THAT(fit.message,
              testing::MatchesRegex("the logs with the load show (4\\.9|5).* kg less than those "
                                    "without it: swap the two"));
}

// Oracle: the other way round, from a frame to its link.
TEST(Payload, IsToldInTheAxesOfItsFrame) {
  const Eigen::Matrix3d R = Eigen::Quaterniond(0.5, -0.1, 0.7, 0.2).normalized().toRotationMatrix();
  const Eigen::Vector3d p(0.1, -0.3, 0.2);
  const Vector10 in_link = parameters(kGripper, {.name = "tool", .link = 0, .R = R, .p = p});
  const Vector10 in_frame = dynamics::inertia_in_frame(R, p) * in_link;
  EXPECT_LT((in_frame - parameters(kGripper)).norm(), 1e-12);
}

TEST(Payload, NeedsAFrameThatMoves) {
  const dynamics::RobotModel robot =
      dynamics::load_urdf(source_dir() / "models/kr6_r700/kr6_r700.urdf");
  try {
    payload_least_squares(robot, {.name = "base_link", .link = -1}, {}, {}, {});
    FAIL();
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(), "frame base_link: does not move; allowed: one that a joint carries");
  }
}

}  // namespace
}  // namespace fricid::estimate
