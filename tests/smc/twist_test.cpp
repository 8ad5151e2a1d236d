// The twisted filter is exact on linear models.
#include "fricid/smc/twisted_guide.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <string_view>

#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/statistical_twist.hpp"
#include "linear_gaussian.hpp"

namespace fricid::smc {
namespace {

using namespace std::string_view_literals;

class TwistOnLinear : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(TwistOnLinear, LikelihoodIsExactWithoutVariance) {
  const auto [n, T] = GetParam();
  const std::vector<Part> parts{{{0, 1}, 1}};
  for (const auto* way : {"jacobian", "statistical", "bent"})
    for (const bool holes : {false, true}) {
      SCOPED_TRACE(testing::Message() << "holes " << holes << ", " << way);
      LinearModel model = test::random_model(n, 3);
      RowMatrix y = test::simulate(model, T, 5).y;
      if (holes) test::punch_holes(y);
      GaussianPath path;
      gaussian_smoother(model, y, path);
      Twist twist;
      if (way == "jacobian"sv)
        make_twist(model, y, path, twist);
      else if (way == "statistical"sv)
        ASSERT_TRUE(make_statistical_twist(model, y, path.smoothed, twist));
      else
        ASSERT_TRUE(make_bent_twist(model, y, parts, path.smoothed, twist));

      TwistedGuide<PackD> guide(model, twist);
      Report report;
      for (const std::uint64_t seed : {1, 2, 3}) {
        FilterOptions options;
        options.particles = 20;
        options.seed = seed;
        ParticleFilter filter(model, guide, options);
        filter.run(report);
        EXPECT_NEAR(report.log_likelihood, path.log_likelihood, 1e-8);
        EXPECT_EQ(report.resampled, 0);
        EXPECT_EQ(report.distinct_roots, 20);
        EXPECT_GT(report.min_ess(), 20 - 1e-6);
        for (const double lw : filter.log_weights()) EXPECT_NEAR(lw, -std::log(20), 1e-8);
      }
    }
}
INSTANTIATE_TEST_SUITE_P(Sizes, TwistOnLinear,
                         testing::Combine(testing::Values(2, 6, 18), testing::Values(50, 1000)));

/// x' = a x + b |x| + w, y = x + e: all answers by sums over a grid.
class KinkedModel {
 public:
  static constexpr double kSlope = 0.9, kKink = 0.8;
  KinkedModel() : start_(one(0.1, 0.2)), Q_(start_.covariance), C_(Q_), R_(Q_) {
    Q_ << 0.04;
    C_ << 1;
    R_ << 0.3;
  }
  int state_size() const { return 1; }
  int observation_size() const { return 1; }
  const Gaussian& initial() const { return start_; }
  const Eigen::MatrixXd& Q() const { return Q_; }
  const Eigen::MatrixXd& C() const { return C_; }
  const Eigen::MatrixXd& R() const { return R_; }
  template <class S>
  void transition(int, std::span<S> x) {
    x[0] = S(static_cast<Real<S>>(kSlope)) * x[0] - S(static_cast<Real<S>>(kKink)) * abs(x[0]);
  }
  void linearise(int, const Eigen::VectorXd& x, Eigen::VectorXd& f, Eigen::MatrixXd& A) {
    f = kSlope * x - kKink * x.cwiseAbs();
    A.setConstant(1, 1, kSlope - kKink * (x(0) > 0 ? 1 : -1));
  }

  /// log p(y) by the trapezoidal rule; the step of 0.01 errs by about 1e-5.
  double log_likelihood(const RowMatrix& y) const {
    constexpr int kPoints = 801;
    constexpr double kEdge = 4, kStep = 2 * kEdge / (kPoints - 1);
    const auto density = [](double r, double variance) {
      return std::exp(-0.5 * r * r / variance) / std::sqrt(2 * std::numbers::pi * variance);
    };
    const auto at = [](int i) { return -kEdge + kStep * i; };
    std::vector<double> p(kPoints), next(p);
    for (int i = 0; i < kPoints; ++i)
      p[static_cast<std::size_t>(i)] = density(at(i) - start_.mean(0), start_.covariance(0, 0));
    double sum = 0;
    for (int t = 0; t < y.rows(); ++t) {
      double total = 0;
      for (int i = 0; i < kPoints; ++i) {
        p[static_cast<std::size_t>(i)] *= density(y(t, 0) - at(i), R_(0, 0));
        total += kStep * p[static_cast<std::size_t>(i)];
      }
      sum += std::log(total);
      std::fill(next.begin(), next.end(), 0);
      for (int i = 0; i < kPoints; ++i) {
        const double f = kSlope * at(i) - kKink * std::abs(at(i));
        for (int j = 0; j < kPoints; ++j)
          next[static_cast<std::size_t>(j)] +=
              kStep * density(at(j) - f, Q_(0, 0)) * p[static_cast<std::size_t>(i)] / total;
      }
      p.swap(next);
    }
    return sum;
  }

 private:
  static Gaussian one(double mean, double variance) {
    return {Eigen::VectorXd::Constant(1, mean), Eigen::MatrixXd::Constant(1, 1, variance)};
  }
  Gaussian start_;
  Eigen::MatrixXd Q_, C_, R_;
};

// Claim: however psi is bent, the likelihood stays unbiased; a kink in psi takes out most of the
// variance that one in f causes.
TEST(BentTwist, IsUnbiasedAndSteadierWhereTheModelHasAKink) {
  KinkedModel model;
  RowMatrix y(8, 1);
  y << 0.3, -0.2, 0.4, -0.9, 0.5, 0.1, -0.6, 0.2;
  const double exact = model.log_likelihood(y);
  const std::vector<Part> kinked{{{0}, 0}}, smooth{{{0}, -1}};
  double variance[3];
  int way = 0;
  for (const std::span<const Part> parts :
       {std::span<const Part>(), std::span<const Part>(smooth), std::span<const Part>(kinked)}) {
    SCOPED_TRACE(way);
    GaussianPath path;
    gaussian_smoother(model, y, path, 2);
    Twist twist;
    ASSERT_TRUE(make_bent_twist(model, y, parts, path.smoothed, twist));
    TwistedGuide<PackD> guide(model, twist);
    FilterOptions options;
    options.particles = 100'000;
    options.ess_threshold = 0;
    ParticleFilter filter(model, guide, options);
    Report report;
    filter.run(report);
    double squares = 0;
    for (const double lw : filter.log_weights()) squares += std::exp(2 * lw);
    variance[way] = options.particles * squares - 1;
    EXPECT_LT(std::abs(report.log_likelihood - exact),
              4.5 * std::sqrt(variance[way] / options.particles));
    ++way;
  }
  EXPECT_LT(variance[1], 0.6 * variance[0]);
  EXPECT_LT(variance[2], 0.2 * variance[0]);
}

TEST(BentTwist, RefusesCovariancesThatAreNone) {
  LinearModel model = test::random_model(2, 3);
  const RowMatrix y = test::simulate(model, 20, 5).y;
  const std::vector<Part> parts{{{0, 1}, 1}};
  for (const double variance : {-1.0, 0.0, std::nan(""), HUGE_VAL}) {
    GaussianPath path;
    gaussian_smoother(model, y, path);
    path.smoothed[7].covariance(1, 1) = variance;
    Twist twist;
    EXPECT_FALSE(make_statistical_twist(model, y, path.smoothed, twist)) << variance;
    EXPECT_FALSE(make_bent_twist(model, y, parts, path.smoothed, twist)) << variance;
  }
}

TEST(NormalDistribution, QuantileInvertsTheDistributionFunction) {
  for (const double p : {1e-300, 1e-30, 1e-9, 1e-3, 0.2, 0.49, 0.5, 0.6, 0.999})
    EXPECT_NEAR(normal_cdf(normal_quantile(p)) / p, 1, 1e-12) << p;
  EXPECT_DOUBLE_EQ(normal_quantile(0.25), -normal_quantile(0.75));
}

// Claim: exactness does not depend on the reference path, which only centres the numbers.
TEST(Twist, AnyReferencePathGivesTheSameLikelihood) {
  LinearModel model = test::random_model(6, 3);
  const RowMatrix y = test::simulate(model, 200, 5).y;
  GaussianPath path;
  gaussian_smoother(model, y, path);
  Rng rng(4, 0);
  for (Gaussian& x : path.smoothed) x.mean += test::random_matrix(rng, 6, 1);
  Twist twist;
  make_twist(model, y, path, twist);
  TwistedGuide<PackD> guide(model, twist);
  Report report;
  ParticleFilter filter(model, guide, FilterOptions{});
  filter.run(report);
  EXPECT_NEAR(report.log_likelihood, path.log_likelihood, 1e-8);
}

// Claim: particles of the twisted filter are draws from the smoothed distribution.
TEST(Twist, ParticlesHaveTheSmoothedMoments) {
  LinearModel model = test::tracking_model();
  const RowMatrix y = test::simulate(model, 30, 5).y;
  GaussianPath path;
  gaussian_smoother(model, y, path);
  Twist twist;
  make_twist(model, y, path, twist);
  TwistedGuide<PackD> guide(model, twist);
  FilterOptions options;
  options.particles = 4000;
  ParticleFilter filter(model, guide, options);
  auto history = History<PackD>::full(2, options.particles, 30);
  Report report;
  filter.run(report, &history);
  for (int t = 0; t < 30; ++t) {
    const Cloud<PackD>& x = filter.at(history, t).x;
    const Gaussian& smoothed = path.smoothed[static_cast<std::size_t>(t)];
    for (int i = 0; i < 2; ++i) {
      const double variance = smoothed.covariance(i, i);
      double mean = 0, square = 0;
      for (int p = 0; p < options.particles; ++p) {
        const double d = x.at(p, i) - smoothed.mean(i);
        mean += d, square += d * d;
      }
      EXPECT_LT(std::abs(mean) / std::sqrt(options.particles * variance), 4.5);
      EXPECT_LT(std::abs(square / variance - options.particles),
                4.5 * std::sqrt(2.0 * options.particles));
    }
  }
}

// Claim: psi_t(x) = p(y_t | x) is the fully adapted filter, particle by particle.
TEST(Twist, ForesightOfOneIsTheAdaptedFilter) {
  LinearModel model = test::random_model(6, 9);
  RowMatrix y = test::simulate(model, 60, 5).y;
  test::punch_holes(y);
  GaussianPath path;
  gaussian_smoother(model, y, path);
  Twist twist;
  make_twist(model, y, path, twist, Foresight::kOne);
  // the two factor the first covariance differently, so all start at one point
  model.start.covariance.setZero();
  AdaptedGuide<PackD> adapted_from_point(model, y);
  TwistedGuide<PackD> twisted_from_point(model, twist);
  FilterOptions options;
  options.particles = 100;
  Report a, b;
  ParticleFilter first(model, adapted_from_point, options);
  ParticleFilter second(model, twisted_from_point, options);
  first.run(a);
  second.run(b);
  EXPECT_NEAR(a.log_likelihood, b.log_likelihood, 1e-9 * std::abs(a.log_likelihood));
  EXPECT_EQ(a.resampled, b.resampled);
  for (std::size_t t = 0; t < a.ess.size(); ++t) EXPECT_NEAR(a.ess[t], b.ess[t], 1e-6);
  for (int p = 0; p < 100; ++p) EXPECT_NEAR(first.x().at(p, 0), second.x().at(p, 0), 1e-9);
}

}  // namespace
}  // namespace fricid::smc
