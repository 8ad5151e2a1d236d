// lugre_classic against the LuGre friction inside MuJoCo's dcmotor actuator, an independent
// implementation of the same equations. What differs is stated in docs/friction_laws.md.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "fricid/friction/laws.hpp"

namespace fricid::sim::test {
namespace {

using friction::Input;
using friction::LuGre;
using friction::LuGreClassic;

constexpr double kInertia = 0.5;                                  // [kg m2]
const std::vector<double> kTheta = {5, 6.5, 0.05, 15000, 30, 0};  // Fc Fs vs sigma0 sigma1 sigma2
constexpr const char* kLuGreOfMujoco = "15000 30 5 6.5 0.05";     // sigma0 sigma1 Fc Fs vs

// One hinge whose dcmotor has nothing but friction.
struct Hinge {
  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> m{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, decltype(&mj_deleteData)> d{nullptr, mj_deleteData};

  Hinge(double dt, const std::string& integrator) {
    const std::string xml =
        "<mujoco><option timestep='" + std::to_string(dt) + "' gravity='0 0 0' integrator='" +
        integrator +
        "'/><worldbody><body><joint name='j' type='hinge'/><inertial pos='0 0 0' "
        "mass='1' diaginertia='.5 .5 .5'/></body></worldbody><actuator><dcmotor "
        "joint='j' input='none' motorconst='0 0' resistance='1' lugre='" +
        std::string(kLuGreOfMujoco) + "'/></actuator></mujoco>";
    char error[500] = "";
    mjSpec* spec = mj_parseXMLString(xml.c_str(), nullptr, error, sizeof error);
    if (spec == nullptr) throw std::runtime_error(error);
    m.reset(mj_compile(spec, nullptr));
    mj_deleteSpec(spec);
    if (m == nullptr) throw std::runtime_error("the hinge does not compile");
    d.reset(mj_makeData(m.get()));
  }
};

// Torque applied to the free hinge: it breaks away, slides, reverses and sticks.
double applied(double t) { return 9 * std::sin(11 * t) * std::exp(-0.4 * t); }

// Largest difference of position over two seconds between MuJoCo (semi-implicit Euler) and the law
// in a host of the same kind that moves z with the velocity before (as MuJoCo) or after the step.
double free_motion_difference(const char* integrator, double dt, bool moves_z_with_new_velocity) {
  Hinge hinge(dt, integrator);
  double q = 0, v = 0, z = 0, largest = 0;
  for (int k = 0; k * dt < 2; ++k) {
    hinge.d->qfrc_applied[0] = applied(k * dt);
    mj_step(hinge.m.get(), hinge.d.get());

    const Input<double> in{q, v, 0, 293.15};
    v += dt / kInertia * (applied(k * dt) - LuGreClassic{}.torque(kTheta.data(), in, &z));
    LuGreClassic{}.step(kTheta.data(),
                        moves_z_with_new_velocity ? Input<double>{q, v, 0, 293.15} : in, dt, &z);
    q += dt * v;
    largest = std::max(largest, std::abs(q - hinge.d->qpos[0]));
  }
  EXPECT_GT(std::abs(q), 1e-3) << "the hinge moves";
  return largest;
}

TEST(LuGreVsMujoco, TorqueAndBristleAgreeUnderAnyVelocity) {
  for (const char* integrator : {"Euler", "implicitfast"})
    for (const double dt : {5e-4, 4e-3}) {
      Hinge hinge(dt, integrator);
      double z = 0;
      for (int k = 0; k < 3000; ++k) {
        const double v =
            0.4 * std::sin(0.9 * k * dt) * std::sin(31 * k * dt) + (k % 700 == 0 ? 5 : 0);
        const Input<double> in{0, v, 0, 293.15};
        hinge.d->qvel[0] = v;
        mj_step(hinge.m.get(), hinge.d.get());
        ASSERT_NEAR(-hinge.d->actuator_force[0], LuGreClassic{}.torque(kTheta.data(), in, &z),
                    1e-9);
        LuGreClassic{}.step(kTheta.data(), in, dt, &z);
        ASSERT_NEAR(hinge.d->act[0], z, 1e-9 * kTheta[1] / kTheta[3]);
      }
    }
}

TEST(LuGreVsMujoco, FreeMotionAgreesWhenZMovesWithTheOldVelocity) {
  EXPECT_LT(free_motion_difference("Euler", 5e-4, false), 1e-9);
}

TEST(LuGreVsMujoco, MovingZWithTheNewVelocityDiffersByFirstOrder) {
  const double coarse = free_motion_difference("Euler", 4e-4, true);
  const double fine = free_motion_difference("Euler", 1e-4, true);
  EXPECT_GT(coarse, 1e-7);
  EXPECT_NEAR(coarse / fine, 4, 1);
}

TEST(LuGreVsMujoco, ImplicitIntegratorsOfMujocoDifferByFirstOrder) {
  // they take the slope of sigma1 at the end of the step
  const double coarse = free_motion_difference("implicitfast", 4e-4, false);
  const double fine = free_motion_difference("implicitfast", 1e-4, false);
  EXPECT_GT(coarse, 1e-7);
  EXPECT_NEAR(coarse / fine, 4, 1);
}

TEST(LuGreVsMujoco, FadingDampingChangesReversalsOnly) {
  // same levels in sliding, another torque while the bristle turns over
  double z_classic = 0, z_fading = 0, at_reversal = 0, in_sliding = 0;
  const double dt = 1e-4;
  for (int k = 0; k < 20000; ++k) {
    const double v = 0.5 * std::sin(3 * k * dt);
    const Input<double> in{0, v, 0, 293.15};
    const double difference = std::abs(LuGreClassic{}.torque(kTheta.data(), in, &z_classic) -
                                       LuGre{}.torque(kTheta.data(), in, &z_fading));
    double& largest = std::abs(v) > 0.2 ? in_sliding : at_reversal;
    if (k * dt > 0.2) largest = std::max(largest, difference);
    LuGreClassic{}.step(kTheta.data(), in, dt, &z_classic);
    LuGre{}.step(kTheta.data(), in, dt, &z_fading);
  }
  EXPECT_LT(in_sliding, 0.01);
  EXPECT_GT(at_reversal, 0.2);
}

}  // namespace
}  // namespace fricid::sim::test
