// Training on the torque that the rigid body leaves: the filter within a window, the gradient
// against central differences, and what is learned from logs of a small arm.
#include "fricid/estimate/friction/torque_training.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "arm_data.hpp"
#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/wash_out.hpp"

namespace fricid::estimate {
namespace {

constexpr double kCutoff = 10;

/// Logs of a small arm with Dahl friction, and what its rigid body leaves of their torque.
struct Logs {
  Arm truth{small_arm(), same_law("dahl", {6, 3000, 2}, 3)};
  std::vector<signals::Recording> recordings;

  explicit Logs(double seconds) {
    for (const std::uint64_t seed : {1, 2}) {
      LogOptions options;
      options.seconds = seconds;
      options.seed = seed;
      recordings.push_back(signals::make_recording(make_log(truth, options), kCutoff));
    }
  }
  TorqueData data(bool filtered) const { return torque_data(truth, recordings, filtered); }
  /// The true rigid body with another friction, its weights random.
  Arm with(const friction::RobotFriction& model) const {
    Arm arm = truth;
    arm.friction = {model, friction::default_theta(model)};
    friction::initialise_weights(model, 1, arm.friction.theta);
    return arm;
  }
  Arm with(const std::string& law, int elements) const {
    const std::vector<friction::JointSpec> none(3), each(3, {{{law, elements, {}}}});
    return with(friction::is_robot_law(law) ? friction::RobotFriction(none, {law, elements})
                                            : friction::RobotFriction(each));
  }
};

class TorqueGradient : public ::testing::TestWithParam<std::pair<const char*, int>> {};
INSTANTIATE_TEST_SUITE_P(Laws, TorqueGradient,
                         ::testing::Values(std::pair{"dahl", 0}, std::pair{"lvm_bristles", 4},
                                           std::pair{"nn", 4}, std::pair{"rnn", 4},
                                           std::pair{"lvm_paper", 4}));

TEST_P(TorqueGradient, EqualsCentralDifferencesAlongRandomDirections) {
  const Logs logs(3);
  Arm arm = logs.with(GetParam().first, GetParam().second);
  // without biases a unit above dead ones sits on its kink
  Rng bias(4, 0);
  for (std::size_t p = 0; p < arm.friction.theta.size(); ++p)
    if (arm.friction.model.parameters()[p].symbol[0] == 'w')
      arm.friction.theta[p] += 0.05 * bias.normal();
  const auto z = wash_out(arm, logs.recordings, 1);
  for (const bool filtered : {false, true}) {
    const TorqueData data = logs.data(filtered);
    const std::vector<double> response =
        filtered ? signals::impulse_response(signals::ZeroPhaseButterworth(kCutoff, 250))
                 : std::vector<double>{1};
    TorqueWindows<PackD> rollout(arm.friction.model, data, 25, {2, 3, 4}, response);
    const std::vector<Window> windows{{0, 300}, {1, 250}, {1, 480}};
    const auto loss = [&](const std::vector<double>& theta) {
      rollout.set_parameters(theta);
      return rollout.loss(windows, z);
    };
    std::vector<double> gradient(arm.friction.theta.size());
    EXPECT_GT(loss(arm.friction.theta), 1e-3);
    rollout.add_gradient(gradient);
    Rng rng(2, 0);
    for (int trial = 0; trial < 10; ++trial) {
      std::vector<double> up = arm.friction.theta, down = up;
      double expected = 0, size = 0;
      for (std::size_t p = 0; p < up.size(); ++p) {
        const friction::Role role = arm.friction.model.parameters()[p].info.role;
        if (role == friction::Role::kCrossWeights) continue;  // a switch
        const double step = 1e-6 * std::max(0.1, std::abs(up[p])) * rng.normal();
        up[p] += step;
        down[p] -= step;
        expected += 2 * step * gradient[p];
        size += std::abs(2 * step * gradient[p]);
      }
      EXPECT_NEAR(loss(up) - loss(down), expected, 1e-5 * size + 1e-13) << filtered;
    }
  }
}

TEST(TorqueTraining, FindsTheFrictionThatMadeTheLogs) {
  const Logs logs(12);
  Arm start = logs.truth;
  for (std::size_t p = 0; p < start.friction.theta.size(); ++p)
    start.friction.theta[p] *= p % 2 == 0 ? 1.3 : 0.7;
  TorqueOptions options;
  options.iterations = 400;
  options.rate = 1e-2;
  options.batch = 16;
  const TorqueReport report = train_torque(start, logs.data(true), options, "dahl", 2);
  EXPECT_EQ(report.outcome, Outcome::kIterationLimit);
  EXPECT_GT(report.history.held_out.front(), 0.05);
  EXPECT_LT(report.history.best_held_out(), 2e-3);
  for (std::size_t p = 0; p < start.friction.theta.size(); ++p)
    EXPECT_NEAR(report.arm.friction.theta[p] / logs.truth.friction.theta[p], 1,
                p % 3 == 1 ? 0.15 : 0.03)
        << start.friction.model.parameters()[p].symbol;
}

// A network without memory cannot tell the two branches of a hysteresis apart, and a recurrent one
// hardly learns to in so few steps.
TEST(TorqueTraining, NetworksLearnTheTorqueAndBristlesLeaveLessOfIt) {
  const Logs logs(12);
  const auto left = [&](const std::string& law, const TorqueOptions& options) {
    Arm start = logs.with(law, 16);
    friction::set_signal_sizes(start.friction.model, {{0, 0, 0}, {1, 1, 1}, {1, 1, 1}, {6, 5, 3}},
                               start.friction.theta);
    const TorqueReport report = train_torque(start, logs.data(options.filtered), options, law, 2);
    return report.history.best_held_out();
  };
  TorqueOptions options;
  options.filtered = false;
  options.window_s = 0;
  options.batch = 64;
  options.iterations = 3000;
  options.rate = 3e-3;
  const double nn = left("nn", options);
  EXPECT_LT(nn, 0.3);
  options.window_s = 0.1;
  options.batch = 32;
  options.iterations = 400;
  const double rnn = left("rnn", options);
  options.filtered = true;
  options.iterations = 300;
  options.rate = 1e-2;
  const double lvm = left("lvm_bristles", options);
  std::printf("left of the held-out torque: nn %.3g, rnn %.3g, lvm %.3g\n", nn, rnn, lvm);
  EXPECT_LT(rnn, 0.3);
  EXPECT_LT(lvm, 0.1 * nn);
}

TEST(TorqueTraining, KeepsAStartThatCannotBeBetteredAndDoesNotDependOnThreads) {
  const Logs logs(4);
  TorqueOptions options;
  options.iterations = 20;
  options.rate = 0.3;
  options.window_s = 0.3;
  const TorqueReport one = train_torque(logs.truth, logs.data(true), options, "dahl", 1);
  EXPECT_EQ(one.history.best, 0);
  EXPECT_EQ(one.arm.friction.theta, logs.truth.friction.theta);
  const TorqueReport three = train_torque(logs.truth, logs.data(true), options, "dahl", 3);
  EXPECT_EQ(one.history.loss, three.history.loss);
  EXPECT_EQ(one.history.held_out, three.history.held_out);
}

}  // namespace
}  // namespace fricid::estimate
