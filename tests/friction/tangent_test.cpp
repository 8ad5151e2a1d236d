// Sensitivities carried forward along a motion against dual numbers.
#include "fricid/friction/tangent.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "dual.hpp"
#include "fricid/friction/detail/kernels.hpp"
#include "fricid/friction/sum.hpp"

namespace fricid::friction {
namespace {

using fricid::test::Dual;

constexpr double kStep = 0.004;  // [s]
constexpr int kSteps = 700;

/// Slow and fast parts, reversals, two rests; another motion in every lane.
template <class S>
Input<S> motion(int k, double lane) {
  const double t = kStep * k + 0.3 * lane;
  const bool rests = k % 200 < 20;
  return {S(std::sin(t)), S(rests ? 0 : std::cos(3 * t) * std::cos(t) * (1 + 0.1 * lane)),
          S(30 * std::sin(2 * t)), S(293 + 5 * t)};
}

/// Typical values, each a little off.
std::vector<double> some_theta(const RobotFriction& model) {
  std::vector<double> theta = default_theta(model);
  for (std::size_t p = 0; p < theta.size(); ++p)
    theta[p] *= 1 + 0.1 * std::sin(3.0 * static_cast<double>(p) + 1);
  return theta;
}

/// d tau / d theta_p at every step of one lane.
std::vector<double> by_dual_numbers(const RobotFriction& model, const std::vector<double>& theta,
                                    std::size_t p, int lane) {
  std::vector<Dual> x(theta.begin(), theta.end());
  x[p].d = 1;
  std::vector<Dual> z(static_cast<std::size_t>(model.state_size()), Dual(0));
  std::vector<double> out;
  for (int k = 0; k < kSteps; ++k) {
    const auto in = motion<Dual>(k, lane);
    Dual tau;
    model.torque<Dual>(x, {&in, 1}, z, {&tau, 1});
    out.push_back(tau.d);
    model.step<Dual>(x, {&in, 1}, kStep, z);
  }
  return out;
}

/// (steps)(parameters), all lanes.
std::vector<std::vector<PackD>> by_tangent(const RobotFriction& model,
                                           const std::vector<double>& theta) {
  const std::vector<PackD> x(theta.begin(), theta.end());
  std::vector<PackD> z(static_cast<std::size_t>(model.state_size()), PackD(0)), z_bar = z;
  Tangent tangent(model);
  std::vector<std::vector<PackD>> out;
  const PackD one(1);
  for (int k = 0; k < kSteps; ++k) {
    Input<PackD> in{}, in_bar{};
    for (int lane = 0; lane < PackD::kLanes; ++lane) {
      const auto at = motion<double>(k, lane);
      in.q.set(lane, at.q);
      in.v.set(lane, at.v);
      in.load.set(lane, at.load);
      in.temperature.set(lane, at.temperature);
    }
    std::fill(z_bar.begin(), z_bar.end(), PackD(0));
    out.emplace_back(theta.size(), PackD(0));
    model.torque_pullback<PackD>(x, {&in, 1}, z, {&one, 1}, out.back(), {&in_bar, 1}, z_bar);
    tangent.add(x, z_bar, out.back());
    tangent.step(x, {&in, 1}, kStep, z);
  }
  return out;
}

TEST(Tangent, EqualsDualNumbersAlongAMotion) {
  const std::vector<JointSpec> joints{
      lvm_sum({.memory = Memory::kBank, .elements = 4, .temperature = true}),
      lvm_sum({.memory = Memory::kBristle, .temperature = true}),
      lvm_sum({.memory = Memory::kNone, .network = 3}),
      lvm_sum({.memory = Memory::kBank, .elements = 4, .ripples = 2, .backlash = true}),
      lvm_sum({.memory = Memory::kBristle, .temperature = true, .backlash = true}),
      lvm_sum({.memory = Memory::kNone, .backlash = true}),
      {{{"dahl", 0, {{"asymmetry", 1}}}, {"gms", 2, {}}}}};
  for (const JointSpec& joint : joints) {
    SCOPED_TRACE(joint.laws[0].law);
    const RobotFriction model({joint});
    ASSERT_TRUE(Tangent::is_known(model));
    const std::vector<double> theta = some_theta(model);
    const auto found = by_tangent(model, theta);
    for (std::size_t p = 0; p < theta.size(); ++p)
      for (const int lane : {0, PackD::kLanes - 1}) {
        const std::vector<double> wanted = by_dual_numbers(model, theta, p, lane);
        double size = 0, error = 0;
        for (int k = 0; k < kSteps; ++k) {
          const auto i = static_cast<std::size_t>(k);
          size = std::max(size, std::abs(wanted[i]));
          error = std::max(error, std::abs(found[i][p][lane] - wanted[i]));
        }
        EXPECT_LE(error, 1e-10 * size)
            << model.parameters()[p].owner << "." << model.parameters()[p].symbol;
      }
  }
}

TEST(Tangent, IsNotKnownOfWhatDoesNotSayHow) {
  EXPECT_TRUE(Tangent::is_known(RobotFriction({JointSpec{{{"maxwell_slip", 1, {}}}}})));
  EXPECT_FALSE(Tangent::is_known(RobotFriction({JointSpec{{{"maxwell_slip", 2, {}}}}})));
  EXPECT_FALSE(Tangent::is_known(RobotFriction({JointSpec{{{"neural", 8, {}}}}})));
  EXPECT_FALSE(Tangent::is_known(
      RobotFriction({JointSpec{{{"prandtl_ishlinskii", 4, {{"backlash", 1}}}}}})));
  EXPECT_FALSE(Tangent::is_known(RobotFriction(std::vector<JointSpec>(2), {"nn", 8})));
}

}  // namespace
}  // namespace fricid::friction
