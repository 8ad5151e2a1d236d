// Friction in MJCF's own words, in MuJoCo, against the laws.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "fricid/base/error.hpp"
#include "in_mujoco.hpp"
#include "law_errors.hpp"

namespace fricid::deploy::test {
namespace {

// Torque that reverses from presliding to sliding [N m].
double torque(double t, int joint) {
  return (2 + 2 * t) * std::sin(2 * M_PI * (0.7 + 0.2 * joint) * t) + 0.8 * std::sin(17 * t);
}

/// RMS difference [rad] of the positions over 4 s, in steps of `step`, from those with the exact
/// law, in steps of step / substeps, and their range. Torque is `share` of the usual.
struct Apart {
  double rms = 0, range = 0;
};
Apart apart(const data::ModelFile& model, int substeps, double step = 1e-3, double share = 1) {
  const sim::MjModelPtr m = in_mujoco(export_model(model, "mjcf_friction"));
  m->opt.timestep = step;
  const sim::MjDataPtr d(mj_makeData(m.get()));
  const friction::Friction& friction = model.arm.friction;
  std::vector<double> z(static_cast<std::size_t>(friction.model.state_size())), tau_f(2);
  std::vector<friction::Input<double>> in(2, {0, 0, 0, kRoomTemperature});
  const double h = step / substeps;
  double sum = 0, most = 0, least = 0;
  const int length = static_cast<int>(4 / step);
  for (int k = 0; k < length; ++k) {
    for (int j = 0; j < 2; ++j)
      in[static_cast<std::size_t>(j)].load = d->qfrc_applied[j] = share * torque(k * step, j);
    mj_step(m.get(), d.get());
    for (int s = 0; s < substeps; ++s) {
      friction.model.torque<double>(friction.theta, in, z, tau_f);
      // two flywheels on one axis: M = I [[2, 1], [1, 1]]
      const double I = 0.1, a = in[0].load - tau_f[0], b = in[1].load - tau_f[1];
      const std::array<double, 2> acceleration{(a - b) / I, (2 * b - a) / I};
      for (std::size_t j = 0; j < 2; ++j) {
        in[j].v += h * acceleration[j];
        in[j].q += h * in[j].v;
      }
      friction.model.step<double>(friction.theta, in, h, z);
    }
    for (int j = 0; j < 2; ++j) {
      const double q = in[static_cast<std::size_t>(j)].q;
      sum += std::pow(d->qpos[j] - q, 2) / (2 * length);
      most = std::max(most, q), least = std::min(least, q);
    }
  }
  return {std::sqrt(sum), most - least};
}

// The bank is the law: springs that yield, stepped with the new position.
TEST(MjcfFriction, MaxwellSlipIsTheLaw) {
  const data::ModelFile model = robot_with("maxwell_slip");
  EXPECT_TRUE(export_model(model, "mjcf_friction").losses.empty());
  const Apart same = apart(model, 1), exact = apart(model, 100, 1e-3, 0.5);
  EXPECT_LE(same.rms, 1e-9);
  EXPECT_GE(same.range, 0.1) << "it slid";
  EXPECT_LE(exact.rms, 1e-4);
  EXPECT_GE(exact.range, 5e-3) << "it slid";
}

// Elements whose level does not depend on speed. With Fs above Fc MJCF has an approximation.
TEST(MjcfFriction, GmsWithoutStribeckEffectIsTheLaw) {
  data::ModelFile model = robot_with("gms");
  friction::Friction& friction = model.arm.friction;
  for (int j = 0; j < 2; ++j)
    friction.theta[static_cast<std::size_t>(find_parameter(friction.model, j, "gms", "Fs"))] =
        friction.theta[static_cast<std::size_t>(find_parameter(friction.model, j, "gms", "Fc"))];
  const Apart exact = apart(model, 100);
  EXPECT_LE(exact.rms, 1e-4);
  EXPECT_GE(exact.range, 0.1) << "it slid";
}

TEST(MjcfFriction, BristlesFollowTheirLaws) {
  for (const char* name : {"dahl", "lugre_classic"}) {
    const Apart exact = apart(robot_with(name), 10, 1e-4);
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
      const Apart exact = apart(model, 10);
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
