#include "fricid/evaluate/intervals.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/friction/modifiers/temperature.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kQuantile = 1.645;  // of a normal distribution, 90 % in the middle

/// The standard parameters of `truth` in the order of `model`; none if it has one that `model`
/// lacks.
std::optional<Eigen::VectorXd> pi_in_order_of(const dynamics::RobotModel& model,
                                              const dynamics::RobotModel& truth) {
  const std::vector<std::string> names = model.parameter_names(), known = truth.parameter_names();
  Eigen::VectorXd pi = Eigen::VectorXd::Zero(model.parameter_count());
  for (std::size_t i = 0; i < known.size(); ++i) {
    const auto place = std::ranges::find(names, known[i]);
    const double value = truth.pi[static_cast<Eigen::Index>(i)];
    if (place != names.end())
      pi[place - names.begin()] = value;
    else if (value != 0)
      return {};
  }
  return pi;
}

bool is_same(const friction::LawSpec& a, const friction::LawSpec& b) {
  const auto same = [](const friction::ModifierSpec& x, const friction::ModifierSpec& y) {
    return x.name == y.name && x.order == y.order;
  };
  return a.law == b.law && a.elements == b.elements &&
         std::ranges::equal(a.modifiers, b.modifiers, same);
}

const friction::LawSpec& law_of(const friction::RobotFriction& friction,
                                const friction::ParameterRef& parameter) {
  return friction.joints()[static_cast<std::size_t>(parameter.joint)]
      .laws[static_cast<std::size_t>(parameter.law)];
}

/// Whether a parameter is that of one of several elements.
bool is_of_element(const friction::RobotFriction& friction, const friction::ParameterRef& of) {
  using enum friction::Role;
  const bool may_be =
      of.info.role == kStiffness || of.info.role == kLevel || of.info.role == kShare;
  return may_be && law_of(friction, of).elements > 1;
}

/// A parameter of the temperature of a law; NaN where it does not depend on it.
double of_temperature(const friction::Friction& friction, const friction::ParameterRef& of,
                      friction::Role role) {
  const std::vector<friction::ParameterRef>& parameters = friction.model.parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (const friction::ParameterRef& p = parameters[i]; p.joint == of.joint && p.law == of.law &&
                                                         p.owner == friction::Temperature::kName &&
                                                         p.info.role == role)
      return friction.theta[i];
  return std::nan("");
}

/// The true value of a parameter; none where the truth has another law there. Torques of a law
/// under temperature are those at the reference temperature of `friction`, which no log determines.
std::optional<double> true_value(const friction::Friction& fitted,
                                 const friction::ParameterRef& parameter,
                                 const friction::Friction& truth) {
  const friction::RobotFriction& friction = fitted.model;
  if (parameter.joint == friction::kWholeRobot) return {};
  const auto& parameters = truth.model.parameters();
  const auto same = std::ranges::find_if(parameters, [&](const friction::ParameterRef& other) {
    return friction::is_same(parameter, other);
  });
  if (same == parameters.end() || !is_same(law_of(friction, parameter), law_of(truth.model, *same)))
    return {};
  const double value = truth.theta[static_cast<std::size_t>(same - parameters.begin())];
  using enum friction::Role;
  const double warmer =
      of_temperature(fitted, parameter, kTemperature) - of_temperature(truth, *same, kTemperature);
  const bool is_torque = parameter.info.unit.starts_with("N m");
  return is_torque && std::isfinite(warmer)
             ? value * std::exp(-of_temperature(truth, *same, kTemperatureCoefficient) * warmer)
             : value;
}

/// theta with the shares of every law summing to one.
std::vector<double> with_unit_shares(const friction::Friction& friction) {
  std::vector<double> theta = friction.theta;
  const std::vector<double> sums = friction::sums_of_shares(friction);
  for (std::size_t i = 0; i < theta.size(); ++i) theta[i] /= sums[i];
  return theta;
}

}  // namespace

void IntervalCount::add(double error, double standard_error) {
  if (!(standard_error > 0)) return;  // none is stated
  ++stated;
  hold += std::abs(error) < kQuantile * standard_error;
}

void IntervalCount::add(const IntervalCount& other) {
  stated += other.stated;
  hold += other.hold;
}

void ParameterIntervals::add(const ParameterIntervals& other) {
  base.add(other.base);
  friction.add(other.friction);
  elements.add(other.elements);
}

ParameterIntervals count_intervals(const data::ModelFile& model, const data::FitFile& fit,
                                   const Arm& truth) {
  ParameterIntervals intervals;
  const dynamics::RobotModel& robot = model.arm.robot;
  const std::vector<data::FittedBaseParameter>& found = fit.rigid_body.base;
  const dynamics::BaseParameters base = dynamics::base_parameters(robot);
  if (const auto pi = pi_in_order_of(robot, truth.robot)) {
    const Eigen::VectorXd value = base.K * *pi;
    for (std::size_t i = 0; i < std::min(found.size(), base.names.size()); ++i)
      if (found[i].name == base.names[i])
        intervals.base.add(found[i].value - value[static_cast<Eigen::Index>(i)],
                           found[i].standard_error);
  }
  const friction::RobotFriction& friction = model.arm.friction.model;
  const friction::Friction true_friction{truth.friction.model, with_unit_shares(truth.friction)};
  const std::vector<double> theta = with_unit_shares(model.arm.friction),
                            sums = friction::sums_of_shares(model.arm.friction);
  for (int i = 0; i < friction.parameter_count(); ++i) {
    const data::FittedParameter* parameter = data::fitted_parameter(fit, friction, i);
    if (parameter == nullptr) continue;
    const friction::ParameterRef& place = friction.parameters()[static_cast<std::size_t>(i)];
    const std::optional<double> value = true_value(model.arm.friction, place, true_friction);
    if (!value) continue;
    const auto p = static_cast<std::size_t>(i);
    double error = theta[p] - *value;
    if (place.info.role == friction::Role::kPhase)
      error = std::remainder(error, 2 * std::numbers::pi);
    intervals.friction.add(error, parameter->standard_error / sums[p]);
    if (is_of_element(friction, place))
      intervals.elements.add(error, parameter->standard_error / sums[p]);
  }
  return intervals;
}

}  // namespace fricid::evaluate
