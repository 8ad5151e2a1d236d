#include "fricid/system/driven_friction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fricid/base/error.hpp"
#include "kr6_truth.hpp"

namespace fricid::test {
namespace {

/// One Maxwell element of stiffness K that slips at W.
friction::Friction element(double K, double W) {
  return make_friction(1, {{{"maxwell_slip", 1, {}}}},
                       [&](int, std::string_view, std::string_view symbol) {
                         return symbol.starts_with("K") ? K : W;
                       });
}

/// No temperature was measured.
RowMatrix room() { return {}; }

RowMatrix column(std::initializer_list<double> values) {
  RowMatrix matrix(static_cast<Eigen::Index>(values.size()), 1);
  Eigen::Index k = 0;
  for (const double value : values) matrix(k++, 0) = value;
  return matrix;
}

// By hand: K = 100, W = 1, so the deflection follows the motion inside +-0.01.
TEST(DriveFriction, PlaysBackAMaxwellElement) {
  const RowMatrix q = column({0, 0.004, 0.02, 0.025, 0.021, 0.001, 0.0});
  const RowMatrix still = RowMatrix::Zero(7, 1);
  const DrivenFriction out = drive_friction(element(100, 1), 0.004, q, still, still, room());
  const RowMatrix z = column({0, 0.004, 0.01, 0.01, 0.006, -0.01, -0.01});
  for (Eigen::Index k = 0; k < 7; ++k) {
    EXPECT_NEAR(out.z(k, 0), z(k, 0), 1e-15) << "sample " << k;
    EXPECT_NEAR(out.tau_f(k, 0), 100 * z(k, 0), 1e-13) << "sample " << k;
  }
}

TEST(DriveFriction, StartsFromTheGivenState) {
  const RowMatrix still = RowMatrix::Zero(3, 1);
  const std::vector<double> z0{0.007};
  const DrivenFriction out =
      drive_friction(element(100, 1), 0.004, still, still, still, room(), z0);
  EXPECT_EQ(out.z(0, 0), 0.007);
  EXPECT_DOUBLE_EQ(out.tau_f(2, 0), 0.7);
}

// At one step per sample the arm's own v is (q_{k+1} - q_k) / dt: driven friction is the arm's.
TEST(DriveFriction, RepeatsTheFrictionOfAnArmOnItsOwnMotion) {
  for (const char* law : {"lugre", "gms", "maxwell_slip"}) {
    const Arm arm{hanging_kr6(), kr6_friction(law)};
    const Recording truth = record(arm, HangingMotion(3), 600, {1});
    const DrivenFriction out =
        drive_friction(arm.friction, kSamplePeriod, truth.q, truth.v, truth.tau, room());
    EXPECT_LT((out.tau_f - truth.tau_f).cwiseAbs().maxCoeff(), 1e-8) << law;
    EXPECT_LT((out.z - truth.z).cwiseAbs().maxCoeff(), 1e-8) << law;
    EXPECT_GT(truth.tau_f.cwiseAbs().maxCoeff(), 5) << law;
  }
}

// A wrong initial state is forgotten within a few bristle lengths of travel.
TEST(DriveFriction, WashesOutTheInitialState) {
  for (const char* law : {"lugre", "gms", "maxwell_slip"}) {
    const friction::Friction friction = kr6_friction(law);
    RowMatrix q(500, 6), v(500, 6);
    for (Eigen::Index k = 0; k < 500; ++k) {
      const double t = kSamplePeriod * static_cast<double>(k);
      q.row(k).setConstant(0.1 * std::sin(2 * t));
      v.row(k).setConstant(0.2 * std::cos(2 * t));
    }
    const RowMatrix load = RowMatrix::Zero(500, 6);
    const auto nz = static_cast<std::size_t>(friction.model.state_size());
    const std::vector<double> z0(nz, -3e-4);
    const DrivenFriction a = drive_friction(friction, kSamplePeriod, q, v, load, room());
    const DrivenFriction b = drive_friction(friction, kSamplePeriod, q, v, load, room(), z0);
    EXPECT_GT((a.z.row(0) - b.z.row(0)).cwiseAbs().maxCoeff(), 1e-4) << law;
    EXPECT_LT((a.z.row(499) - b.z.row(499)).cwiseAbs().maxCoeff(), 1e-9) << law;
  }
}

// Friction that grows with the load follows the rigid body's torque plus itself; the filter acts on
// both; a law that does not read the load is driven as ever.
TEST(DriveFriction, FindsItsOwnLoad) {
  const friction::Friction loaded = make_friction(
      1, {{{"load_dependent", 0, {}}}}, [&](int, std::string_view, std::string_view symbol) {
        return symbol == "v0" ? 0.01 : symbol.starts_with("mu") ? 0.1 : 0.0;
      });
  const RowMatrix q = RowMatrix::Zero(3, 1), v = RowMatrix::Constant(3, 1, 5),
                  rigid = RowMatrix::Constant(3, 1, 20);
  const auto under = [&](ConstRowMatrix load) {
    return drive_friction(loaded, 0.004, q, v, load, room()).tau_f;
  };
  ASSERT_GT(under(rigid).minCoeff(), 0);
  const RowMatrix own = drive_under_own_load(loaded, 0.004, q, v, rigid, room()).tau_f;
  EXPECT_LT((own - under(rigid + own)).norm(), 1e-4 * own.norm());
  EXPECT_GT((own - under(rigid + under(rigid))).norm(), 1e-3 * own.norm());
  const auto halve = [](RowMatrix& tau_f) { tau_f *= 0.5; };
  const RowMatrix halved =
      drive_under_own_load(loaded, 0.004, q, v, rigid, room(), {}, halve).tau_f;
  EXPECT_LT((halved - 0.5 * under(rigid + halved)).norm(), 1e-4 * halved.norm());
  const friction::Friction plain = element(100, 1);
  EXPECT_EQ(drive_under_own_load(plain, 0.004, q, v, rigid, room()).tau_f,
            drive_friction(plain, 0.004, q, v, rigid, room()).tau_f);
}

// A joint without gravity, whose load is its friction: tau = Fc (1 + mu tau).
TEST(DriveFriction, IsItsOwnLoadToTheEnd) {
  const double Fc = 3, mu = 0.1;
  const friction::Friction loaded =
      make_friction(1, {{{"coulomb_viscous", 0, {{"load", 1}}}}},
                    [&](int, std::string_view, std::string_view symbol) {
                      return symbol == "Fc" ? Fc : symbol == "mu" ? mu : symbol == "v0" ? 0.01 : 0;
                    });
  const RowMatrix zero = RowMatrix::Zero(3, 1), v = RowMatrix::Constant(3, 1, 5);
  const RowMatrix own = drive_under_own_load(loaded, 0.004, zero, v, zero, room()).tau_f;
  EXPECT_NEAR(own(2, 0), Fc / (1 - mu * Fc), 1e-3);
}

TEST(DriveFriction, RefusesWhatDoesNotFit) {
  const RowMatrix one = RowMatrix::Zero(4, 1), two = RowMatrix::Zero(4, 2);
  const std::vector<double> z0{0, 0};
  EXPECT_THROW(drive_friction(element(1, 1), 0.004, two, two, two, room()), UserError);
  EXPECT_THROW(drive_friction(element(1, 1), 0.004, one, one.topRows(3), one, room()), UserError);
  EXPECT_THROW(drive_friction(element(1, 1), 0.004, one, one, one, two), UserError);
  EXPECT_THROW(drive_friction(element(1, 1), 0.004, one, one, one, room(), z0), UserError);
}

}  // namespace
}  // namespace fricid::test
