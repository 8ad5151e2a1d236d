// Held-out recordings that do not belong. Reference: errors of known size, put into predictions.
#include "fricid/evaluate/unexplained.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fricid/base/rng.hpp"

namespace fricid::evaluate {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kRate = 100, kNoise = 0.2;  // [Hz], [N m]
constexpr int kSamples = 2000;

/// Two joints under 10 and 4 N m of torque.
Trajectory recording(const std::string& name) {
  Trajectory trajectory;
  data::Dataset& d = trajectory.data;
  d.name = name;
  d.joint_names = {"a1", "a2"};
  d.rate_hz = kRate;
  d.t = Eigen::VectorXd::LinSpaced(kSamples, 0, (kSamples - 1) / kRate);
  d.q = d.tau = data::RowMatrix::Zero(kSamples, 2);
  for (int k = 0; k < kSamples; ++k)
    d.tau.row(k) << 10 * std::sin(3 * d.t[k]), 4 * std::cos(2 * d.t[k]);
  return trajectory;
}

/// A prediction with noise of a size.
TorquePrediction predicted(const Trajectory& trajectory, double noise, std::uint64_t seed) {
  TorquePrediction prediction;
  prediction.tau = trajectory.data.tau;
  Rng rng(seed, 3);
  for (double& tau : prediction.tau.reshaped()) tau += noise * rng.normal();
  return prediction;
}

double r2(const Trajectory& trajectory, const TorquePrediction& prediction, int j) {
  const Eigen::VectorXd tau = trajectory.data.tau.col(j);
  return 1 -
         (prediction.tau.col(j) - tau).squaredNorm() / (tau.array() - tau.mean()).square().sum();
}

struct Case {
  std::vector<Trajectory> training{recording("train_0")}, held_out{recording("validation_0")};
  std::vector<TorquePrediction> on_training{predicted(training[0], kNoise, 1)},
      on_held_out{predicted(held_out[0], kNoise, 2)};

  /// What is found after something was added to the torque of a2 from one time to another.
  std::vector<Unexplained> with(double from_s, double to_s, double torque) {
    for (int k = 0; k < kSamples; ++k)
      if (const double t = held_out[0].data.t[k]; t >= from_s && t < to_s)
        held_out[0].data.tau(k, 1) += torque;
    return find();
  }
  std::vector<Unexplained> find() {
    on_held_out[0].r2 = {r2(held_out[0], on_held_out[0], 0), r2(held_out[0], on_held_out[0], 1)};
    const Judge judge{on_held_out, on_training};
    return find_unexplained(held_out, training, {&judge, 1});
  }
};

TEST(Unexplained, ARecordingLikeTheTrainingIsNot) { EXPECT_THAT(Case().find(), IsEmpty()); }

TEST(Unexplained, ACollisionIsNamedWithItsTimes) {
  const std::vector<Unexplained> found = Case().with(6.995, 7.995, 30);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].recording, "validation_0");
  EXPECT_EQ(found[0].joint, "a2");
  EXPECT_FALSE(found[0].throughout);
  EXPECT_NEAR(found[0].begin_s, 7, 0.02);
  EXPECT_NEAR(found[0].end_s, 8, 0.02);
  EXPECT_NEAR(found[0].residual, 30, 0.1);
  EXPECT_NEAR(found[0].training_residual, kNoise, 0.1 * kNoise);
  EXPECT_THAT(found[0].in_words(), HasSubstr("from 7 to 7.99 s 30 N m of its torque are unexpl"));
}

// A second judge, whose worst window of the training data is as bad as the push, hides nothing.
TEST(Unexplained, APushIsNamedByTheBestModelAlone) {
  Case pushed;
  const std::vector<TorquePrediction> rough{predicted(pushed.training[0], 1, 5)};
  for (int k = 700; k < 740; ++k) pushed.held_out[0].data.tau(k, 1) += 1.5;
  std::vector<TorquePrediction> rough_held_out{predicted(pushed.held_out[0], 1, 6)};
  pushed.find();
  rough_held_out[0].r2 = {r2(pushed.held_out[0], rough_held_out[0], 0),
                          r2(pushed.held_out[0], rough_held_out[0], 1)};
  const Judge judges[] = {{rough_held_out, rough}, {pushed.on_held_out, pushed.on_training}};
  const auto found = find_unexplained(pushed.held_out, pushed.training, judges);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].joint, "a2");
  EXPECT_NEAR(found[0].begin_s, 7, 0.02);
}

TEST(Unexplained, AnotherLoadIsNamedThroughout) {
  const std::vector<Unexplained> found = Case().with(0, 20, 4);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].throughout);
  EXPECT_LT(found[0].r2, 0.5);
  EXPECT_THAT(found[0].in_words(), HasSubstr("4 N m of its torque are unexplained, 20 times the"));
}

TEST(Unexplained, ErrorsThatTheTrainingHasTooAreNot) {
  Case poor;  // no better anywhere
  poor.on_training[0] = predicted(poor.training[0], 3, 1);
  poor.on_held_out[0] = predicted(poor.held_out[0], 5, 2);
  EXPECT_THAT(poor.find(), IsEmpty());
  Case stretch;  // the training has such a second as well
  for (int k = 500; k < 600; ++k) stretch.training[0].data.tau(k, 1) += 30;
  EXPECT_THAT(stretch.with(7, 8, 30), IsEmpty());
}

TEST(Unexplained, SmallErrorsOfAnExactModelAreNot) {
  Case exact;
  exact.on_training[0] = predicted(exact.training[0], 0.001, 1);
  EXPECT_THAT(exact.with(7, 8, 1), IsEmpty());  // a quarter of the torque
}

TEST(Unexplained, WhatOneModelExplainsIsNot) {
  Case one;
  one.with(7, 8, 30);
  std::vector<TorquePrediction> better{predicted(one.held_out[0], kNoise, 4)};
  better[0].r2 = {1, 1};
  const Judge judges[]{{one.on_held_out, one.on_training}, {better, one.on_training}};
  EXPECT_THAT(find_unexplained(one.held_out, one.training, judges), IsEmpty());
  EXPECT_THAT(find_unexplained(one.held_out, one.training, {}), IsEmpty());
}

// Samples without a torque say nothing.
TEST(Unexplained, MissingTorqueIsNot) {
  Case gap;
  gap.held_out[0].data.tau.middleRows(300, 200).setConstant(std::nan(""));
  gap.on_held_out[0].r2 = {1, 1};
  const Judge judge{gap.on_held_out, gap.on_training};
  EXPECT_THAT(find_unexplained(gap.held_out, gap.training, {&judge, 1}), IsEmpty());
}

}  // namespace
}  // namespace fricid::evaluate
