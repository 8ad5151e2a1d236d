// The hand-written reverse sweep against dual numbers and central differences.
#include <gtest/gtest.h>

#include "algorithms_impl.hpp"
#include "dual.hpp"
#include "robots.hpp"

namespace fricid::dynamics::test {
namespace {

using fricid::test::Dual;

struct Gradient {
  VectorXd q, v, a, pi;
  explicit Gradient(const RobotModel& model)
      : q(VectorXd::Zero(model.n())), v(q), a(q), pi(VectorXd::Zero(model.parameter_count())) {}
};

Gradient pull_back(const RobotModel& model, const State& s, const VectorXd& lambda) {
  Workspace<double> ws(model);
  Gradient bar(model);
  rnea_pullback<double>(model, ws, view(model.pi), view(s.q), view(s.v), view(s.a), view(lambda),
                        view(bar.q), view(bar.v), view(bar.a), view(bar.pi));
  return bar;
}

/// d (lambda' rnea) along one entry of one input, by dual numbers.
Gradient differentiate(const RobotModel& model, const State& s, const VectorXd& lambda) {
  Workspace<Dual> ws(model);
  const auto lift = [](const VectorXd& x) { return std::vector<Dual>(x.begin(), x.end()); };
  auto pi = lift(model.pi), q = lift(s.q), v = lift(s.v), a = lift(s.a);
  std::vector<Dual> tau(q.size());
  Gradient gradient(model);
  const auto run = [&](std::vector<Dual>& x, VectorXd& out) {
    for (size_t i = 0; i < x.size(); ++i) {
      x[i].d = 1;
      rnea<Dual>(model, ws, pi, q, v, a, tau);
      x[i].d = 0;
      double sum = 0;
      for (size_t k = 0; k < tau.size(); ++k) sum += lambda(static_cast<int>(k)) * tau[k].d;
      out(static_cast<int>(i)) = sum;
    }
  };
  run(q, gradient.q);
  run(v, gradient.v);
  run(a, gradient.a);
  run(pi, gradient.pi);
  return gradient;
}

void expect_equal(const Gradient& x, const Gradient& y, double tol) {
  EXPECT_TRUE(close(x.q, y.q, tol)) << "q";
  EXPECT_TRUE(close(x.v, y.v, tol)) << "v";
  EXPECT_TRUE(close(x.a, y.a, tol)) << "a";
  EXPECT_TRUE(close(x.pi, y.pi, tol)) << "pi";
}

TEST(RneaPullback, EqualsDualNumbers) {
  for (const RobotModel& model : all_robots()) {
    for (int k = 0; k < 50 && !HasFailure(); ++k) {
      SCOPED_TRACE(testing::Message() << model.name << ", state " << k);
      const State s = random_state(model, k);
      expect_equal(pull_back(model, s, s.tau), differentiate(model, s, s.tau), 1e-12);
    }
  }
}

TEST(RneaPullback, EqualsDualNumbersOnAnyTree) {
  for (std::uint64_t seed = 0; seed < 200 && !HasFailure(); ++seed) {
    const RobotModel model = random_tree(1 + static_cast<int>(seed % 8), seed, seed % 3 == 0);
    SCOPED_TRACE(model.name);
    const State s = random_state(model, static_cast<int>(seed));
    expect_equal(pull_back(model, s, s.tau), differentiate(model, s, s.tau), 1e-11);
  }
}

TEST(RneaPullback, EqualsCentralDifferences) {
  constexpr double kStep = 1e-5;
  for (const RobotModel& model : all_robots()) {
    for (int k = 0; k < 20 && !HasFailure(); ++k) {
      SCOPED_TRACE(testing::Message() << model.name << ", state " << k);
      const State s = random_state(model, k);
      Gradient differences(model);
      const auto run = [&](VectorXd State::*member, VectorXd& out) {
        for (int i = 0; i < out.size(); ++i) {
          State plus = s, minus = s;
          (plus.*member)(i) += kStep;
          (minus.*member)(i) -= kStep;
          Robot robot(model);
          out(i) = s.tau.dot(robot.rnea(plus.q, plus.v, plus.a) -
                             robot.rnea(minus.q, minus.v, minus.a)) /
                   (2 * kStep);
        }
      };
      run(&State::q, differences.q);
      run(&State::v, differences.v);
      run(&State::a, differences.a);
      differences.pi = Robot(model).regressor(s.q, s.v, s.a).transpose() * s.tau;
      expect_equal(pull_back(model, s, s.tau), differences, 1e-7);
    }
  }
}

TEST(RneaPullback, AddsToWhatIsThereAndSkipsEmptyOutputs) {
  const RobotModel model = all_robots().back();
  const State s = random_state(model, 1);
  const Gradient bar = pull_back(model, s, s.tau);
  Workspace<double> ws(model);
  VectorXd q_bar = VectorXd::Constant(model.n(), 100);
  rnea_pullback<double>(model, ws, view(model.pi), view(s.q), view(s.v), view(s.a), view(s.tau),
                        view(q_bar), {}, {}, {});
  EXPECT_TRUE(close(q_bar, bar.q + VectorXd::Constant(model.n(), 100), 1e-14));
  VectorXd pi_bar = VectorXd::Constant(model.parameter_count(), -3);
  rnea_pullback<double>(model, ws, view(model.pi), view(s.q), view(s.v), view(s.a), view(s.tau), {},
                        {}, {}, view(pi_bar));
  EXPECT_TRUE(close(pi_bar, bar.pi - VectorXd::Constant(model.parameter_count(), 3), 1e-14));
}

// a = M^-1 (tau - h): with lambda = M^-1 a_bar the adjoints of q, v, pi are those of rnea, negated.
TEST(RneaPullback, GivesTheGradientOfForwardDynamics) {
  constexpr double kStep = 1e-6;
  const RobotModel model = load("kr6_r700/kr6_r700.urdf");
  Robot robot(model);
  for (int k = 0; k < 50; ++k) {
    State s = random_state(model, k);
    const VectorXd a_bar = s.a;
    s.a = robot.forward(s.q, s.v, s.tau);
    const VectorXd lambda = robot.solve(a_bar);
    const Gradient bar = pull_back(model, s, lambda);
    VectorXd slope(model.n());
    for (int i = 0; i < model.n(); ++i) {
      const VectorXd step = kStep * VectorXd::Unit(model.n(), i);
      slope(i) =
          a_bar.dot(robot.forward(s.q + step, s.v, s.tau) - robot.forward(s.q - step, s.v, s.tau)) /
          (2 * kStep);
    }
    EXPECT_TRUE(close(-bar.q, slope, 1e-6));
  }
}

}  // namespace
}  // namespace fricid::dynamics::test
