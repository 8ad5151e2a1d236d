// The descent itself, on problems small enough to know what it must do.
#include "fricid/optimise/descent.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fricid/base/parallel.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/optimise/adam.hpp"

namespace fricid::optimise {
namespace {

struct Point {
  Eigen::VectorXd at;
  const Eigen::VectorXd& c() const { return at; }
  void move_to(const Eigen::VectorXd& c) { at = c; }
};

/// A line through noisy points y = 2 x - 1, by Adam on random batches. The parts of a batch are
/// summed on up to `jobs` threads; held-out points are far more than the trained ones.
struct Line {
  int jobs = 1;
  Rng rng{1, 0};
  Adam adam{2};
  Box box{Eigen::Vector2d(-10, -10), Eigen::Vector2d(10, 10)};
  std::vector<int> prepared;  // iterations
  int begun = 0;

  void begin(const Point&) {
    ++begun;
    adam = Adam(2);
  }
  void prepare(int iteration, const Point&) { prepared.push_back(iteration); }
  double loss(const Point& point, Eigen::VectorXd& gradient) {
    constexpr int kParts = 8, kPoints = 4;
    double x[kParts * kPoints], y[kParts * kPoints], losses[kParts];
    Eigen::Vector2d gradients[kParts];
    for (int i = 0; i < kParts * kPoints; ++i) {
      x[i] = 2 * rng.uniform() - 1;
      y[i] = 2 * x[i] - 1 + 0.01 * rng.normal();
    }
    parallel_for(kParts, jobs, [&](int part) {
      losses[part] = 0;
      gradients[part].setZero();
      for (int i = part * kPoints; i < (part + 1) * kPoints; ++i) {
        const double e = point.at[0] * x[i] + point.at[1] - y[i];
        losses[part] += e * e / 2;
        gradients[part] += e * Eigen::Vector2d(x[i], 1);
      }
    });
    gradient = Eigen::Vector2d::Zero();
    double sum = 0;
    for (int part = 0; part < kParts; ++part) {
      gradient += gradients[part];
      sum += losses[part];
    }
    return sum;
  }
  std::pair<Eigen::VectorXd, bool> step(const Point& point, const Eigen::VectorXd& gradient,
                                        double rate) {
    Eigen::VectorXd c = point.at;
    const bool moved = adam.step(gradient, rate, Eigen::Vector2d::Ones(), box, c);
    return {c, moved};
  }
  double held_out(const Point& point) { return (point.at - Eigen::Vector2d(2, -1)).squaredNorm(); }
  std::string describe(double, double) const { return {}; }
};

TEST(Descent, FindsALineThroughNoise) {
  Line line;
  Point point{Eigen::Vector2d(0, 0)};
  const DescentHistory history =
      descend(line, point, {.iterations = 600, .rate = 0.05, .checks = 6}, "line");
  EXPECT_NEAR(point.at[0], 2, 0.02);
  EXPECT_NEAR(point.at[1], -1, 0.02);
  EXPECT_EQ(history.loss.size(), 600u);
  EXPECT_EQ(history.checked, (std::vector{0, 100, 200, 300, 400, 500, 600}));
  EXPECT_EQ(history.held_out[0], 5);
  EXPECT_EQ(history.best_held_out(), line.held_out(point));
  EXPECT_EQ(history.skipped + history.returns, 0);
  EXPECT_EQ(line.begun, 1);
  ASSERT_EQ(line.prepared.size(), 600u);
  EXPECT_EQ(line.prepared[599], 599);
}

TEST(Descent, IsTheSameForAnyNumberOfThreads) {
  DescentHistory histories[2];
  Point points[2];
  for (const int jobs : {1, 3}) {
    Line line;
    line.jobs = jobs;
    points[jobs / 2] = {Eigen::Vector2d(0, 0)};
    histories[jobs / 2] =
        descend(line, points[jobs / 2], {.iterations = 100, .rate = 0.05}, "line");
  }
  EXPECT_EQ(points[0].at, points[1].at);
  EXPECT_EQ(histories[0].loss, histories[1].loss);
  EXPECT_EQ(histories[0].held_out, histories[1].held_out);
}

/// Steps of the rate itself along one coordinate; the held-out error is a given function of it.
struct Walk {
  double (*error)(double);
  bool finite = true;
  std::vector<double> begun = {};  // where

  void begin(const Point& point) { begun.push_back(point.at[0]); }
  void prepare(int, const Point&) {}
  double loss(const Point& point, Eigen::VectorXd& gradient) {
    gradient.setConstant(1, 1);
    return point.at[0];
  }
  std::pair<Eigen::VectorXd, bool> step(const Point& point, const Eigen::VectorXd& gradient,
                                        double rate) {
    return {finite ? point.at + rate * gradient : point.at, finite};
  }
  double held_out(const Point& point) { return error(point.at[0]); }
  std::string describe(double, double) const { return {}; }
};

TEST(Descent, KeepsTheBestOnTheWayAndNotTheLast) {
  Walk walk{[](double x) { return 1 + std::abs(x - 3); }};
  Point point{Eigen::VectorXd::Zero(1)};
  const DescentHistory history =
      descend(walk, point, {.iterations = 5, .rate = 1, .checks = 5}, "walk");
  ASSERT_EQ(history.held_out.size(), 6u);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(history.held_out[k], 4 - static_cast<double>(k));
  EXPECT_GT(history.held_out[4], 1);
  EXPECT_EQ(history.best, 3);
  EXPECT_EQ(history.best_iteration(), 3);
  EXPECT_EQ(point.at[0], 3);
}

TEST(Descent, IsNoWorseThanItsStart) {
  Walk walk{[](double x) { return 1 + x; }};
  Point point{Eigen::VectorXd::Zero(1)};
  const DescentHistory history =
      descend(walk, point, {.iterations = 20, .rate = 1, .checks = 4}, "walk");
  EXPECT_EQ(history.best, 0);
  EXPECT_EQ(point.at[0], 0);
}

// Beyond 2.5 all is lost: each time the walk finds itself there it goes back to the best, 2, with
// steps 0.3 times as long, and its method begins anew.
TEST(Descent, GoesBackWhereItIsLostAndOnWithShorterSteps) {
  Walk walk{[](double x) { return x > 2.5 ? 1e6 : 5 - x; }};
  Point point{Eigen::VectorXd::Zero(1)};
  const DescentHistory history = descend(
      walk, point, {.iterations = 10, .rate = 1, .checks = 10, .lost = 3, .shorter = 0.3}, "walk");
  // 1, 2, lost; 2.3, lost (2.6); 2.39, and from here on also the schedule shortens
  EXPECT_EQ(history.returns, 2);
  ASSERT_EQ(walk.begun.size(), 3u);
  EXPECT_EQ(walk.begun[1], 2);
  EXPECT_NEAR(walk.begun[2], 2.3, 1e-12);
  EXPECT_GT(point.at[0], 2.38);
  EXPECT_LT(point.at[0], 2.5);

  Walk stubborn = walk;
  stubborn.begun.clear();
  point = {Eigen::VectorXd::Zero(1)};
  EXPECT_EQ(descend(stubborn, point, {.iterations = 10, .rate = 1, .checks = 10}, "walk").returns,
            0);
  EXPECT_EQ(stubborn.begun.size(), 1u);
  EXPECT_EQ(point.at[0], 2);
}

TEST(Descent, CountsWhatItSkips) {
  Walk walk{[](double x) { return 1 + x; }, false};
  Point point{Eigen::VectorXd::Zero(1)};
  EXPECT_EQ(descend(walk, point, {.iterations = 7}, "walk").skipped, 7);
}

TEST(StepLength, FallsTwice) {
  EXPECT_EQ(step_length(0, 1000), 1);
  EXPECT_EQ(step_length(599, 1000), 1);
  EXPECT_EQ(step_length(600, 1000), 0.3);
  EXPECT_EQ(step_length(850, 1000), 0.1);
}

}  // namespace
}  // namespace fricid::optimise
