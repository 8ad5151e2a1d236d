#include "fricid/sim/excitation.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "arms.hpp"
#include "fricid/base/error.hpp"
#include "fricid/sim/clearance.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::sim::test {
namespace {

using testing::HasSubstr;

bool same_bytes(const Fourier& x, const Fourier& y) {
  const auto same = [](const auto& a, const auto& b) {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) ==
               0;
  };
  return same(x.q0, y.q0) && same(x.a, y.a) && same(x.b, y.b);
}

// The full design of one scene, made once.
struct Designed {
  scene::Problem problem = [] {
    scene::Scene full = scene("kr6_full");
    full.excitation.train = 1;
    full.excitation.validation = 1;
    full.excitation.restarts = 8;
    return resolve(std::move(full));
  }();
  MujocoArm arm = make_arm(problem);
  Excitation excitation = design_excitation(problem.scene.excitation, arm, problem.robot, 1, 2);

  static const Designed& once() {
    static const Designed designed;
    return designed;
  }
};

// Claim: between the points of the design every limit holds too.
TEST(Excitation, KeepsAllLimitsOnADenserGrid) {
  const Designed& d = Designed::once();
  constexpr int kDesignPoints = 80 * 20;
  for (const Fourier& series : {d.excitation.train[0], d.excitation.validation[0]}) {
    const TrajectoryReport report =
        examine(series, d.problem.scene.excitation, d.arm, d.problem.robot, 5 * kDesignPoints);
    EXPECT_TRUE(report.feasible);
    EXPECT_GE(report.clearance_m, d.problem.scene.excitation.clearance_m) << report.closest;
    for (std::size_t j = 0; j < report.joints.size(); ++j) {
      SCOPED_TRACE(d.problem.robot.joints[j].name);
      const JointMargins& margins = report.joints[j];
      EXPECT_GE(margins.position_rad, 0);
      EXPECT_GE(margins.velocity, 0);
      EXPECT_GE(margins.acceleration, 0);
      EXPECT_GE(margins.jerk, 0);
      EXPECT_GE(margins.torque, 0);
      EXPECT_LT(margins.velocity, 1) << "it moves";
    }
  }
}

// Claim: whichever limit is tight is kept and reached.
TEST(Excitation, ReachesWhicheverLimitIsTight) {
  using Share = double ExcitationOptions::*;
  using Margin = double JointMargins::*;
  const std::vector<std::pair<Share, Margin>> limits{
      {&ExcitationOptions::velocity_share, &JointMargins::velocity},
      {&ExcitationOptions::acceleration_share, &JointMargins::acceleration},
      {&ExcitationOptions::jerk_share, &JointMargins::jerk}};
  for (const auto& [share, margin] : limits) {
    scene::Scene small = small_scene("kr6_gms");
    small.excitation.*share = 0.01;
    const scene::Problem problem = resolve(std::move(small));
    const MujocoArm arm = make_arm(problem);
    const Excitation excitation =
        design_excitation(problem.scene.excitation, arm, problem.robot, 1, 2);
    for (const JointMargins& joint : excitation.reports[0].joints) {
      EXPECT_GE(joint.*margin, 0);
      EXPECT_LT(joint.*margin, 0.1);
    }
  }
}

TEST(Excitation, StartsAndEndsAtRest) {
  for (const Fourier& series : Designed::once().excitation.train) {
    const Motion ends =
        TimeGrid(series.w, series.harmonics(), Eigen::Vector2d(0, series.period())).sample(series);
    EXPECT_LT(ends.v.cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_LT(ends.a.cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(Excitation, OptimiserImprovesTheBestStart) {
  for (const TrajectoryReport& report : Designed::once().excitation.reports) {
    EXPECT_GT(report.log_det, report.log_det_start + 3) << report.name;
    EXPECT_LT(report.condition, 300) << report.name;
    EXPECT_GT(report.evaluations, 100) << report.name;
  }
}

TEST(Excitation, ValidationIsAnotherMotion) {
  const Excitation& e = Designed::once().excitation;
  // correlation of the velocity coefficients of each joint
  for (int j = 0; j < 6; ++j) {
    const Eigen::VectorXd x = e.train[0].a.row(j), y = e.validation[0].a.row(j);
    EXPECT_LT(std::abs(x.dot(y)) / (x.norm() * y.norm()), 0.85) << "joint " << j;
  }
}

TEST(Excitation, DependsOnSeedAndNotOnJobs) {
  scene::Scene small = small_scene("kr6_gms");
  small.excitation.train = 2;
  const scene::Problem problem = resolve(std::move(small));
  const MujocoArm arm = make_arm(problem);
  const auto design = [&](std::uint64_t seed, int jobs) {
    return design_excitation(problem.scene.excitation, arm, problem.robot, seed, jobs);
  };
  const Excitation one = design(1, 1), three = design(1, 3), other = design(2, 1);
  EXPECT_TRUE(same_bytes(one.train[0], three.train[0]));
  EXPECT_TRUE(same_bytes(one.train[1], three.train[1]));
  EXPECT_TRUE(same_bytes(one.validation[0], three.validation[0]));
  EXPECT_FALSE(same_bytes(one.train[0], other.train[0]));
  EXPECT_FALSE(same_bytes(one.train[0], one.train[1]));
}

std::string refusal(const scene::Scene& scene) {
  const scene::Problem problem = resolve(scene);
  try {
    design_excitation(problem.scene.excitation, make_arm(problem), problem.robot, 1, 1);
  } catch (const UserError& error) {
    return error.what();
  }
  return "designed";
}

TEST(Excitation, SaysWhichLimitCannotBeKept) {
  scene::Scene small = small_scene("kr6_gms");
  small.excitation.clearance_m = 0.5;
  // which bodies, how near, how far they must be, and what to do: never 0.112 m where 0.03 suffice
  const std::string near = refusal(small);
  EXPECT_THAT(near, testing::ContainsRegex(
                        "[a-z0-9_]+ - [a-z0-9_]+: 0[.][0-4][0-9]+ m apart at their nearest in the "
                        "best motion found; allowed: clearance_m = 0.5 or more; lower it, or "
                        "shrink half_range"));
  small = small_scene("kr6_gms");
  small.excitation.torque_share = 0.1;
  EXPECT_THAT(refusal(small), HasSubstr("torque_share = 0.1"));
  small = small_scene("kr6_gms");
  small.excitation.centre[1] = 0.5;
  EXPECT_THAT(refusal(small), HasSubstr("joint_a2: box"));
}

// Claim: a motion whose end is the end of its box is no violation, however its angles are rounded.
TEST(Excitation, MayTouchTheEndOfItsBox) {
  const TempFile file("box.toml", fmt::format(R"(
[robot]
urdf = "{}"
[excitation]
half_range = 1.2
velocity_share = 0.5
train = 2
validation = 1
restarts = 6
[[friction.law]]
law = "viscous"
Fv = 1
)",
                                              source("models/test/arm_7r.urdf").string()));
  const scene::Problem problem = resolve(scene::load_scene(file.path()));
  const MujocoArm arm = make_arm(problem);
  const Excitation excitation =
      design_excitation(problem.scene.excitation, arm, problem.robot, 1, 2);
  double nearest = 1;
  for (const TrajectoryReport& report : excitation.reports)
    for (const JointMargins& joint : report.joints) nearest = std::min(nearest, joint.position_rad);
  EXPECT_NEAR(nearest, 0, 1e-9) << "one does touch it";
}

TEST(Trajectory, IsInMetresForAJointThatSlides) {
  const dynamics::RobotModel scara = dynamics::load_urdf(source("models/test/scara.urdf").string());
  Fourier series;
  series.q0 = Eigen::VectorXd::Zero(scara.n());
  series.a = series.b = Eigen::MatrixXd::Ones(scara.n(), 1);
  const std::string text = trajectory_toml(series, scara);
  for (const dynamics::Joint& joint : scara.joints) {
    const char* unit = slides(joint) ? "m" : "rad";
    EXPECT_THAT(text, HasSubstr(fmt::format("\"{}\"\nq0 = 0  # {}\na = [1]  # {}/s\n", joint.name,
                                            unit, unit)));
  }
}

// Two links on a base above a floor, spheres that overlap at the joints. Left are base - second
// link, first link - floor and second link - floor.
TEST(Clearance, LeavesOutWhatCannotOrMustMeet) {
  const auto link = [](const std::string& name) {
    return "<link name='" + name +
           "'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' "
           "iyz='0'/></inertial></link>";
  };
  const auto joint = [](const std::string& name, const std::string& parent,
                        const std::string& child) {
    return "<joint name='" + name + "' type='continuous'><parent link='" + parent +
           "'/><child link='" + child + "'/><origin xyz='0 0 0.3'/><axis xyz='0 1 0'/></joint>";
  };
  const dynamics::RobotModel robot =
      dynamics::parse_urdf("<robot name='r'><link name='base'/>" + link("one") + link("two") +
                               joint("j1", "base", "one") + joint("j2", "one", "two") + "</robot>",
                           "chain.urdf");
  const std::string body = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/><geom size='0.2'/>";
  const TempFile file(
      "chain.xml",
      "<mujoco><worldbody><geom name='floor' type='plane' size='1 1 1' pos='0 0 -1'/><body "
      "name='base'><geom size='0.2'/><body name='one' pos='0 0 0.3'><joint name='j1' axis='0 1 "
      "0'/>" +
          body + "<body name='two' pos='0 0 0.3'><joint name='j2' axis='0 1 0'/>" + body +
          "</body></body></body></worldbody></mujoco>");
  const MujocoArm arm(file.path(), robot, 1e-3);
  Clearance clearance(arm, 1);
  EXPECT_EQ(clearance.pair_count(), 3);
  // closed form: base and second link are 0.6 apart, less two radii
  const Clearance::Pair pair = clearance.closest(std::vector<double>{0, 0});
  EXPECT_NEAR(pair.distance, 0.2, 1e-9);
  EXPECT_EQ(clearance.name(pair), "base - two");
}

TEST(Clearance, SeesTheArmTheBaseAndTheRoom) {
  const scene::Problem problem = resolve(scene("kr6_floor"));
  const MujocoArm arm = make_arm(problem);
  Clearance clearance(arm, 0.2);
  // stretched forwards and down: the wrist is below the floor
  const std::vector<double> below{0, 0.7, 0, 0, 0, 0};
  Clearance::Pair pair = clearance.closest(below);
  EXPECT_LT(pair.distance, 0);
  // folded back over the base
  const std::vector<double> folded{0, -2.2, 2.7, 0, 0, 0};
  pair = clearance.closest(folded);
  EXPECT_LT(pair.distance, 0.05);
  EXPECT_THAT(clearance.name(pair), HasSubstr("link_"));
  // home: nothing but what the arm's shape brings along
  const std::vector<double> home{0, -1.5708, 1.5708, 0, 0, 0};
  EXPECT_GT(clearance.closest(home).distance, 0.015);
}

}  // namespace
}  // namespace fricid::sim::test
