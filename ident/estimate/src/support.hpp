// Small things that the sources of estimate share.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/estimate/options/model.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::estimate {

/// Least sigma of a joint, share of the root mean square of its torque: data without noise stay
/// solvable.
inline constexpr double kSmallestSigma = 1e-9;

/// Modifiers by name, each of the first order.
inline std::vector<friction::ModifierSpec> modifiers_of(const std::vector<std::string>& names) {
  std::vector<friction::ModifierSpec> modifiers;
  for (const std::string& name : names) modifiers.push_back({name, 1});
  return modifiers;
}

/// Mean and standard deviation of the temperature of all joints [K].
struct Temperatures {
  double mean = 0, sd = 0;
};
Temperatures temperatures_of(std::span<const signals::Recording> recordings);

/// Root mean square of the filtered torque per joint (n) [N m].
Eigen::VectorXd filtered_torque_rms(std::span<const signals::Recording> recordings);

/// Whether a torque was measured beyond the gear, where its rotor and its friction are not.
bool is_beyond_gear(std::span<const signals::Recording> recordings);

/// How often a velocity changes its direction, speeds below `least` being neither.
int reversals_in(const Eigen::Ref<const Eigen::VectorXd, 0, Eigen::InnerStride<>>& v, double least);

/// The friction of one joint that a scene asks for: a sum, a law of the table or its short name.
/// @throws UserError on a name that is no law
friction::JointSpec joint_spec_of(const ModelOptions& options);

/// Where the search for a law begins: the linear friction of the regression, a hundredth of the
/// largest torque at least.
friction::FrictionGuess guess_of(const RigidBodyFit& rigid, const JointFrictionData& data,
                                 int joint);

/// Whether the friction of a joint is Coulomb and viscous and no more but a smoothed step.
inline bool is_linear(const friction::RobotFriction& friction, int joint) {
  using enum friction::Role;
  return friction.joints()[static_cast<std::size_t>(joint)].laws.size() == 1 &&
         std::ranges::all_of(friction.parameters(), [joint](const auto& parameter) {
           const friction::Role role = parameter.info.role;
           return parameter.joint != joint || role == kCoulomb || role == kViscous ||
                  role == kSmoothingSpeed;
         });
}

/// Index in theta of Coulomb friction in the law that parameter p belongs to; -1 without one.
inline int coulomb_beside(const friction::RobotFriction& friction, std::size_t p) {
  const std::vector<friction::ParameterRef>& parameters = friction.parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].joint == parameters[p].joint && parameters[i].law == parameters[p].law &&
        parameters[i].info.role == friction::Role::kCoulomb)
      return static_cast<int>(i);
  return -1;
}

/// The prior of a joint's constant torque in the regression, for searches beside it: one row of a
/// search is a share of the regression's independent rows.
inline OffsetPrior offset_prior(const RigidBodyFit& fit, int joint) {
  const double sd = fit.offset_prior_sd[joint];
  const int rows = fit.equations[static_cast<std::size_t>(joint)];
  if (!std::isfinite(sd) || sd <= 0 || rows == 0) return {};
  return {sd, std::pow(fit.sigma[joint] / sd, 2) / rows};
}

/// Residual of one joint's torque over its usable rows.
class TorqueScore {
 public:
  /// @param slides  whether the joint moves faster than at the least speed of the regression
  void add(double tau, double residual, bool slides) {
    for (Sums* sums : {&all_, slides ? &sliding_ : &resting_}) {
      sums->residual += residual * residual;
      sums->tau += tau;
      sums->square += tau * tau;
      sums->rows += 1;
    }
  }
  /// Writes the score of joint i into a report, whose lists are long enough.
  template <class Report>
  void write(std::size_t i, Report& report) const {
    report.residual_rms[i] = all_.rms();
    report.r2[i] = all_.r2();
    report.sliding_r2[i] = sliding_.r2();
    report.resting_rms[i] = resting_.rms();
  }

 private:
  struct Sums {
    double residual = 0, tau = 0, square = 0, rows = 0;
    double rms() const { return std::sqrt(residual / std::max(1.0, rows)); }
    double r2() const { return 1 - residual / (square - tau * tau / std::max(1.0, rows)); }
  };
  Sums all_, sliding_, resting_;
};

/// Scores the torque of joint j over its usable rows.
/// @param residual   of sample k of recording s, residual(s, k) [N m]
/// @param min_speed  above which the joint slides [rad/s]
template <class Residual, class Report>
void score_joint(std::span<const signals::Recording> recordings, int j, double min_speed,
                 const Residual& residual, Report& report) {
  TorqueScore score;
  for (std::size_t s = 0; s < recordings.size(); ++s) {
    const signals::Recording& r = recordings[s];
    for (int k = 0; k < r.length(); ++k)
      if (r.use(k, j))
        score.add(r.filtered_tau(k, j), residual(s, k), std::abs(r.narrow.v(k, j)) > min_speed);
  }
  score.write(static_cast<std::size_t>(j), report);
}

inline double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

inline std::span<const double> view(const Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}
inline std::span<double> view(Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

}  // namespace fricid::estimate
