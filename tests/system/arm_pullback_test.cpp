// The reverse of a leap against dual numbers, and of a rollout against central differences.
#include "arm_pullback.hpp"

#include <gtest/gtest.h>

#include "algorithms_impl.hpp"
#include "dual.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/detail/kernels.hpp"
#include "kr6_truth.hpp"

namespace fricid::test {
namespace {

template <class S>
using Vector = std::vector<S>;

/// State, adjoint and parameters in one direction: what a pullback maps.
template <class S>
struct Point {
  Vector<S> q, v, z, pi, theta;

  explicit Point(const Arm& arm)
      : q(static_cast<std::size_t>(arm.robot.n()), S(0)),
        v(q),
        z(static_cast<std::size_t>(arm.friction.model.state_size()), S(0)),
        pi(static_cast<std::size_t>(arm.robot.parameter_count()), S(0)),
        theta(arm.friction.theta.size(), S(0)) {}
  std::array<Vector<S>*, 5> parts() { return {&q, &v, &z, &pi, &theta}; }
};

Point<double> random_point(const Arm& arm, std::uint64_t seed) {
  Point<double> x(arm);
  Rng rng(seed, 0);
  for (double& q : x.q) q = rng.normal();
  for (double& v : x.v) v = 0.5 * rng.normal();
  for (double& z : x.z) z = 1e-4 * rng.normal();
  x.pi.assign(arm.robot.pi.begin(), arm.robot.pi.end());
  x.theta = arm.friction.theta;
  return x;
}

Vector<double> random_torque(const Arm& arm, std::uint64_t seed) {
  Rng rng(seed, 1);
  Vector<double> tau(static_cast<std::size_t>(arm.robot.n()));
  for (double& x : tau) x = 20 * rng.normal();
  return tau;
}

/// The stepper on dual numbers: its state and parameters carry one direction.
class DualStepper {
 public:
  DualStepper(const Arm& arm, StepOptions options) : arm_(arm), stepper_(arm, options) {}

  Point<Dual> step(Point<Dual> x, const Vector<double>& tau, double dt) {
    const Vector<Dual> torque(tau.begin(), tau.end());
    const Vector<Dual> temperature(tau.size(), Dual(kRoomTemperature));
    stepper_.set_parameters(x.pi, x.theta);
    stepper_.step(torque, temperature, dt, x.q, x.v, x.z);
    return x;
  }

 private:
  const Arm& arm_;
  ArmStepper<Dual> stepper_;
};

/// bar' d step / d(every entry of q, v, z, pi, theta), by dual numbers.
Point<double> differentiate(const Arm& arm, StepOptions options, const Point<double>& at,
                            const Vector<double>& tau, const Point<double>& bar) {
  DualStepper stepper(arm, options);
  Point<Dual> x(arm);
  Point<double> from = at, gradient(arm);
  for (std::size_t p = 0; p < 5; ++p)
    for (std::size_t i = 0; i < x.parts()[p]->size(); ++i)
      (*x.parts()[p])[i] = Dual((*from.parts()[p])[i]);
  for (std::size_t p = 0; p < 5; ++p) {
    for (std::size_t i = 0; i < x.parts()[p]->size(); ++i) {
      Point<Dual> moved = x;
      (*moved.parts()[p])[i].d = 1;
      moved = stepper.step(moved, tau, kSamplePeriod);
      double sum = 0;
      for (std::size_t k = 0; k < bar.q.size(); ++k)
        sum += bar.q[k] * moved.q[k].d + bar.v[k] * moved.v[k].d;
      for (std::size_t k = 0; k < bar.z.size(); ++k) sum += bar.z[k] * moved.z[k].d;
      (*gradient.parts()[p])[i] = sum;
    }
  }
  return gradient;
}

/// The same by the reverse sweep.
template <class Stepper>
Point<double> pull_back(Stepper& stepper, const Point<double>& at, const Vector<double>& tau,
                        Point<double> bar) {
  const Vector<double> temperature(tau.size(), kRoomTemperature);
  Vector<Point<double>> states{at};
  for (int k = 1; k < stepper.leaps(); ++k) {
    states.push_back(states.back());
    auto& x = states.back();
    stepper.leap(tau, temperature, kSamplePeriod, x.q, x.v, x.z);
  }
  for (auto x = states.rbegin(); x != states.rend(); ++x)
    stepper.leap_pullback(tau, temperature, kSamplePeriod, x->q, x->v, x->z, bar.q, bar.v, bar.z,
                          bar.pi, bar.theta);
  return bar;
}

void expect_equal(Point<double> x, Point<double> y, double tolerance) {
  const std::array names{"q", "v", "z", "pi", "theta"};
  for (std::size_t p = 0; p < 5; ++p) {
    double largest = 0;
    for (const double value : *y.parts()[p]) largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < y.parts()[p]->size(); ++i)
      EXPECT_NEAR((*x.parts()[p])[i], (*y.parts()[p])[i], tolerance * largest)
          << names[p] << " " << i;
  }
}

class EveryLeap : public ::testing::TestWithParam<std::tuple<const char*, int>> {
 protected:
  Arm arm{hanging_kr6(), kr6_friction(std::get<0>(GetParam()))};
  StepOptions options{8, std::get<1>(GetParam())};
};
INSTANTIATE_TEST_SUITE_P(Laws, EveryLeap,
                         ::testing::Combine(::testing::Values("coulomb_viscous", "lugre", "gms",
                                                              "maxwell_slip"),
                                            ::testing::Values(1, 4, 8)));

TEST_P(EveryLeap, PullbackEqualsDualNumbers) {
  ArmStepper<double> stepper(arm, options);
  for (std::uint64_t seed = 0; seed < 5 && !HasFailure(); ++seed) {
    const Point<double> at = random_point(arm, seed);
    const Vector<double> tau = random_torque(arm, seed);
    Point<double> bar(arm);
    Rng rng(seed, 2);
    for (auto* part : {&bar.q, &bar.v, &bar.z})
      for (double& x : *part) x = rng.normal();
    expect_equal(pull_back(stepper, at, tau, bar), differentiate(arm, options, at, tau, bar),
                 1e-10);
  }
}

}  // namespace
}  // namespace fricid::test
