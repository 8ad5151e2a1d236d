// Kalman filter and smoother against the joint normal distribution solved at once.
#include <gtest/gtest.h>

#include "fricid/smc/kalman.hpp"
#include "linear_gaussian.hpp"

namespace fricid::smc {
namespace {

using test::dense_solution;
using test::random_model;

double relative_error(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

class Dense : public testing::TestWithParam<int> {};

TEST_P(Dense, FilterAndSmootherSolveTheJointNormal) {
  const int n = GetParam(), T = 50;
  for (const bool holes : {false, true}) {
    SCOPED_TRACE(holes);
    LinearModel model = random_model(n, 3);
    RowMatrix y = test::simulate(model, T, 5).y;
    if (holes) test::punch_holes(y);
    GaussianPath path;
    gaussian_smoother(model, y, path);
    ASSERT_FALSE(path.failed);

    const auto dense = dense_solution(model, y);
    EXPECT_NEAR(path.log_likelihood / dense.log_likelihood, 1, 1e-10);
    for (int t = 0; t < T; ++t) {
      const auto k = static_cast<std::size_t>(t);
      const auto block = dense.covariance.block(t * n, t * n, n, n);
      EXPECT_LT(relative_error(path.smoothed[k].mean, dense.mean.segment(t * n, n)), 1e-10);
      EXPECT_LT(relative_error(path.smoothed[k].covariance, block), 1e-10);
      if (t + 1 == T) continue;
      EXPECT_LT(relative_error(path.lag_one[k], dense.covariance.block((t + 1) * n, t * n, n, n)),
                1e-10);
    }
    // filtered at t is smoothed with the data up to t
    for (const int t : {0, 1, T / 2, T - 1}) {
      const auto part = dense_solution(model, y.topRows(t + 1));
      EXPECT_LT(relative_error(path.filtered[static_cast<std::size_t>(t)].mean, part.mean.tail(n)),
                1e-10);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Sizes, Dense, testing::Values(2, 6, 18));

// Reference: the same sums by the joint normal for T = 1000 where it fits in memory, n = 2.
TEST(Kalman, ThousandStepsSolveTheJointNormal) {
  LinearModel model = test::tracking_model();
  const RowMatrix y = test::simulate(model, 1000, 2).y;
  GaussianPath path;
  gaussian_smoother(model, y, path);
  const auto dense = dense_solution(model, y);
  EXPECT_NEAR(path.log_likelihood / dense.log_likelihood, 1, 1e-10);
  for (int t = 0; t < 1000; t += 37) {
    EXPECT_LT(relative_error(path.smoothed[static_cast<std::size_t>(t)].mean,
                             dense.mean.segment(2 * t, 2)),
              1e-10);
  }
}

TEST(Kalman, CovariancesStayPositiveDefinite) {
  for (const int n : {2, 6, 18}) {
    LinearModel model = random_model(n, 4);
    model.error *= 1e-10;  // nearly exact measurements are where the short form fails
    const RowMatrix y = test::simulate(model, 1000, 6).y;
    GaussianPath path;
    gaussian_smoother(model, y, path);
    for (std::size_t t = 0; t < 1000; ++t) {
      for (const auto* list : {&path.filtered, &path.smoothed}) {
        const Eigen::MatrixXd& P = (*list)[t].covariance;
        EXPECT_EQ(P, P.transpose());
        EXPECT_EQ(P.llt().info(), Eigen::Success) << "n = " << n << ", t = " << t;
      }
    }
  }
}

TEST(Kalman, RelinearisingALinearModelChangesNothing) {
  LinearModel model = random_model(6, 8);
  const RowMatrix y = test::simulate(model, 100, 9).y;
  GaussianPath once, thrice;
  gaussian_smoother(model, y, once);
  gaussian_smoother(model, y, thrice, 2);
  EXPECT_NEAR(once.log_likelihood, thrice.log_likelihood, 1e-9);
  for (std::size_t t = 0; t < 100; ++t) {
    EXPECT_LT(relative_error(thrice.smoothed[t].mean, once.smoothed[t].mean), 1e-11);
  }
}

TEST(Kalman, InnovationsOfTheTrueModelAreStandardNormal) {
  LinearModel model = random_model(6, 1);
  const RowMatrix y = test::simulate(model, 1000, 12).y;
  GaussianPath path;
  gaussian_filter(model, y, path);
  double sum = 0, degrees = 0;
  for (std::size_t t = 0; t < 1000; ++t) sum += path.nis[t], degrees += path.present[t];
  EXPECT_LT(std::abs(sum - degrees) / std::sqrt(2 * degrees), 4.5);
}

// Claim: means, covariances and lag-one covariances of drawn paths are those of the smoother.
TEST(Kalman, SampledPathsHaveTheSmoothedMoments) {
  constexpr int kPaths = 4000, kSteps = 20, n = 2;
  LinearModel model = test::tracking_model();
  RowMatrix y = test::simulate(model, kSteps, 3).y;
  test::punch_holes(y);
  GaussianPath path;
  gaussian_smoother(model, y, path);
  std::vector<RowMatrix> x(kPaths);
  sample_gaussian_paths(model.Q(), path, 7, 0, x);
  for (std::size_t t = 0; t + 1 < kSteps; ++t) {
    for (int i = 0; i < n; ++i) {
      double mean = 0, lag = 0;
      for (const RowMatrix& one : x) {
        const auto k = static_cast<Eigen::Index>(t);
        mean += one(k, i) - path.smoothed[t].mean(i);
        lag +=
            (one(k + 1, i) - path.smoothed[t + 1].mean(i)) * (one(k, 0) - path.smoothed[t].mean(0));
      }
      const double var_i = path.smoothed[t].covariance(i, i);
      const double expected = path.lag_one[t](i, 0);
      const double spread =
          std::sqrt(path.smoothed[t + 1].covariance(i, i) * path.smoothed[t].covariance(0, 0) +
                    expected * expected);
      EXPECT_LT(std::abs(mean) / std::sqrt(kPaths * var_i), 4.5);
      EXPECT_LT(std::abs(lag / kPaths - expected) * std::sqrt(kPaths) / spread, 4.5);
    }
  }
}

}  // namespace
}  // namespace fricid::smc
