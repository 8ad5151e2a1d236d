// Levenberg-Marquardt on problems whose minimum is known.
#include "fricid/optimise/damped_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fricid::optimise {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

Box wide(Eigen::Index size, double bound = 100) {
  return {Eigen::VectorXd::Constant(size, -bound), Eigen::VectorXd::Constant(size, bound)};
}

/// Rosenbrock's valley (Computer J. 3(3), 1960) as half the squares of (10 (y - x^2), 1 - x):
/// least, 0, at (1, 1).
struct Rosenbrock {
  static Eigen::Vector2d residual(const Eigen::VectorXd& c) {
    return {10 * (c[1] - c[0] * c[0]), 1 - c[0]};
  }
  static double value(const Eigen::VectorXd& c) { return 0.5 * residual(c).squaredNorm(); }
  static Quadratic linearise(const Eigen::VectorXd& c, double) {
    Eigen::Matrix2d J;
    J << -20 * c[0], 10, -1, 0;
    return {value(c), J.transpose() * residual(c), J.transpose() * J};
  }
};

TEST(DampedLeastSquares, WalksRosenbrocksValleyToItsEnd) {
  for (const double first : {1e-9, 1e-3, 1e3}) {
    LeastSquaresOptions options;
    options.damping.first = first;
    options.damping.attempts = 20;
    options.iterations = 200;
    options.smallest_gain = 1e-9;
    const Minimum found = damped_least_squares(&Rosenbrock::linearise, &Rosenbrock::value, wide(2),
                                               {Eigen::Vector2d(-1.2, 1), kUnknown}, options);
    EXPECT_TRUE(found.converged) << first;
    EXPECT_NEAR(found.c[0], 1, 1e-6) << first;
    EXPECT_NEAR(found.c[1], 1, 1e-6) << first;
    EXPECT_LT(found.value, 1e-12) << first;
    EXPECT_EQ(found.value, Rosenbrock::value(found.c));
    EXPECT_GT(found.values, 0);
  }
}

TEST(DampedLeastSquares, SaysWhenItRanOutOfSteps) {
  LeastSquaresOptions options;
  options.iterations = 2;
  const Minimum found = damped_least_squares(&Rosenbrock::linearise, &Rosenbrock::value, wide(2),
                                             {Eigen::Vector2d(-1.2, 1), kUnknown}, options);
  EXPECT_FALSE(found.converged);
  EXPECT_LT(found.value, Rosenbrock::value(Eigen::Vector2d(-1.2, 1)));
}

TEST(DampedLeastSquares, EndsWhereTheObjectiveIsNotFinite) {
  const auto nowhere = [](const Eigen::VectorXd&, double) {
    return Quadratic{0, Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Constant(1, 1, kUnknown)};
  };
  const Minimum found = damped_least_squares(nowhere, [](const Eigen::VectorXd&) { return 0.0; },
                                             wide(1), {Eigen::VectorXd::Constant(1, 0.3), 0}, {});
  EXPECT_FALSE(found.converged);
  EXPECT_EQ(found.c[0], 0.3);
  EXPECT_EQ(found.values, 0);
}

/// |c - wanted|_A^2 / 2 with correlated coordinates.
struct Bowl {
  Eigen::Matrix2d A = (Eigen::Matrix2d() << 2, 1, 1, 3).finished();
  Eigen::Vector2d wanted{2, -1};
  double value(const Eigen::VectorXd& c) const { return 0.5 * (c - wanted).dot(A * (c - wanted)); }
  Quadratic at(const Eigen::VectorXd& c) const { return {value(c), A * (c - wanted), A}; }
};

// Closed form: with the first coordinate held at its bound the second is least at
// wanted_1 - A_10 / A_11 (bound - wanted_0).
TEST(DampedLeastSquares, FindsTheLeastPointOfTheBox) {
  const Bowl bowl;
  const Box box{Eigen::Vector2d(-5, -5), Eigen::Vector2d(0.5, 5)};
  LeastSquaresOptions options;
  options.damping.hold_at_bounds = true;
  options.damping.longest = 10;
  options.smallest_gain = 1e-14;
  const Minimum found =
      damped_least_squares([&](const Eigen::VectorXd& c, double) { return bowl.at(c); },
                           [&](const Eigen::VectorXd& c) { return bowl.value(c); }, box,
                           {Eigen::Vector2d(-3, 3), kUnknown}, options);
  EXPECT_EQ(found.c[0], 0.5);
  EXPECT_NEAR(found.c[1], -1 - 1.0 / 3 * (0.5 - 2), 1e-6);
}

TEST(DampedStep, IsNewtonsWhereNothingDampsIt) {
  const Bowl bowl;
  DampingOptions options;
  options.longest = 100;
  Eigen::VectorXd c = Eigen::Vector2d(-3, 3);
  double lambda = 1e-14, value = 0;
  const Step step = damped_step(
      bowl.at(c), wide(2), options, [&](const Eigen::VectorXd& x) { return bowl.value(x); }, lambda,
      c, value);
  EXPECT_TRUE(step.lowered);
  EXPECT_EQ(step.values, 1);
  EXPECT_NEAR((c - bowl.wanted).norm(), 0, 1e-12);
  EXPECT_EQ(value, bowl.value(c));
  EXPECT_EQ(lambda, options.least);
}

TEST(DampedStep, MovesNoCoordinateFurtherThanItMay) {
  const Bowl bowl;
  Eigen::VectorXd c = Eigen::Vector2d(-30, 30);
  double lambda = 1e-3, value = 0;
  damped_step(
      bowl.at(c), wide(2), {}, [&](const Eigen::VectorXd& x) { return bowl.value(x); }, lambda, c,
      value);
  EXPECT_NEAR(c[0], -29.7, 1e-12);
  EXPECT_NEAR(c[1], 29.7, 1e-12);
}

TEST(DampedStep, ShortensAStepAsAWholeWhereItKeepsItsDirection) {
  const Bowl bowl;
  DampingOptions options;
  options.keep_direction = true;
  const Eigen::VectorXd start = Eigen::Vector2d(-30, 10);
  Eigen::VectorXd c = start;
  double lambda = 1e-14, value = 0;
  damped_step(
      bowl.at(c), wide(2), options, [&](const Eigen::VectorXd& x) { return bowl.value(x); }, lambda,
      c, value);
  const Eigen::VectorXd step = c - start, wanted = bowl.wanted - start;
  EXPECT_NEAR(step.cwiseAbs().maxCoeff(), options.longest, 1e-12);
  EXPECT_NEAR(step[0] * wanted[1] - step[1] * wanted[0], 0, 1e-9);
}

TEST(DampedStep, SolvesForTheOthersWhereOneMeetsItsBound) {
  const Bowl bowl;
  Box box = wide(2);
  box.upper[0] = 0.5;
  DampingOptions options;
  options.longest = 100;
  options.hold_at_bounds = true;
  for (const bool keeps : {false, true}) {
    options.keep_direction = keeps;
    Eigen::VectorXd c = Eigen::Vector2d(-3, 3);
    double lambda = 1e-14, value = 0;
    damped_step(
        bowl.at(c), box, options, [&](const Eigen::VectorXd& x) { return bowl.value(x); }, lambda,
        c, value);
    EXPECT_EQ(c[0], 0.5);
    EXPECT_NEAR(c[1], -1 - 1.0 / 3 * (0.5 - 2), 1e-12);
  }
}

TEST(DampedStep, TrustsTheModelByTheShareOfTheGainThatCame) {
  const Bowl bowl;
  const Eigen::VectorXd start = Eigen::Vector2d(-3, 3);
  const Quadratic here = bowl.at(start);
  const auto lambda_after = [&](double share) {
    Eigen::VectorXd c = start;
    double lambda = 1e-3, value = 0;
    const auto objective = [&](const Eigen::VectorXd& x) {
      const Eigen::VectorXd s = x - start;
      return here.value + share * (here.g.dot(s) + 0.5 * s.dot(here.H * s));
    };
    damped_step(here, wide(2), {}, objective, lambda, c, value);
    return lambda;
  };
  EXPECT_NEAR(lambda_after(0.1), 3e-3, 1e-15);
  EXPECT_NEAR(lambda_after(0.5), 1e-3, 1e-15);
  EXPECT_NEAR(lambda_after(0.9), 2e-4, 1e-15);
}

// The gradient lies: no step lowers the objective. Everything stays, only lambda has risen.
TEST(DampedStep, StaysWhereNoStepHelps) {
  const Bowl bowl;
  const Eigen::VectorXd start = Eigen::Vector2d(1, 1);
  Quadratic lie = bowl.at(start);
  lie.g = -lie.g;
  Eigen::VectorXd c = start;
  double lambda = 1e-3, value = -7;
  int asked = 0;
  const Step step = damped_step(
      lie, wide(2), {},
      [&](const Eigen::VectorXd& x) {
        ++asked;
        return bowl.value(x);
      },
      lambda, c, value);
  EXPECT_FALSE(step.lowered);
  EXPECT_EQ(step.values, 5);
  EXPECT_EQ(asked, 5);
  EXPECT_EQ(c, start);
  EXPECT_EQ(value, -7);
  EXPECT_NEAR(lambda, 100, 1e-9);
}

}  // namespace
}  // namespace fricid::optimise
