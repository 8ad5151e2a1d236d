#include "fricid/evaluate/intervals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fricid/base/not_finite.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "kr6_truth.hpp"

namespace fricid::evaluate {
namespace {

struct Fitted {
  data::ModelFile model;
  data::FitFile fit;
};

/// The model of `arm` and a fit that states `error` for every parameter.
Fitted stated(const Arm& arm, double error) {
  Fitted out;
  out.model.arm = arm;
  const dynamics::BaseParameters base = dynamics::base_parameters(arm.robot);
  const Eigen::VectorXd value = base.K * arm.robot.pi;
  for (std::size_t i = 0; i < base.names.size(); ++i)
    out.fit.rigid_body.base.push_back({.name = base.names[i],
                                       .verdict = "identified",
                                       .value = value[static_cast<Eigen::Index>(i)],
                                       .standard_error = error,
                                       .physical = 0});
  const friction::RobotFriction& friction = arm.friction.model;
  for (int j = 0; j < arm.robot.n(); ++j) {
    data::FittedJoint& joint = out.fit.joints.emplace_back();
    for (int i = friction.parameter_begin(j); i < friction.parameter_begin(j + 1); ++i) {
      const auto p = static_cast<std::size_t>(i);
      joint.parameters.push_back(
          {friction.parameters()[p].symbol, arm.friction.theta[p], error, {}});
    }
  }
  return out;
}

Arm kr6(const char* law) { return {test::hanging_kr6(), test::kr6_friction(law)}; }

TEST(Intervals, HoldTheTruthWithinTheirErrors) {
  const Arm truth = kr6("lugre");
  Fitted of = stated(truth, 0.1);
  const auto base = static_cast<int>(of.fit.rigid_body.base.size());
  const int friction = truth.friction.model.parameter_count();
  ParameterIntervals all = count_intervals(of.model, of.fit, truth);
  EXPECT_EQ(all.base.stated, base);
  EXPECT_EQ(all.base.hold, base);
  EXPECT_EQ(all.friction.stated, friction);
  EXPECT_EQ(all.friction.hold, friction);

  of.fit.rigid_body.base[3].value += 0.17;
  of.fit.rigid_body.base[4].value += 0.16;
  of.fit.rigid_body.base[5].standard_error = kNan;
  of.model.arm.friction
      .theta[static_cast<std::size_t>(truth.friction.model.parameter_begin(2) + 1)] -= 0.17;
  of.fit.joints[2].parameters[0].standard_error = kNan;
  const ParameterIntervals some = count_intervals(of.model, of.fit, truth);
  EXPECT_EQ(some.base.stated, base - 1);
  EXPECT_EQ(some.base.hold, base - 2);
  EXPECT_EQ(some.friction.stated, friction - 1);
  EXPECT_EQ(some.friction.hold, friction - 2);
  all.add(some);
  EXPECT_EQ(all.friction.stated, 2 * friction - 1);
  EXPECT_EQ(all.elements.stated, 0);  // one bristle is no bank
}

TEST(Intervals, OfElementsOfABankAreCountedApartToo) {
  const Arm truth = kr6("gms");
  Fitted of = stated(truth, 0.1);
  int elements = 0;
  for (const friction::ParameterRef& p : truth.friction.model.parameters())
    elements += p.info.role == friction::Role::kStiffness || p.info.role == friction::Role::kShare;
  ASSERT_GT(elements, 0);
  const ParameterIntervals all = count_intervals(of.model, of.fit, truth);
  EXPECT_EQ(all.elements.stated, elements);
  EXPECT_GT(all.friction.stated, elements);
}

// A model that finds constant torques beside has a truth without any.
TEST(Intervals, OfAnotherLawAreThoseOfTheRigidBodyAlone) {
  Arm model = kr6("dahl");
  dynamics::add_linear_torque(model.robot, {"offset", 1, {}, 1}, 0);
  const Fitted of = stated(model, 0.1);
  const ParameterIntervals some = count_intervals(of.model, of.fit, kr6("lugre"));
  EXPECT_EQ(some.base.hold, std::ssize(of.fit.rigid_body.base));
  EXPECT_EQ(some.friction.stated, 0);
}

TEST(Intervals, OfABodyWithAnotherTorqueAreNotCounted) {
  Arm truth = kr6("lugre");
  dynamics::add_linear_torque(truth.robot, {"balance", 1, dynamics::LinearTorque::Shape::kSin, 1},
                              20);
  const Fitted of = stated(kr6("lugre"), 0.1);
  EXPECT_EQ(count_intervals(of.model, of.fit, truth).base.stated, 0);
}

TEST(Intervals, PhasesAreTheSameAfterATurn) {
  Arm truth = kr6("dahl");
  const friction::JointSpec joint{{{"dahl", 0, {{"ripple", 1}}}}};
  truth.friction.model = friction::RobotFriction(std::vector(6, joint));
  truth.friction.theta = friction::default_theta(truth.friction.model);
  Fitted of = stated(truth, 0.01);
  for (int j = 0; j < 6; ++j) {
    const int i = friction::find_parameter(truth.friction.model, j, friction::Role::kPhase);
    of.model.arm.friction.theta[static_cast<std::size_t>(i)] += 2 * std::numbers::pi;
  }
  const ParameterIntervals all = count_intervals(of.model, of.fit, truth);
  EXPECT_EQ(all.friction.hold, all.friction.stated);
}

// A law that is fitted at another reference temperature has other torques there, and is the same.
TEST(Intervals, TorquesUnderTemperatureAreThoseAtTheReferenceOfTheFit) {
  Arm truth = kr6("dahl");
  const friction::JointSpec joint{{{"dahl", 0, {{"temperature", 0}}}}};
  truth.friction.model = friction::RobotFriction(std::vector(6, joint));
  truth.friction.theta = friction::default_theta(truth.friction.model);
  const double warmer = 10, beta = 0.02;
  const auto& parameters = truth.friction.model.parameters();
  Arm fitted = truth;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].symbol == "beta") truth.friction.theta[i] = beta;
    if (parameters[i].symbol == "beta") fitted.friction.theta[i] = beta;
    if (parameters[i].symbol == "T0") fitted.friction.theta[i] += warmer;
    if (parameters[i].owner == "dahl") fitted.friction.theta[i] *= std::exp(-beta * warmer);
  }
  Fitted of = stated(fitted, 1e-6);
  for (data::FittedJoint& fit : of.fit.joints)
    std::erase_if(fit.parameters, [](const data::FittedParameter& p) { return p.symbol == "T0"; });
  const ParameterIntervals all = count_intervals(of.model, of.fit, truth);
  EXPECT_EQ(all.friction.stated, 6 * 4);
  EXPECT_EQ(all.friction.hold, all.friction.stated);
}

// Only the ratios of the shares of a bank count.
TEST(Intervals, SharesOfABankAreThoseOfTheirSum) {
  const Arm truth = kr6("gms");
  Fitted of = stated(truth, 0.01);
  for (const std::vector<std::size_t>& law : friction::shares(truth.friction.model))
    for (const std::size_t i : law) of.model.arm.friction.theta[i] *= 3;
  const ParameterIntervals all = count_intervals(of.model, of.fit, truth);
  EXPECT_EQ(all.friction.hold, all.friction.stated);
}

}  // namespace
}  // namespace fricid::evaluate
