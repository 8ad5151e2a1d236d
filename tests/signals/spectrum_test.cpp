#include "fricid/signals/spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fricid/signals/block_means.hpp"

namespace fricid::signals {
namespace {

TEST(Welch, IntegratesToTheVariance) {
  // Reference: a sine of amplitude A has variance A^2 / 2, all of it at its frequency.
  constexpr double kSampleRate = 250, kAmplitude = 3, kFrequency = 20;
  Eigen::VectorXd x(5000);
  for (int k = 0; k < x.size(); ++k)
    x[k] = 7 + kAmplitude * std::sin(2 * M_PI * kFrequency * k / kSampleRate);
  const Spectrum spectrum = welch(x, kSampleRate, 500);
  const double bin = kSampleRate / 500;
  double variance = 0;
  Eigen::Index peak = 0;
  for (Eigen::Index k = 0; k < spectrum.density.size(); ++k) {
    variance += spectrum.density[k] * bin;
    if (spectrum.density[k] > spectrum.density[peak]) peak = k;
  }
  EXPECT_NEAR(variance, kAmplitude * kAmplitude / 2, 1e-3);
  EXPECT_DOUBLE_EQ(spectrum.frequency_hz[peak], kFrequency);
}

TEST(Welch, OctavesKeepTheLevelOfWhiteNoise) {
  Spectrum flat{Eigen::VectorXd::LinSpaced(250, 1, 250), Eigen::VectorXd::Constant(250, 0.3)};
  const Spectrum smooth = smoothed_by_octaves(flat);
  EXPECT_LT(smooth.density.size(), 60);
  EXPECT_NEAR(smooth.density.minCoeff(), 0.3, 1e-12);
  EXPECT_NEAR(smooth.density.maxCoeff(), 0.3, 1e-12);
  EXPECT_GT(smooth.frequency_hz.minCoeff(), 0.99);
}

TEST(BlockMeans, LeaveOutWhatIsMissing) {
  Eigen::VectorXd x(7);
  x << 1, NAN, 4, 6, NAN, NAN, 100;  // the last is left over
  const Eigen::VectorXd means = block_means(x, 3);
  EXPECT_DOUBLE_EQ(means[0], 1);
  EXPECT_DOUBLE_EQ(means[1], 5);
  EXPECT_TRUE(std::isnan(means[2]));
}

}  // namespace
}  // namespace fricid::signals
