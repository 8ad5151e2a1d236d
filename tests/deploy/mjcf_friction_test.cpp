// Friction in MJCF's own words, in MuJoCo, against the laws.
#include <gtest/gtest.h>

#include <cmath>

#include "fricid/base/error.hpp"
#include "in_mujoco.hpp"
#include "law_errors.hpp"
#include "mjcf_apart.hpp"

namespace fricid::deploy::test {
namespace {

// The bank is the law: springs that yield, stepped with the new position.
TEST(MjcfFriction, MaxwellSlipIsTheLaw) {
  const data::ModelFile model = robot_with("maxwell_slip");
  const Exported exported = export_model(model, "mjcf_friction");
  EXPECT_TRUE(exported.losses.empty());
  EXPECT_NE(exported.files[0].text.find("Euler, implicit or implicitfast"), std::string::npos);
  const Apart same = apart(model, {}), exact = apart(model, {.substeps = 100, .share = 0.5});
  EXPECT_LE(same.rms, 1e-9);
  EXPECT_GE(same.range, 0.1) << "it slid";
  EXPECT_LE(exact.rms, 1e-4);
  EXPECT_GE(exact.range, 5e-3) << "it slid";
}

// An arm with springs says how it is started off q = 0, on the terminal and in the file.
TEST(MjcfFriction, SaysHowToStartElsewhere) {
  const Exported springs = export_model(robot_with("maxwell_slip"), "mjcf_friction");
  ASSERT_EQ(springs.notes.size(), 1U);
  EXPECT_NE(springs.notes[0].find("d.plastic[a : a + 2] = length"), std::string::npos);
  EXPECT_NE(springs.files[0].text.find("        if a >= 0: d.plastic[a : a + 2] = length -->\n"),
            std::string::npos);
  EXPECT_TRUE(export_model(robot_with("lugre_classic"), "mjcf_friction").notes.empty());
}

// Where it slides far, the error is that of the law in equal steps: half a step of motion, by which
// positions are ahead of velocities.
TEST(MjcfFriction, ErrorOfABankIsThatOfTheStep) {
  const Apart exact = apart(robot_with("maxwell_slip"), {.substeps = 100});
  EXPECT_GE(exact.range, 1);
  EXPECT_NEAR(exact.rms, exact.law_rms, 1e-3 * exact.law_rms);
  EXPECT_NEAR(exact.rms, exact.half_step, 0.1 * exact.half_step);
}

TEST(MjcfFriction, GmsWithoutStribeckEffectIsTheLaw) {
  const Apart exact = apart(gms_without_stribeck(), {.substeps = 100});
  EXPECT_LE(exact.rms, 1.1 * exact.half_step);
  EXPECT_GE(exact.range, 0.1) << "it slid";
}

TEST(MjcfFriction, BristlesFollowTheirLaws) {
  for (const char* name : {"dahl", "lugre_classic"}) {
    const Apart exact = apart(robot_with(name), {.step = 1e-4, .substeps = 10});
    EXPECT_LE(exact.rms, 5e-3 * exact.range) << name;
  }
}

// Every law is said, with what is lost, or refused in one sentence; the MJCF loads and moves.
TEST(MjcfFriction, EveryLawIsSaidOrRefused) {
  for (const data::ModelFile& model : all_robots()) {
    SCOPED_TRACE(model.name);
    try {
      const Exported exported = export_model(model, "mjcf_friction");
      for (const std::string& loss : exported.losses)
        EXPECT_NE(exported.files[0].text.find("<!-- " + loss + " -->"), std::string::npos) << loss;
      const Apart exact = apart(model, {.substeps = 10});
      EXPECT_TRUE(std::isfinite(exact.rms));
      EXPECT_FALSE(model.arm.friction.model.has_whole());
    } catch (const UserError& error) {
      EXPECT_TRUE(model.arm.friction.model.has_whole()) << error.what();
      EXPECT_NE(std::string(error.what()).find("allowed: plugin, c, fmu, onnx"), std::string::npos);
    }
  }
}

TEST(MjcfFriction, ErrorIsMeasuredAlongTheGivenMotion) {
  const data::ModelFile model = robot_with("stribeck");
  const deploy::Motion rest{.name = "rest",
                            .dt = 1e-3,
                            .q = RowMatrix::Zero(10, 2),
                            .v = RowMatrix::Zero(10, 2),
                            .load = RowMatrix::Zero(10, 2)};
  EXPECT_TRUE(export_model(model, "mjcf_friction", &rest).losses.empty());
  EXPECT_EQ(export_model(model, "mjcf_friction").losses.size(), 2);
}

TEST(MotionOf, ALogEndsAtItsFirstGapAndHasVelocities) {
  signals::Dataset log;
  log.name = "validation_0";
  log.rate_hz = 100;
  log.q = log.tau = RowMatrix::Zero(6, 2);
  for (int k = 0; k < 6; ++k) log.q.row(k) << 0.1 * k, 0.2 * k;
  log.tau(5, 1) = std::nan("");
  const deploy::Motion motion = motion_of(log, robot_with("gms").arm.robot);
  EXPECT_EQ(motion.name, "validation_0");
  ASSERT_EQ(motion.q.rows(), 5);
  EXPECT_NEAR(motion.v(2, 0), 10, 1e-12);
  EXPECT_NEAR(motion.v(2, 1), 20, 1e-12);
  EXPECT_EQ(motion.temperature.size(), 0);
}

// Friction of coupled motors acts at the motors: tendons of their angles.
TEST(MjcfFriction, CoupledMotorsHaveTheirFriction) {
  data::ModelFile model = robot_with("maxwell_slip");
  model.arm.robot.couplings = {{1, 0, 0.5}};
  const sim::MjModelPtr m = in_mujoco(export_model(model, "mjcf_friction"));
  EXPECT_EQ(m->ntendon, 2 * 4 + 1);
}

}  // namespace
}  // namespace fricid::deploy::test
