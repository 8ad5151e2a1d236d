// Torque that is held from its samples on is told from torque that is measured at them.
#include "fricid/estimate/rigid_body/torque_timing.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "arm_data.hpp"

namespace fricid::estimate {
namespace {

std::optional<TorqueTiming> timing_of(const Arm& arm, const data::Dataset& log) {
  const std::vector<signals::Recording> recordings{signals::make_recording(log, 10)};
  return torque_timing(arm.robot, recordings, {});
}

/// The torque in force about each sample, which a sensor would log, instead of the one held from
/// it.
data::Dataset measured(data::Dataset log) {
  for (Eigen::Index k = log.length() - 1; k > 0; --k)
    log.tau.row(k) = (log.tau.row(k - 1) + log.tau.row(k)) / 2;
  return log;
}

TEST(TorqueTiming, TellsMeasuredFromHeldTorque) {
  Arm stribeck = coulomb_arm();
  stribeck.friction = same_law("lugre", {3, 4.5, 0.1, 3000, 30, 2}, 3);
  for (const Arm& arm : {coulomb_arm(), stribeck}) {
    const data::Dataset log =
        make_log(arm, {.seconds = 36, .peak_speed = 3, .torque_noise = 0.02, .seed = 7});
    const auto held = timing_of(arm, log), at_samples = timing_of(arm, measured(log)),
               between = timing_of(arm, data::held_between_samples(measured(log)));
    ASSERT_TRUE(held && at_samples && between);
    EXPECT_NEAR(held->delay, 0, 4 * held->standard_error);
    EXPECT_NEAR(at_samples->delay, 0.5, 4 * at_samples->standard_error);
    EXPECT_NEAR(between->delay, 0, 4 * between->standard_error);
    EXPECT_LT(held->standard_error, 0.05);
    EXPECT_FALSE(held->is_at_samples());
    EXPECT_TRUE(at_samples->is_at_samples()) << at_samples->delay << " " << at_samples->gain;

    data::Dataset last_rests = measured(log);
    last_rests.q.col(2).setConstant(log.q(0, 2));
    const auto of_two = timing_of(arm, last_rests);
    EXPECT_TRUE(of_two && std::isfinite(of_two->gain));
  }
}

// A torque that hardly changes says nothing of its timing.
TEST(TorqueTiming, IsLeftAsItIsWhereTheLogDoesNotTell) {
  const Arm arm = coulomb_arm();
  const data::Dataset log =
      make_log(arm, {.seconds = 36, .peak_speed = 0.3, .torque_noise = 0.5, .seed = 7});
  const auto timing = timing_of(arm, measured(log));
  EXPECT_FALSE(timing && timing->is_at_samples());
}

TEST(TorqueTiming, NeedsRows) {
  const Arm arm = coulomb_arm();
  EXPECT_FALSE(timing_of(arm, make_log(arm, {.seconds = 1})));
}

}  // namespace
}  // namespace fricid::estimate
