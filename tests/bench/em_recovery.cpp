// Does EM find the friction that was injected? For every scene and seed: data are simulated anew,
// the rigid body is the conventional one, the law is the truth's own with every parameter 30 % off,
// up or down, and EM runs with the scene defaults. Printed: root mean square of the error of the
// friction torque along the true validation motion, per joint, in percent of its Coulomb torque.
//
//     fricid_em_recovery scenes/kr6_lugre.toml scenes/kr6_gms.toml [FIRST_SEED LAST_SEED]
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid {
namespace {

constexpr double kOff = 0.3;      // relative error of every friction parameter at the start
constexpr double kBound = 5;      // [% of Coulomb]
constexpr double kLeftOut = 1.0;  // beginning of a recording, until friction has forgotten z_0 [s]

double coulomb(const friction::Friction& friction, int joint) {
  for (std::size_t p = 0; p < friction.theta.size(); ++p) {
    const friction::ParameterRef& ref = friction.model.parameters()[p];
    if (ref.joint == joint && ref.symbol == "Fc") return friction.theta[p];
  }
  throw UserError("the scene's friction has no Fc in joint {}", joint + 1);
}

/// Per joint, a constant torque of the rigid body counting as friction [%].
std::vector<double> friction_error(const Arm& arm, const std::vector<sim::Truth>& truths) {
  std::vector<double> percent;
  for (int j = 0; j < arm.robot.n(); ++j) {
    double offset = 0, square = 0, rows = 0;
    for (std::size_t k = 0; k < arm.robot.linear_torques.size(); ++k)
      if (arm.robot.linear_torques[k].joint == j)
        offset += arm.robot.pi[arm.robot.linear_begin() + static_cast<Eigen::Index>(k)];
    for (const sim::Truth& truth : truths) {
      const sim::Trace& true_motion = truth.trace;
      const auto found = drive_friction(arm.friction, truth.dt(), true_motion.q, true_motion.v,
                                        true_motion.tau, true_motion.temperature)
                             .tau_f;
      const auto begin = static_cast<Eigen::Index>(kLeftOut * truth.rate_hz);
      for (Eigen::Index k = begin; k < found.rows(); ++k, rows += 1)
        square += std::pow(found(k, j) + offset - true_motion.tau_f(k, j), 2);
    }
    percent.push_back(100 * std::sqrt(square / rows) / coulomb(truths[0].friction, j));
  }
  return percent;
}

void print(const std::string& name, int seed, const char* when, const std::vector<double>& percent,
           const std::string& remark) {
  fmt::print("| {} | {} | {} |", name, seed, when);
  for (const double x : percent) fmt::print(" {:.2f} |", x);
  fmt::print(" {} |\n", remark);
  std::fflush(stdout);
}

/// @return the largest error of a joint after EM [%]
double recover(scene::Scene scene, int seed) {
  scene.seed = seed;
  const scene::Problem problem = scene::resolve(std::move(scene));
  const sim::Simulation simulation = sim::simulate(problem, 0);
  const estimate::Prepared prepared =
      estimate::prepare(problem.robot, problem.scene.identify, simulation.train, 0);
  estimate::ModelOptions config;
  config.name = config.label = "rigid body";
  config.law = "coulomb_viscous";
  Arm arm = estimate::fit_conventional(prepared, config, seed, 0).model.arm;
  arm.friction = *problem.scene.friction;
  Rng rng(static_cast<std::uint64_t>(seed), 0);
  for (std::size_t p = 0; p < arm.friction.theta.size(); ++p) {
    const friction::ParameterInfo& info = arm.friction.model.parameters()[p].info;
    const double off = rng.uniform() < 0.5 ? 1 - kOff : 1 + kOff;
    arm.friction.theta[p] = std::clamp(off * arm.friction.theta[p], info.lower, info.upper);
  }
  print(problem.scene.name, seed, "start", friction_error(arm, simulation.validation_truth), "");

  estimate::EmOptions options;
  options.torque_scale = estimate::torque_rms(prepared.recordings);
  options.seed = problem.scene.seed;
  const estimate::EmReport report =
      estimate::fit_em(arm, prepared.recordings, options, problem.scene.name, 0);
  const auto error = friction_error(report.arm, simulation.validation_truth);
  print(problem.scene.name, seed, "EM", error,
        fmt::format("{:.0f} s, {}", report.seconds, report.message));
  return *std::max_element(error.begin(), error.end());
}

int run(std::vector<std::string> scenes) {
  int first = 1, last = 5;
  double worst = 0;
  const auto is_number = [](const std::string& text) {
    return std::isdigit(static_cast<unsigned char>(text[0])) != 0;
  };
  if (scenes.size() > 2 && is_number(scenes.back())) {
    last = std::stoi(scenes.back());
    scenes.pop_back();
    first = std::stoi(scenes.back());
    scenes.pop_back();
  }
  fmt::print("| scene | seed | | J1 % | J2 % | J3 % | J4 % | J5 % | J6 % | |\n");
  fmt::print("|---|--:|---|--:|--:|--:|--:|--:|--:|---|\n");
  for (const std::string& scene : scenes)
    for (int seed = first; seed <= last; ++seed)
      worst = std::max(worst, recover(scene::load_scene(scene), seed));
  fmt::print("\nlargest error of a joint {:.2f} %, allowed {} %\n", worst, kBound);
  return worst <= kBound ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace fricid

int main(int argc, char** argv) {
  try {
    return fricid::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return EXIT_FAILURE;
  }
}
