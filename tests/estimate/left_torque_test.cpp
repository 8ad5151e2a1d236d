// Torque that goes with the position of a joint is found, however short its waves are, and a torque
// that is not proportional to the current.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fit_of_logs.hpp"
#include "fricid/estimate/torque/joint_fit.hpp"

namespace fricid::estimate {
namespace {

/// What `look(fits, arm)` finds in the torque that LuGre friction leaves of logs.
template <class Look>
auto left_by_lugre(const dynamics::RobotModel& robot, const std::vector<data::Dataset>& logs,
                   const Look& look) {
  const Prepared prepared = prepare(robot, {}, logs, 2);
  const JointFits fits(prepared, {}, 2);
  const Arm start = fits.start(friction::JointSpec{{{"lugre", 0, {}}}});
  return look(fits, fits.on_torque(start, JointFits::Rows::kTraining).arm);
}

TEST(PositionWave, CoggingIsFoundWithItsPeriods) {
  const Arm arm = lugre_arm();
  std::vector<data::Dataset> logs;
  for (const std::uint64_t seed : {1, 2})
    logs.push_back(
        make_log(arm, {.seconds = 24, .peak_speed = 0.4, .torque_noise = 0.3, .seed = seed}));
  for (const double periods : {0., 20., 90.}) {
    std::vector<data::Dataset> cogging = logs;
    for (data::Dataset& log : cogging)
      for (Eigen::Index k = 0; k < log.q.rows(); ++k)
        log.tau(k, 1) += 1.5 * std::sin(periods * log.q(k, 1) + 0.4);
    const std::vector<PositionWave> waves = left_by_lugre(
        arm.robot, cogging,
        [](const JointFits& fits, const Arm& fitted) { return fits.waves_of(fitted); });
    ASSERT_EQ(waves.size(), 3u);
    EXPECT_LT(waves[0].share, 0.2);
    EXPECT_FALSE(waves[1].slides);
    if (periods == 0) {
      EXPECT_LT(waves[1].share, 0.2);
    } else {
      EXPECT_NEAR(waves[1].n, periods, 2);  // a quarter of a period over the travel
      EXPECT_GT(waves[1].share, 0.3) << periods;
    }
  }
}

// Friction that is three times as large within a twentieth of the travel.
TEST(TightSpot, IsFoundWithItsPlace) {
  const Arm arm = lugre_arm();
  std::vector<data::Dataset> logs;
  for (const std::uint64_t seed : {1, 2})
    logs.push_back(
        make_log(arm, {.seconds = 24, .peak_speed = 0.8, .torque_noise = 0.3, .seed = seed}));
  for (const bool tight : {false, true}) {
    constexpr double kPlace = 0.15, kHalfWidth = 0.05;
    for (data::Dataset& log : logs)
      for (Eigen::Index k = 1; tight && k < log.q.rows(); ++k)
        if (std::abs(log.q(k, 1) - kPlace) < kHalfWidth)
          log.tau(k, 1) += log.q(k, 1) > log.q(k - 1, 1) ? 8 : -8;
    const std::vector<TightSpot> spots = left_by_lugre(
        arm.robot, logs,
        [](const JointFits& fits, const Arm& fitted) { return fits.spots_of(fitted); });
    ASSERT_EQ(spots.size(), 3u);
    EXPECT_LT(spots[0].share, 0.1);
    EXPECT_LT(spots[2].share, 0.1);
    if (!tight) {
      EXPECT_LT(spots[1].share, 0.1);
    } else {
      EXPECT_GT(spots[1].share, 0.2);
      EXPECT_NEAR(spots[1].at, kPlace, kHalfWidth);
      EXPECT_GT(spots[1].more, 2);
    }
  }
}

// A motor that gives 15 % less than its current says at the largest torque.
TEST(TorqueBend, AFallingTorqueConstantIsFound) {
  const Arm arm = lugre_arm();
  for (const double falls : {0., 0.15}) {
    std::vector<data::Dataset> logs;
    for (const std::uint64_t seed : {1, 2})
      logs.push_back(
          make_log(arm, {.seconds = 24, .peak_speed = 2.5, .torque_noise = 0.1, .seed = seed}));
    double largest = 0;
    for (const data::Dataset& log : logs)
      largest = std::max(largest, log.tau.col(1).cwiseAbs().maxCoeff());
    for (data::Dataset& log : logs)
      log.tau.col(1).array() *= 1 + falls * (log.tau.col(1).array() / largest).square();
    const std::vector<TorqueBend> bends = left_by_lugre(
        arm.robot, logs,
        [](const JointFits& fits, const Arm& fitted) { return fits.bends_of(fitted); });
    ASSERT_EQ(bends.size(), 3u);
    EXPECT_LT(bends[0].share, 0.1);
    EXPECT_LT(bends[2].share, 0.1);
    if (falls == 0) {
      EXPECT_LT(bends[1].share, 0.1);
    } else {
      EXPECT_GT(bends[1].share, 0.3);
      EXPECT_GT(bends[1].at_largest, 0.02);
      EXPECT_LT(bends[1].at_largest, 0.2);
    }
  }
}

}  // namespace
}  // namespace fricid::estimate
