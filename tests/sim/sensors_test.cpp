#include "fricid/sim/sensors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "arms.hpp"
#include "fricid/base/rng.hpp"

namespace fricid::sim::test {
namespace {

constexpr int kSamples = 20000, kJoints = 2;

dynamics::RobotModel robot() {
  dynamics::RobotModel model;
  model.joints.resize(kJoints);
  model.joints[0].effort = 100;
  model.joints[1].effort = 20;
  return model;
}

// A trace of smooth motion.
Trace smooth_trace() {
  Trace trace = make_trace(kSamples, 0.004, kJoints, 0);
  for (int k = 0; k < kSamples; ++k) {
    for (int j = 0; j < kJoints; ++j) {
      trace.q(k, j) = std::sin(0.01 * k + j);
      trace.v(k, j) = 2.5 * std::cos(0.01 * k + j);
      trace.tau(k, j) = 10 * std::cos(0.013 * k + j);
    }
  }
  return trace;
}

SensorOptions perfect() {
  SensorOptions config;
  config.torque_noise = config.torque_step = 0;
  return config;
}

double sd(const Eigen::VectorXd& x) {
  return std::sqrt((x.array() - x.mean()).square().sum() / static_cast<double>(x.size() - 1));
}

// Standard error of an estimated standard deviation is sd / sqrt(2 T); failure beyond 4.5 of them.
void expect_sd(const Eigen::VectorXd& noise, double expected) {
  const double error = expected / std::sqrt(2.0 * static_cast<double>(noise.size()));
  EXPECT_NEAR(sd(noise), expected, 4.5 * error);
  EXPECT_NEAR(noise.mean(), 0, 4.5 * expected / std::sqrt(static_cast<double>(noise.size())));
}

TEST(Sensors, PerfectOnesCopyTheTruth) {
  const Trace trace = smooth_trace();
  const data::Dataset dataset = measure(trace, perfect(), robot(), 1, 0);
  EXPECT_EQ(dataset.q, trace.q);
  EXPECT_EQ(dataset.tau, trace.tau);
  EXPECT_EQ(dataset.v.size(), 0);
  EXPECT_EQ(dataset.temperature.size(), 0);
}

TEST(Sensors, NoiseHasTheStatedSpreadAndNoCorrelation) {
  const Trace trace = smooth_trace();
  SensorOptions config = perfect();
  config.encoder_noise_rad = {1e-5, 3e-5};
  config.torque_noise = 0.002;
  config.velocity = true;
  const data::Dataset dataset = measure(trace, config, robot(), 1, 0);
  const RowMatrix q = dataset.q - trace.q, v = dataset.v - trace.v, tau = dataset.tau - trace.tau;
  expect_sd(q.col(0), 1e-5);
  expect_sd(q.col(1), 3e-5);
  expect_sd(tau.col(0), 0.2);
  expect_sd(tau.col(1), 0.04);
  expect_sd(v.col(0), std::sqrt(2) * 1e-5 / 0.004);
  // streams of joints, channels and sequences have nothing in common
  const data::Dataset next = measure(trace, config, robot(), 1, 1);
  const RowMatrix q_next = next.q - trace.q;
  const auto correlation = [](const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
    return x.dot(y) / (x.norm() * y.norm());
  };
  const double limit = 4.5 / std::sqrt(static_cast<double>(kSamples));
  EXPECT_LT(std::abs(correlation(q.col(0), q.col(1))), limit);
  EXPECT_LT(std::abs(correlation(q.col(0), tau.col(0))), limit);
  EXPECT_LT(std::abs(correlation(q.col(0), v.col(0))), limit);
  EXPECT_LT(std::abs(correlation(q.col(0), q_next.col(0))), limit);
  EXPECT_EQ(measure(trace, config, robot(), 1, 0).q, dataset.q) << "a seed gives the same data";
}

TEST(Sensors, QuantiseToTheStep) {
  const Trace trace = smooth_trace();
  SensorOptions config = perfect();
  config.encoder_step_rad = {1e-3, 2e-3};
  config.torque_step = 0.01;
  const data::Dataset dataset = measure(trace, config, robot(), 1, 0);
  const std::array<double, 2> q_step{1e-3, 2e-3}, tau_step{1, 0.2};
  for (int j = 0; j < kJoints; ++j) {
    const auto i = static_cast<std::size_t>(j);
    const Eigen::ArrayXd counts = dataset.q.col(j).array() / q_step[i];
    EXPECT_LT((counts - counts.round()).abs().maxCoeff(), 1e-9);
    EXPECT_LE((dataset.q - trace.q).col(j).cwiseAbs().maxCoeff(), q_step[i] / 2 * (1 + 1e-9));
    EXPECT_LE((dataset.tau - trace.tau).col(j).cwiseAbs().maxCoeff(), tau_step[i] / 2 * (1 + 1e-9));
    EXPECT_GT((dataset.tau - trace.tau).col(j).cwiseAbs().maxCoeff(), tau_step[i] / 2 * 0.99);
  }
}

TEST(Sensors, DelayTheTorque) {
  const Trace trace = smooth_trace();
  SensorOptions config = perfect();
  config.torque_delay_samples = 3;
  const data::Dataset dataset = measure(trace, config, robot(), 1, 0);
  EXPECT_EQ(dataset.tau.bottomRows(kSamples - 3), trace.tau.topRows(kSamples - 3));
  EXPECT_EQ(dataset.q, trace.q);
}

TEST(Sensors, LogTheTorqueByAWrongConstant) {
  const Trace trace = smooth_trace();
  SensorOptions config = perfect();
  config.torque_gain = {1.03, 0.97};
  const data::Dataset dataset = measure(trace, config, robot(), 1, 0);
  EXPECT_EQ(dataset.tau.col(0), 1.03 * trace.tau.col(0));
  EXPECT_EQ(dataset.tau.col(1), 0.97 * trace.tau.col(1));
}

TEST(Sensors, DropTheStatedShareAndRepeat) {
  const Trace trace = smooth_trace();
  SensorOptions config = perfect();
  config.dropped = 0.1;
  const data::Dataset dataset = measure(trace, config, robot(), 1, 0);
  int dropped = 0;
  for (int k = 1; k < kSamples; ++k) {
    if (dataset.q.row(k) == trace.q.row(k)) continue;
    ++dropped;
    EXPECT_EQ(dataset.q.row(k), dataset.q.row(k - 1));
    EXPECT_EQ(dataset.tau.row(k), dataset.tau.row(k - 1));
  }
  EXPECT_NEAR(dropped, 0.1 * kSamples, 4.5 * std::sqrt(0.09 * kSamples));
}

// Closed form of the warm-up.
TEST(Sensors, TemperatureRisesExponentially) {
  SensorOptions config;
  config.temperature_start_K = 290;
  config.temperature_rise_K = 20;
  config.temperature_time_s = 600;
  EXPECT_DOUBLE_EQ(temperature_at(config, 0), 290);
  EXPECT_NEAR(temperature_at(config, 600), 290 + 20 * (1 - std::exp(-1)), 1e-12);
  EXPECT_NEAR(temperature_at(config, 1e6), 310, 1e-12);
}

}  // namespace
}  // namespace fricid::sim::test
