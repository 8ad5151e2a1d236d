// Gauss-Newton steps with a sampled matrix on problems whose solution is known.
#include "fricid/optimise/gauss_newton.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "fricid/base/rng.hpp"

namespace fricid::optimise {
namespace {

/// r = J (x - wanted), the columns of a random J (2 n x n) scaled from 1 to 1e-2.
struct LeastSquares {
  Eigen::MatrixXd J;
  Eigen::VectorXd wanted;

  explicit LeastSquares(int n) : J(2 * n, n), wanted(n) {
    Rng rng(1, 0);
    for (int j = 0; j < n; ++j) {
      wanted[j] = rng.normal();
      const double scale = std::pow(10.0, -2.0 * j / (n - 1)) / std::sqrt(2.0 * n);
      for (int i = 0; i < 2 * n; ++i) J(i, j) = scale * rng.normal();
    }
  }
  Eigen::VectorXd gradient(const Eigen::VectorXd& x) const {
    return J.transpose() * (J * (x - wanted));
  }
  Eigen::MatrixXf samples(int count) const {
    Rng rng(2, 0);
    Eigen::MatrixXd signs(J.rows(), count);
    for (int k = 0; k < count; ++k)
      for (Eigen::Index i = 0; i < J.rows(); ++i) signs(i, k) = rng.uniform() < 0.5 ? -1 : 1;
    return (J.transpose() * signs).cast<float>();
  }
};

constexpr int kSize = 520;  // three panels of the matrix

TEST(GaussNewton, ReachesTheSolutionHoweverIllConditioned) {
  const LeastSquares problem(kSize);
  const Eigen::VectorXd bound = Eigen::VectorXd::Constant(kSize, 1e3);
  GaussNewton optimiser(kSize);
  optimiser.refresh(problem.samples(20 * kSize), 2);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kSize);
  for (int k = 0; k < 300; ++k)
    ASSERT_TRUE(optimiser.step(problem.gradient(x), 1, {-bound, bound}, x));
  EXPECT_LT((x - problem.wanted).norm(), 0.02 * problem.wanted.norm());
}

TEST(GaussNewton, DoesNotDependOnThreadsAndStaysInItsBox) {
  const LeastSquares problem(kSize);
  const Eigen::VectorXd bound = Eigen::VectorXd::Constant(kSize, 0.5);
  Eigen::VectorXd ends[2];
  for (const int jobs : {1, 3}) {
    GaussNewton optimiser(kSize);
    Eigen::VectorXd& x = ends[jobs / 2];
    x.setZero(kSize);
    for (int k = 0; k < 10; ++k) {
      if (k % 5 == 0) optimiser.refresh(problem.samples(64), jobs);
      optimiser.step(problem.gradient(x), 1, {-bound, bound}, x);
    }
  }
  EXPECT_EQ(ends[0], ends[1]);
  EXPECT_LE(ends[0].cwiseAbs().maxCoeff(), 0.5);
  EXPECT_GT(ends[0].norm(), 0);
}

// A rollout that falls has a gradient of any size.
TEST(GaussNewton, OneHugeSampleDoesNotRuleTheMatrix) {
  const LeastSquares problem(kSize);
  const Eigen::VectorXd bound = Eigen::VectorXd::Constant(kSize, 1e3);
  GaussNewton optimiser(kSize);
  Eigen::MatrixXf samples = problem.samples(20 * kSize);
  samples.col(7) *= 1e9F;
  optimiser.refresh(samples, 2);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kSize);
  for (int k = 0; k < 300; ++k)
    ASSERT_TRUE(optimiser.step(problem.gradient(x), 1, {-bound, bound}, x));
  EXPECT_LT((x - problem.wanted).norm(), 0.02 * problem.wanted.norm());
}

TEST(Outliers, AreLongerThanSoManyMediansOrNotFinite) {
  Eigen::MatrixXf samples = Eigen::MatrixXf::Ones(2, 7);
  samples.col(1) *= 29;
  samples.col(3) *= 31;
  samples(0, 4) = std::numeric_limits<float>::infinity();
  samples(1, 6) = std::numeric_limits<float>::quiet_NaN();
  const std::vector<bool> expected{false, false, false, true, true, false, true};
  EXPECT_EQ(outliers(samples, 30), expected);
}

TEST(GaussNewton, SkipsAGradientThatIsNotFinite) {
  const LeastSquares problem(8);
  const Eigen::VectorXd bound = Eigen::VectorXd::Constant(8, 1e3);
  GaussNewton optimiser(8);
  optimiser.refresh(problem.samples(64), 1);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(8), gradient = problem.gradient(x);
  gradient[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(optimiser.step(gradient, 1, {-bound, bound}, x));
  EXPECT_EQ(x.norm(), 0);
}

}  // namespace
}  // namespace fricid::optimise
