#include "fricid/estimate/coordinates.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/not_finite.hpp"
#include "fricid/dynamics/physical_inertia.hpp"

namespace fricid::estimate {
namespace {

constexpr double kSmallestArmature = 1e-6;  // [kg m^2]
constexpr double kWaveNumber = 0.1;  // [1/rad] size of a change that shifts a wave over the travel
constexpr double kLinearTorqueShare = 0.02;  // of the joint's torque: size of a linear torque

dynamics::Vector10 link(const Eigen::VectorXd& pi, int i) { return pi.segment<10>(10 * i); }

}  // namespace

ArmCoordinates::ArmCoordinates(const Arm& arm, const CoordinateOptions& options) {
  std::vector<double> start, rate, lower, upper;
  const auto add = [&](Scalar scalar, double value, double low, double high, double r) {
    const auto to_c = [&](double x) { return scalar.logarithmic ? std::log(x) : x / scalar.scale; };
    scalars_.push_back(scalar);
    start.push_back(std::clamp(to_c(value), to_c(low), to_c(high)));
    lower.push_back(to_c(low));
    upper.push_back(to_c(high));
    rate.push_back(r);
  };

  const auto& infos = arm.friction.model.parameters();
  const std::vector<double> rates =
      friction::training_rates(arm.friction.model, arm.friction.theta);
  for (int p = 0; p < static_cast<int>(infos.size()); ++p) {
    const friction::ParameterRef& parameter = infos[static_cast<std::size_t>(p)];
    const friction::ParameterInfo& info = parameter.info;
    if (info.scale == friction::Scale::kFixed) continue;
    double lowest = info.lower, limit = info.upper;
    for (const Limit& narrow : options.limits)
      if (narrow.parameter == static_cast<std::size_t>(p)) {
        lowest = std::max(lowest, narrow.lower);
        limit = std::min(limit, narrow.upper);
      }
    if (lowest >= limit) continue;
    const double value = arm.friction.theta[static_cast<std::size_t>(p)];
    // zero says nothing about size; what has no typical size, as a network's weights, is of order
    // one
    const double typical = info.typical == 0 ? 1 : std::abs(info.typical);
    const double size = info.role == friction::Role::kWaveNumber ? kWaveNumber
                        : value == 0                             ? typical
                        : info.typical == 0                      ? 1
                                            : std::max(std::abs(value), 0.1 * typical);
    const bool bounded = info.role == friction::Role::kStiffness && !options.stiffest.empty();
    const double highest =
        bounded ? std::min(limit, options.stiffest[static_cast<std::size_t>(parameter.joint)])
                : limit;
    add({p, false, info.scale == friction::Scale::kLog, size}, value, lowest, highest,
        rates[static_cast<std::size_t>(p)]);
    friction_.push_back(static_cast<std::size_t>(p));
  }
  const dynamics::RobotModel& robot = arm.robot;
  const int n = robot.n();
  if (options.rigid_body) {
    for (int j = 0; j < n; ++j)
      add({robot.armature_begin() + j, true, true, 1},
          std::max(robot.pi[robot.armature_begin() + j], kSmallestArmature), kSmallestArmature,
          kInfinity, options.rigid_rate);
    for (int k = 0; k < static_cast<int>(robot.linear_torques.size()); ++k) {
      const auto joint =
          static_cast<std::size_t>(robot.linear_torques[static_cast<std::size_t>(k)].joint);
      const double torque = options.torque_scale.empty() ? 1 : options.torque_scale[joint];
      add({robot.linear_begin() + k, true, false, kLinearTorqueShare * torque},
          robot.pi[robot.linear_begin() + k], -kInfinity, kInfinity, 1);
    }
    links_ = n;
  }
  const auto scalars = static_cast<Eigen::Index>(start.size());
  const Eigen::Index size = scalars + 10 * links_;
  start_.resize(size);
  rate_ = Eigen::VectorXd::Constant(size, options.rigid_rate);
  box_.lower = Eigen::VectorXd::Constant(size, -kInfinity);
  box_.upper = Eigen::VectorXd::Constant(size, kInfinity);
  const auto view = [&](const std::vector<double>& x) {
    return Eigen::Map<const Eigen::VectorXd>(x.data(), scalars);
  };
  start_.head(scalars) = view(start);
  rate_.head(scalars) = view(rate);
  box_.lower.head(scalars) = view(lower);
  box_.upper.head(scalars) = view(upper);
  for (int i = 0; i < links_; ++i)
    start_.segment<10>(scalars + 10 * i) = dynamics::log_cholesky_from_inertia(link(robot.pi, i));
}

void ArmCoordinates::apply(const Eigen::VectorXd& c, Arm& arm) const {
  for (std::size_t i = 0; i < scalars_.size(); ++i) {
    const Scalar& s = scalars_[i];
    const double x = c[static_cast<Eigen::Index>(i)];
    const double value = s.logarithmic ? std::exp(x) : s.scale * x;
    if (s.in_pi) {
      arm.robot.pi[s.parameter] = value;
    } else {
      const auto p = static_cast<std::size_t>(s.parameter);
      const friction::ParameterInfo& info = arm.friction.model.parameters()[p].info;
      arm.friction.theta[p] = std::clamp(value, info.lower, info.upper);
    }
  }
  const auto scalars = static_cast<Eigen::Index>(scalars_.size());
  for (int i = 0; i < links_; ++i)
    arm.robot.pi.segment<10>(10 * i) =
        dynamics::inertia_from_log_cholesky(c.segment<10>(scalars + 10 * i));
}

Eigen::MatrixXd ArmCoordinates::jacobian(const Eigen::VectorXd& c, Eigen::Index pi_size,
                                         Eigen::Index theta_size) const {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(pi_size + theta_size, size());
  for (std::size_t i = 0; i < scalars_.size(); ++i) {
    const Scalar& s = scalars_[i];
    const auto k = static_cast<Eigen::Index>(i);
    J(s.in_pi ? s.parameter : pi_size + s.parameter, k) = s.logarithmic ? std::exp(c[k]) : s.scale;
  }
  const auto scalars = static_cast<Eigen::Index>(scalars_.size());
  Eigen::Matrix<double, 10, 10> link;
  for (int i = 0; i < links_; ++i) {
    dynamics::inertia_from_log_cholesky(c.segment<10>(scalars + 10 * i), &link);
    J.block<10, 10>(10 * i, scalars + 10 * i) = link;
  }
  return J;
}

void ArmCoordinates::pull_back(const Eigen::VectorXd& c, const Eigen::VectorXd& pi_bar,
                               const Eigen::VectorXd& theta_bar, Eigen::VectorXd& c_bar) const {
  c_bar.resize(size());
  for (std::size_t i = 0; i < scalars_.size(); ++i) {
    const Scalar& s = scalars_[i];
    const auto k = static_cast<Eigen::Index>(i);
    const double slope = s.logarithmic ? std::exp(c[k]) : s.scale;
    c_bar[k] = slope * (s.in_pi ? pi_bar : theta_bar)[s.parameter];
  }
  const auto scalars = static_cast<Eigen::Index>(scalars_.size());
  Eigen::Matrix<double, 10, 10> link;
  for (int i = 0; i < links_; ++i) {
    dynamics::inertia_from_log_cholesky(c.segment<10>(scalars + 10 * i), &link);
    c_bar.segment<10>(scalars + 10 * i) = link.transpose() * pi_bar.segment<10>(10 * i);
  }
}

}  // namespace fricid::estimate
