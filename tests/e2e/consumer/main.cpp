// A user's program: loads a scene and lets its arm fall for a second under its own friction.
#include <cstdio>

#include "fricid/scene/problem.hpp"
#include "fricid/system/arm.hpp"

int main(int, char** argv) {
  const auto problem = fricid::scene::load_problem(argv[1]);
  const fricid::Arm arm{problem.robot, *problem.scene.friction};
  fricid::ArmStepper<double> stepper(arm, {.substeps = 8});
  const auto n = static_cast<std::size_t>(arm.robot.n());
  std::vector<double> q(n, 0.1), v(n, 0.0),
      z(static_cast<std::size_t>(arm.friction.model.state_size()), 0.0);
  const std::vector<double> tau(n, 0.0), temperature(n, 293.15);
  for (int k = 0; k < 250; ++k) stepper.step(tau, temperature, 0.004, q, v, z);
  for (const double angle : q) std::printf("%.6f ", angle);
  std::puts("rad");
}
