// Every scene: does its open loop mean something? The floor is the larger of two errors of the TRUE
// model: the oracle's (measured torque instead of the applied one) and that of halving the physics
// step. The conventional error is that of a model that knows the true rigid body and has Coulomb,
// viscous and constant friction fitted to the TRUE friction torque: no conventional fit to data can
// know more.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "arms.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::sim::test {
namespace {

struct Fitted {
  dynamics::RobotModel robot;  ///< with a constant torque per joint
  friction::Friction friction;
};

// Coulomb, viscous and constant friction by least squares on the true friction torque.
Fitted fit_simple(const dynamics::RobotModel& robot, const std::vector<Truth>& truths) {
  constexpr double kSmoothing = 0.02;  // [rad/s]
  Fitted fitted{robot, {}};
  std::vector<friction::JointSpec> joints;
  for (int j = 0; j < robot.n(); ++j) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const Truth& truth : truths) {
      for (int k = 0; k < truth.trace.length(); ++k) {
        const double v = truth.trace.v(k, j);
        const Eigen::Vector3d row(std::tanh(v / kSmoothing), v, 1);
        H += row * row.transpose();
        g += row * truth.trace.tau_f(k, j);
      }
    }
    const Eigen::Vector3d x = H.ldlt().solve(g);
    joints.push_back({{{"coulomb_viscous", 0, {}}}});
    fitted.friction.theta.insert(fitted.friction.theta.end(),
                                 {x[0], std::max(0.0, x[1]), kSmoothing});
    dynamics::add_linear_torque(fitted.robot,
                                {"offset", j, dynamics::LinearTorque::Shape::kConstant, 1}, x[2]);
  }
  fitted.friction.model = friction::RobotFriction(joints);
  return fitted;
}

double mean_square(const RowMatrix& q, const RowMatrix& truth) {
  const double value = (q - truth).squaredNorm() / static_cast<double>(q.size());
  return std::isfinite(value) ? std::min(value, 100.0) : 100.0;  // a diverged rollout
}

double geometric_mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += std::log(std::max(value, 1e-30));
  return std::exp(sum / static_cast<double>(values.size()));
}

/// Geometric means over trajectories and start times of MSE(q) [rad^2].
struct Errors {
  double oracle, half_step, simple;
  double floor() const { return std::max(oracle, half_step); }
  double headroom() const { return simple / floor(); }
};

Errors errors_at(const scene::Problem& problem, const Simulation& simulation, const Fitted& simple,
                 double horizon_s) {
  const MujocoArm arm = make_arm(problem), half = make_arm(problem, problem.scene.plant.step_s / 2);
  const int full = simulation.validation[0].length();
  const int T = horizon_s > 0
                    ? std::min(full, static_cast<int>(horizon_s * problem.scene.sensors.rate_hz))
                    : full;
  const int starts = T == full ? 1 : 2;
  const int count = static_cast<int>(simulation.validation.size()) * starts;
  std::vector<double> oracle(static_cast<std::size_t>(count)), halved = oracle, quartered = oracle,
                                                               fitted = oracle;
  parallel_for(count, 0, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    const Truth& truth = simulation.validation_truth[index / static_cast<std::size_t>(starts)];
    const data::Dataset& dataset = simulation.validation[index / static_cast<std::size_t>(starts)];
    const int start = starts > 1 ? (full - T) * (i % starts) / (starts - 1) : 0;
    const RowMatrix q = truth.trace.q.middleRows(start, T);
    const RowMatrix temperature = truth.trace.temperature.middleRows(start, T);
    const RowMatrix applied = truth.trace.tau.middleRows(start, T);
    const RowMatrix measured = dataset.tau.middleRows(start, T);
    const auto error = [&](const MujocoArm& at, const dynamics::RobotModel& robot,
                           const friction::Friction& friction, const RowMatrix& tau) {
      Plant plant(at, robot, friction);
      State state = truth.trace.state(start);
      state.z.resize(static_cast<std::size_t>(plant.state_size()));
      return mean_square(rollout(plant, state, tau, temperature, truth.dt()).q, q);
    };
    oracle[index] = error(arm, problem.robot, truth.friction, measured);
    halved[index] = error(half, problem.robot, truth.friction, applied);
    fitted[index] = error(arm, simple.robot, simple.friction, measured);
  });
  return {geometric_mean(oracle), geometric_mean(halved), geometric_mean(fitted)};
}

/// What a scene promises.
struct Promise {
  const char* scene;
  std::vector<double> horizons_s;  ///< 0: full length
  double headroom;                 ///< at least, at every horizon
  double half_step;                ///< MSE(q) after halving the step, at most [rad^2]
};

std::ostream& operator<<(std::ostream& out, const Promise& promise) { return out << promise.scene; }

class Scenes : public testing::TestWithParam<Promise> {};

TEST_P(Scenes, HaveHeadroomAndAFineEnoughStep) {
  const Promise& promise = GetParam();
  scene::Scene promised = scene(promise.scene);
  promised.seed = 1;
  promised.excitation.train = 1;
  promised.excitation.repeats = 1;
  promised.excitation.validation = 2;
  const scene::Problem problem = resolve(std::move(promised));
  const Simulation simulation = simulate(problem, 0);
  const Fitted simple = fit_simple(problem.robot, simulation.train_truth);
  for (const double horizon : promise.horizons_s) {
    const Errors errors = errors_at(problem, simulation, simple, horizon);
    fmt::print("{:14} {:>5}: oracle {:.1e}  half step {:.1e}  simple {:.1e}  headroom {:.0f}\n",
               promise.scene, horizon > 0 ? fmt::format("{} s", horizon) : "full", errors.oracle,
               errors.half_step, errors.simple, errors.headroom());
    EXPECT_GE(errors.headroom(), promise.headroom) << horizon << " s";
    EXPECT_LE(errors.half_step, promise.half_step) << horizon << " s";
  }
}

// First order in the step: halving it again halves the change of q, and its square falls to a
// quarter.
TEST_P(Scenes, ConvergeWithTheStep) {
  const scene::Problem problem = [] {
    scene::Scene e = scene(GetParam().scene);
    e.excitation.train = e.excitation.repeats = e.excitation.validation = 1;
    e.excitation.criterion = Criterion::kNone;
    return resolve(std::move(e));
  }();
  const Truth truth = simulate(problem, 0).validation_truth[0];
  constexpr int kStart = 1000, kLength = 500;
  std::vector<RowMatrix> q;
  for (const double share : {1.0, 0.5, 0.25}) {
    const MujocoArm arm = make_arm(problem, share * problem.scene.plant.step_s);
    Plant plant(arm, problem.robot, truth.friction);
    q.push_back(rollout(plant, truth.trace.state(kStart),
                        truth.trace.tau.middleRows(kStart, kLength),
                        truth.trace.temperature.middleRows(kStart, kLength), truth.dt())
                    .q);
  }
  const double first = mean_square(q[1], q[0]), second = mean_square(q[2], q[1]);
  fmt::print("{:14} 2 s: half step {:.1e}  quarter step {:.1e}\n", GetParam().scene, first, second);
  EXPECT_LT(second, 0.4 * first);
}

INSTANTIATE_TEST_SUITE_P(Headroom, Scenes,
                         testing::Values(Promise{"kr6_gms", {10, 0}, 30, 1e-6},
                                         Promise{"kr6_load", {10, 0}, 30, 1e-6},
                                         Promise{"kr6_thermal", {10, 0}, 30, 1e-6},
                                         Promise{"kr6_full", {10, 0}, 30, 1e-6},
                                         Promise{"kr6_lugre", {10, 0}, 30, 1e-6},
                                         Promise{"kr6_demo", {10, 0}, 30, 1e-6},
                                         Promise{"kr6_stickslip", {0.1, 0.3}, 10, 1e-6},
                                         Promise{"kr6_floor", {0.1, 1}, 10, 1e-6}),
                         [](const auto& test) { return std::string(test.param.scene); });

}  // namespace
}  // namespace fricid::sim::test
