// MuJoCo as a guest: its errors, its files, and what a model must be like.
#include "fricid/sim/mujoco_arm.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "arms.hpp"
#include "fricid/base/error.hpp"
#include "fricid/dynamics/algorithms.hpp"

namespace fricid::sim::test {
namespace {

using testing::HasSubstr;

// A pendulum of 2 kg, 0.3 m below its hinge.
std::string pendulum(const std::string& joint_attributes, const std::string& mass = "2") {
  return "<mujoco><worldbody><body name='base'><body name='arm' pos='0 0 1'><joint name='hinge' "
         "axis='0 1 0' " +
         joint_attributes + "/><inertial pos='0 0 -0.3' mass='" + mass +
         "' diaginertia='.02 .02 .01'/></body></body></worldbody></mujoco>";
}

dynamics::RobotModel pendulum_robot(const std::string& joint = "hinge") {
  return dynamics::parse_urdf(
      "<robot name='p'><link name='base'/><link name='arm'><inertial><origin xyz='0 0 -0.3'/><mass "
      "value='2'/><inertia ixx='.02' iyy='.02' izz='.01' ixy='0' ixz='0' "
      "iyz='0'/></inertial></link>"
      "<joint name='" +
          joint +
          "' type='revolute'><origin xyz='0 0 1'/><parent link='base'/><child link='arm'/><axis "
          "xyz='0 1 "
          "0'/><limit lower='-1' upper='1' effort='10' velocity='5'/></joint></robot>",
      "pendulum.urdf");
}

std::string message_of(const std::string& mjcf, const dynamics::RobotModel& robot) {
  const TempFile file("model.xml", mjcf);
  try {
    const MujocoArm arm(file.path(), robot, 5e-4);
  } catch (const UserError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Mujoco, ErrorBecomesExceptionAndLeavesNoFile) {
  initialise_mujoco();
  const std::filesystem::path log = std::filesystem::current_path() / "MUJOCO_LOG.TXT";
  std::filesystem::remove(log);
  EXPECT_THROW(mju_error("%s", "made by a test"), std::runtime_error);
  testing::internal::CaptureStderr();
  mju_warning("%s", "made by a test");
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("made by a test"));
  EXPECT_FALSE(std::filesystem::exists(log));
}

TEST(MujocoArm, AcceptsAModelThatAgrees) {
  EXPECT_EQ(message_of(pendulum(""), pendulum_robot()), "accepted");
}

// What is only seen costs steps nothing and changes no bit of the motion.
TEST(MujocoArm, MovesWithoutItsLooks) {
  for (const char* name : {"kr6_full", "kr6_paper3"}) {
    const scene::Problem problem = resolve(scene(name));
    const MujocoArm arm = make_arm(problem);
    EXPECT_GT(arm.model().ngeom, 0);
    EXPECT_EQ(arm.moving().ngeom + arm.moving().nsite + arm.moving().ncam, 0);
    const MjDataPtr seen = arm.make_data(), bare(mj_makeData(&arm.moving()));
    for (int k = 0; k < 200; ++k)
      for (const auto& [model, data] :
           {std::pair(&arm.model(), seen.get()), std::pair(&arm.moving(), bare.get())}) {
        for (int j = 0; j < arm.n(); ++j)
          data->qfrc_applied[arm.dof(j)] = 20 * std::sin(.05 * k + j);
        mj_step(model, data);
      }
    for (int j = 0; j < arm.n(); ++j) {
      EXPECT_EQ(seen->qpos[arm.qpos(j)], bare->qpos[arm.qpos(j)]) << name << " joint " << j;
      EXPECT_NE(bare->qvel[arm.dof(j)], 0);
    }
  }
}

// A body that takes its inertia from its geoms needs them.
TEST(MujocoArm, KeepsLooksThatGiveInertia) {
  // 2/5 m r^2 = .02 about the hinge's axis
  const TempFile file("model.xml",
                      "<mujoco><worldbody><body name='base'><body name='arm' pos='0 0 1'>"
                      "<joint name='hinge' axis='0 1 0'/><geom pos='0 0 -0.3' "
                      "size='0.158113883008419' mass='2'/></body></body></worldbody></mujoco>");
  const MujocoArm arm(file.path(), pendulum_robot(), 5e-4);
  EXPECT_EQ(&arm.moving(), &arm.model());
}

TEST(MujocoArm, RefusesFrictionOfMujoco) {
  EXPECT_THAT(message_of(pendulum("damping='0.1'"), pendulum_robot()), HasSubstr("damping 0.1"));
  EXPECT_THAT(message_of(pendulum("frictionloss='3'"), pendulum_robot()),
              HasSubstr("frictionloss 3"));
}

TEST(MujocoArm, RefusesOtherJoints) {
  EXPECT_THAT(message_of(pendulum(""), pendulum_robot("elbow")), HasSubstr("elbow"));
  EXPECT_THAT(message_of(pendulum("type='slide'"), pendulum_robot()), HasSubstr("another type"));
  std::string two = pendulum("");
  two.insert(
      two.find("</worldbody>"),
      "<body><joint name='extra'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body>");
  EXPECT_THAT(message_of(two, pendulum_robot()), HasSubstr("2 degrees of freedom"));
}

TEST(MujocoArm, RefusesOtherDynamics) {
  EXPECT_THAT(message_of(pendulum("", "2.001"), pendulum_robot()), HasSubstr("inverse dynamics"));
  EXPECT_THAT(message_of(pendulum("armature='0.001'"), pendulum_robot()),
              HasSubstr("inverse dynamics"));
  EXPECT_THAT(message_of(pendulum("stiffness='1'"), pendulum_robot()),
              HasSubstr("inverse dynamics"));
  EXPECT_THAT(message_of(pendulum("armature='nan'"), pendulum_robot()),
              HasSubstr("inverse dynamics differ from p by inf"));
}

TEST(MujocoArm, NamesAFileWithABaseWithoutNameThatHasToBeTurned) {
  dynamics::RobotModel on_a_wall = pendulum_robot();
  on_a_wall.gravity = {9.81, 0, 0};
  EXPECT_EQ(message_of(pendulum(""), on_a_wall), "accepted");
  std::string nameless = pendulum("");
  nameless.replace(nameless.find(" name='base'"), 12, "");
  EXPECT_THAT(message_of(nameless, on_a_wall),
              testing::ContainsRegex("model.xml: a body without name; allowed: the base and"));
}

TEST(MujocoArm, NamesAFileThatCannotBeRead) {
  EXPECT_THAT(message_of("<mujoco><worldbody>", pendulum_robot()), HasSubstr("model.xml"));
  try {
    const MujocoArm arm("nowhere.xml", pendulum_robot(), 5e-4);
    FAIL();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("nowhere.xml"));
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
  }
}

// Reference: the engine, whose gravity is turned instead.
TEST(MujocoArm, TurnsTheBaseToAnyMount) {
  scene::RobotSection mount;
  for (const auto& rpy :
       {std::array<double, 3>{3.14159265358979, 0, 0}, {0, 1.5707963, 0}, {0.3, -2, 1}}) {
    mount.mount = scene::Mount::kRpy;
    mount.mount_rpy = rpy;
    const dynamics::RobotModel robot =
        dynamics::load_urdf(source("models/kr6_r700/kr6_r700.urdf"), scene::mount_rotation(mount));
    const MujocoArm arm(source("models/kr6_r700/kr6_r700.xml"), robot, 5e-4);
    EXPECT_LT(dynamics_mismatch(arm, robot, 50), 1e-10);
  }
}

// Reference: the engine, whose rotors sit behind a transmission.
TEST(MujocoArm, CarriesTheRotorsOfCoupledMotors) {
  dynamics::RobotModel robot = dynamics::load_urdf(source("models/kr6_r700/kr6_r700.urdf"));
  for (const std::vector<dynamics::Coupling>& couplings :
       {std::vector<dynamics::Coupling>{{5, 4, -1}},
        {{5, 4, -1}, {5, 3, 0.2}, {4, 3, -0.5}, {2, 1, 1}}}) {
    robot.couplings = couplings;
    for (const std::filesystem::path& file :
         {source("models/kr6_r700/kr6_floor.xml"), std::filesystem::path()}) {
      const MujocoArm arm(file, robot, 5e-4);
      EXPECT_LT(dynamics_mismatch(arm, robot, 50), 1e-10);
      dynamics::RobotModel apart = robot;
      apart.couplings.clear();
      EXPECT_GT(dynamics_mismatch(arm, apart, 50), 1e-4);
    }
  }
}

// Reference: the engine with the same payload.
TEST(MujocoArm, CarriesAPayload) {
  dynamics::RobotModel robot = dynamics::load_urdf(source("models/kr6_r700/kr6_r700.urdf"));
  const auto flange = std::find_if(robot.frames.begin(), robot.frames.end(),
                                   [](const auto& frame) { return frame.name == "flange"; });
  Payload payload{*flange, 3.0, {0.05, 0.02, 0.06}, Eigen::Matrix3d::Zero()};
  payload.inertia.diagonal() << 0.02, 0.03, 0.025;
  payload.inertia(0, 1) = payload.inertia(1, 0) = 0.004;
  for (const bool point_mass : {false, true}) {
    if (point_mass) payload.inertia.setZero();
    dynamics::RobotModel loaded = robot;
    dynamics::add_payload(loaded, payload.frame, payload.mass, payload.com, payload.inertia);
    const MujocoArm arm(source("models/kr6_r700/kr6_floor.xml"), loaded, 5e-4, payload);
    EXPECT_LT(dynamics_mismatch(arm, loaded, 50), 1e-10);
  }
}

// Limits, contacts and self-collision are for the excitation to respect, not for the truth to feel.
TEST(MujocoArm, IsFreeBeyondItsLimits) {
  const TempFile file("model.xml", pendulum("limited='true' range='-0.1 0.1'"));
  const dynamics::RobotModel robot = pendulum_robot();
  const MujocoArm arm(file.path(), robot, 5e-4);
  const MjDataPtr data = arm.make_data();
  data->qpos[0] = 0.8;
  mj_step(&arm.model(), data.get());
  const double gravity_torque = -2 * 9.81 * 0.3 * std::sin(0.8), inertia = 0.02 + 2 * 0.09;
  EXPECT_NEAR(data->qacc[0], gravity_torque / inertia, 1e-12);
}

}  // namespace
}  // namespace fricid::sim::test
