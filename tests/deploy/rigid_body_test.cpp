// The exported rigid body, read back by the URDF reader and by MuJoCo.
#include <gtest/gtest.h>

#include <limits>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/deploy/export.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "source_dir.hpp"
#include "temporary_folder.hpp"

namespace fricid::deploy::test {
namespace {

data::ModelFile kr6() {
  data::ModelFile model;
  model.name = "lugre";
  model.label = "LuGre";
  model.arm.robot = dynamics::load_urdf(source_dir() / "models/kr6_r700/kr6_r700.urdf");
  // as a fit leaves it: not the nominal one
  model.arm.robot.pi.segment<10>(10) *= 1.1;
  return model;
}

TEST(Urdf, ReadsBackWithTheSameParameters) {
  const data::ModelFile model = kr6();
  const Exported exported = export_model(model, "urdf");
  const auto read = dynamics::parse_urdf(exported.files[0].text, exported.files[0].name);
  ASSERT_EQ(read.n(), model.arm.robot.n());
  const double largest = model.arm.robot.pi.cwiseAbs().maxCoeff();
  for (int i = 0; i < 11 * read.n(); ++i)
    EXPECT_NEAR(read.pi[i], model.arm.robot.pi[i], 1e-13 * largest)
        << read.parameter_names()[static_cast<std::size_t>(i)];
  for (std::size_t j = 0; j < read.joints.size(); ++j) {
    EXPECT_LT((read.joints[j].R0 - model.arm.robot.joints[j].R0).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_EQ(read.joints[j].p0, model.arm.robot.joints[j].p0);
    EXPECT_EQ(read.joints[j].velocity, model.arm.robot.joints[j].velocity);
  }
  EXPECT_EQ(read.frames.size(), model.arm.robot.frames.size());
}

// urdfdom and Pinocchio read no infinite number.
TEST(Urdf, AJointWithoutEndHasNoLimitsOfItsPosition) {
  data::ModelFile model = kr6();
  dynamics::Joint& turns = model.arm.robot.joints[3];
  turns.continuous = true;
  turns.lower = -std::numeric_limits<double>::infinity();
  turns.upper = -turns.lower;
  const std::string text = export_model(model, "urdf").files[0].text;
  EXPECT_EQ(text.find("inf\""), std::string::npos) << text;
  const auto read = dynamics::parse_urdf(text, "read back");
  EXPECT_TRUE(read.joints[3].continuous);
  EXPECT_EQ(read.joints[3].velocity, turns.velocity);
  EXPECT_EQ(read.joints[4].upper, model.arm.robot.joints[4].upper);
}

TEST(Mjcf, IsTheRobotInMujoco) {
  const data::ModelFile model = kr6();
  const OwnFolder folder;
  save(export_model(model, "mjcf"), folder.path());
  const sim::MujocoArm arm(folder.path() / "lugre_s1.xml", model.arm.robot, 1e-3);
  EXPECT_LT(sim::dynamics_mismatch(arm, model.arm.robot), 1e-11);
}

TEST(CoupledMotors, AreTendonsInMujocoAndWordsElsewhere) {
  data::ModelFile model = kr6();
  model.arm.robot.couplings = {{5, 4, -1}, {4, 3, 0.25}};
  const OwnFolder folder;
  save(export_model(model, "mjcf"), folder.path());
  const sim::MujocoArm arm(folder.path() / "lugre_s1.xml", model.arm.robot, 1e-3);
  EXPECT_LT(sim::dynamics_mismatch(arm, model.arm.robot), 1e-11);
  // m5 = q5 - m4 / 4, m6 = q6 + m5
  const std::string words =
      "the motor of joint_a5 turns by joint_a5 - 0.25 joint_a4, the motor of joint_a6 turns by "
      "joint_a6 - 0.25 joint_a4 + joint_a5";
  try {
    export_model(model, "urdf");
    ADD_FAILURE() << "a URDF was written";
  } catch (const UserError& error) {
    EXPECT_EQ(error.what(), "lugre: urdf cannot represent that " + words +
                                "; allowed: c, csv, mjcf, mjcf_friction, plugin, fmu, onnx");
  }
  EXPECT_EQ(export_model(model, "csv").losses.back(),
            "velocity and friction are those of the motors: " + words);
  const std::string coordinates = "q, v and torques are those of the motors: " + words +
                                  "; the torque of a joint is the sum of those of the motors, each "
                                  "times the factor of that joint";
  const Exported header = export_model(model, "c"), fmu = export_model(model, "fmu");
  EXPECT_EQ(header.losses.back(), coordinates);
  EXPECT_EQ(fmu.losses.back(), coordinates);
  for (const Exported& one : {header, fmu})  // in the file itself
    EXPECT_NE(one.files.front().text.find(coordinates), std::string::npos);
}

// Two motors that carry two joints together: m5 = (q5 + q6)/2, m6 = (q6 - q5)/2.
TEST(CoupledMotors, OfADifferentialTurnByTheirShareOfEachJoint) {
  data::ModelFile model = kr6();
  model.arm.robot.couplings = {{4, 5, -1}, {5, 4, 1}};
  const std::string found = export_model(model, "csv").losses.back();
  EXPECT_EQ(found,
            "velocity and friction are those of the motors: the motor of joint_a5 turns by 0.5 "
            "joint_a5 + 0.5 joint_a6, the motor of joint_a6 turns by 0.5 joint_a6 - 0.5 joint_a5");
}

TEST(RigidBody, InertiaThatNoBodyHasIsRefused) {
  data::ModelFile model = kr6();
  model.arm.robot.pi[0] = -1;
  for (const char* format : {"urdf", "mjcf"}) EXPECT_THROW(export_model(model, format), UserError);
}

}  // namespace
}  // namespace fricid::deploy::test
