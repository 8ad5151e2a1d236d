// What each part of the latent-variable model is worth on a small arm whose friction remembers and
// grows with the load: without latents, by the paper's model, without the load.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "arm_data.hpp"
#include "fricid/estimate/friction/torque_training.hpp"
#include "fricid/estimate/windows/multi_step.hpp"

namespace fricid::estimate {
namespace {

constexpr double kCutoff = 10;

struct Score {
  double torque;     ///< share of the held-out torque that is left
  double open_loop;  ///< held-out error of position [rad^2]
};

class Ablation : public ::testing::Test {
 protected:
  Arm truth{small_arm(), {}};
  std::vector<signals::Recording> recordings;
  TorqueData data;
  friction::SignalSizes sizes;

  Ablation() {
    const friction::JointSpec joint{{{"dahl", 0, {{"load"}}}}};
    truth.friction.model = friction::RobotFriction({joint, joint, joint});
    for (const double Fc : {6.0, 5.0, 3.0})
      for (const double value : {Fc, Fc / 4e-3, 0.3 * Fc, 0.03})
        truth.friction.theta.push_back(value);
    for (const std::uint64_t seed : {1, 2, 3}) {
      LogOptions options;
      options.seed = seed;
      options.substeps = 16;
      recordings.push_back(signals::make_recording(make_log(truth, options), kCutoff));
    }
    data = torque_data(truth, recordings, true);
    for (int j = 0; j < 3; ++j) {
      double square = 0, rows = 0;
      for (const RowMatrix& target : data.target) {
        square += target.col(j).squaredNorm();
        rows += static_cast<double>(target.rows());
      }
      sizes.q_mean.push_back(0);
      sizes.q_sd.push_back(1);
      sizes.v_sd.push_back(1);
      sizes.tau_sd.push_back(std::sqrt(square / rows));
    }
  }

  /// A model with the true rigid body, trained on the torque for all alike.
  Score trained(const std::string& name, const friction::RobotFriction& model,
                const std::function<void(std::vector<double>&)>& change = {}) {
    Arm start = truth;
    start.friction = {model, friction::default_theta(model)};
    friction::set_signal_sizes(model, sizes, start.friction.theta);
    friction::initialise_weights(model, 1, start.friction.theta);
    if (change) change(start.friction.theta);
    TorqueOptions options;
    options.window_s = 0.2;
    options.batch = 16;
    options.iterations = 500;
    options.rate = 1e-2;
    const TorqueReport report = train_torque(start, data, options, name, 2);
    const Split split = split_recordings(recordings, options.hold_out);
    const Score score{report.history.best_held_out(),
                      held_out_error(report.arm, recordings, split, {8, 1}, 2)};
    std::printf("%-16s torque left %.2e, open loop %.2e rad2\n", name.c_str(), score.torque,
                score.open_loop);
    return score;
  }
  static friction::RobotFriction each(const std::string& law) {
    return friction::RobotFriction(std::vector<friction::JointSpec>(3, {{{law, 8, {}}}}));
  }
};

TEST_F(Ablation, EveryPartOfTheModelIsWorthSomething) {
  const friction::RobotFriction lvm = each("lvm_bristles");
  const Score whole = trained("lvm_bristles", lvm);
  const Score blind = trained("without load", lvm, [&](std::vector<double>& theta) {
    for (std::size_t p = 0; p < theta.size(); ++p)
      if (lvm.parameters()[p].symbol == "load_ref") theta[p] = lvm.parameters()[p].info.upper;
  });
  const Score paper =
      trained("lvm_paper", friction::RobotFriction(std::vector<friction::JointSpec>(3),
                                                   {.law = "lvm_paper", .elements = 32}));
  const Score memoryless = trained("without latents", each("neural"));
  EXPECT_LT(4 * whole.torque, blind.torque);
  EXPECT_LT(4 * blind.torque, memoryless.torque);
  EXPECT_LT(4 * blind.torque, paper.torque);
  EXPECT_LT(paper.torque, memoryless.torque);
  for (const Score& less : {blind, paper, memoryless})
    EXPECT_LT(4 * whole.open_loop, less.open_loop);
}

}  // namespace
}  // namespace fricid::estimate
