#include "fricid/sim/friction_host.hpp"

#include <gtest/gtest.h>

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

TEST(FrictionHost, RefusesAnotherNumberOfJoints) {
  const scene::Problem problem = resolve(scene("kr6_gms"));
  EXPECT_THROW(FrictionHost(no_friction(5), make_arm(problem), problem.robot), UserError);
}

}  // namespace
}  // namespace fricid::sim::test
