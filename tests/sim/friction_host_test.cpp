#include "fricid/sim/friction_host.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "arms.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::sim::test {
namespace {

// Claim: the simulator's friction is friction::RobotFriction to the last bit, over every law and
// modifier of the scenes.
TEST(FrictionHost, EqualsRobotFrictionToTheLastBit) {
  for (const char* name : {"kr6_lugre", "kr6_gms", "kr6_load", "kr6_thermal", "kr6_full"}) {
    SCOPED_TRACE(name);
    const scene::Problem problem = resolve(scene(name));
    const friction::Friction& friction = *problem.scene.friction;
    const MujocoArm arm = make_arm(problem);
    const auto n = static_cast<std::size_t>(arm.n());
    const MjDataPtr data = arm.make_data();
    FrictionHost host(friction, arm, problem.robot);

    std::vector<double> z(host.z().size(), 0.0), tau(n), temperature(n), tau_f(n);
    std::vector<friction::Input<double>> in(n);
    Rng rng(1, 0);
    for (int k = 0; k < 500; ++k) {
      const double h = 1e-3 * rng.uniform();
      for (std::size_t j = 0; j < n; ++j) {
        const int joint = static_cast<int>(j);
        in[j] = {rng.normal(), rng.normal(), 20 * rng.normal(), 293.15 + 20 * rng.uniform()};
        data->qpos[arm.qpos(joint)] = in[j].q;
        data->qvel[arm.dof(joint)] = in[j].v;
        tau[j] = in[j].load;
        temperature[j] = in[j].temperature;
      }
      friction.model.torque<double>(friction.theta, in, z, tau_f);
      const std::span<const double> hosted = host.torque(*data, tau, temperature);
      ASSERT_EQ(std::memcmp(hosted.data(), tau_f.data(), n * sizeof(double)), 0);

      for (std::size_t j = 0; j < n; ++j) {
        const int joint = static_cast<int>(j);
        in[j].q = data->qpos[arm.qpos(joint)] += h * in[j].v;
        in[j].v = data->qvel[arm.dof(joint)] += h * rng.normal();
      }
      friction.model.step<double>(friction.theta, in, h, z);
      host.step(*data, tau, temperature, h);
      ASSERT_EQ(std::memcmp(host.z().data(), z.data(), z.size() * sizeof(double)), 0);
    }
  }
}

// Torques that a step foresaw, that were known, and that were neither are the same.
TEST(FrictionHost, ForeseesTheTorqueToTheLastBit) {
  for (const char* name : {"kr6_lugre", "kr6_full"}) {
    SCOPED_TRACE(name);
    const scene::Problem problem = resolve(scene(name));
    const MujocoArm arm = make_arm(problem);
    const MjDataPtr data = arm.make_data();
    FrictionHost foresees(*problem.scene.friction, arm, problem.robot);
    const auto n = static_cast<std::size_t>(arm.n());
    std::vector<double> tau(n), temperature(n, 300.0);
    Rng rng(2, 0);
    for (int k = 0; k < 200; ++k) {
      const bool changes = rng.uniform() < 0.3, twice = rng.uniform() < 0.3;
      if (changes)
        for (double& x : tau) x = 10 * rng.normal();
      if (rng.uniform() < 0.1) foresees.z()[1] += 1e-3;  // as a reset does
      FrictionHost fresh(*problem.scene.friction, arm, problem.robot);
      std::ranges::copy(foresees.z(), fresh.z().begin());
      const std::span<const double> expected = fresh.torque(*data, tau, temperature);
      for (int i = 0; i < (twice ? 2 : 1); ++i) {
        const std::span<const double> found = foresees.torque(*data, tau, temperature);
        ASSERT_EQ(std::memcmp(found.data(), expected.data(), n * sizeof(double)), 0) << k;
      }
      for (int j = 0; j < arm.n(); ++j) {
        data->qvel[arm.dof(j)] += 0.1 * rng.normal();
        data->qpos[arm.qpos(j)] += 1e-3 * data->qvel[arm.dof(j)];
      }
      fresh.step(*data, tau, temperature, 1e-3);
      foresees.step(*data, tau, temperature, 1e-3);
      ASSERT_EQ(
          std::memcmp(foresees.z().data(), fresh.z().data(), fresh.z().size() * sizeof(double)), 0);
    }
  }
}

TEST(FrictionHost, RefusesAnotherNumberOfJoints) {
  const scene::Problem problem = resolve(scene("kr6_gms"));
  EXPECT_THROW(FrictionHost(no_friction(5), make_arm(problem), problem.robot), UserError);
}

}  // namespace
}  // namespace fricid::sim::test
