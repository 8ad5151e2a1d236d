#include "fricid/estimate/conventional.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "disturbances.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/estimate/friction/motion_errors.hpp"
#include "fricid/estimate/predict_torque.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/weights.hpp"
#include "support.hpp"
#include "torque/fit_joint.hpp"

namespace fricid::estimate {
namespace {

constexpr int kPasses = 2;             // friction, rigid body with friction removed, friction again
constexpr double kMemoryOfAShape = 1;  // memory_periods once a law describes the reversals

// What the regression found of a parameter of linear friction.
double linear_value(const Prepared& prepared, const RigidBodyFit& rigid,
                    const friction::ParameterInfo& info, int joint) {
  using enum friction::Role;
  return info.role == kCoulomb   ? rigid.Fc_beside[joint]
         : info.role == kViscous ? rigid.Fv_beside[joint]
                                 : smoothing_speed(prepared.robot, prepared.recordings,
                                                   prepared.options.cutoff_hz, joint);
}

// The friction of the regression as the law's.
JointFrictionFit linear_fit(const Prepared& prepared, const JointFrictionData& data,
                            const friction::RobotFriction& one, int joint) {
  using enum friction::Role;
  const RigidBodyFit& rigid = prepared.rigid_body;
  const auto p = static_cast<Eigen::Index>(one.parameters().size());
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  JointFrictionFit fit;
  fit.correlation = Eigen::MatrixXd::Constant(p, p, kUnknown);
  for (const friction::ParameterRef& parameter : one.parameters()) {
    const friction::ParameterInfo& info = parameter.info;
    const bool coulomb = info.role == kCoulomb, viscous = info.role == kViscous;
    const double value = linear_value(prepared, rigid, info, joint);
    fit.theta.push_back(std::clamp(value, info.lower, info.upper));
    fit.standard_error.push_back(coulomb   ? rigid.Fc_se[joint]
                                 : viscous ? rigid.Fv_se[joint]
                                           : kUnknown);
    if (fit.theta.back() != value) fit.at_bound.push_back(parameter.symbol);
  }
  const double mean_square = data.mean_square(one, fit.theta);
  fit.rms = std::sqrt(mean_square);
  fit.offset = data.offset(one, fit.theta);
  fit.explained = data.target_mean_square() > 0 ? 1 - mean_square / data.target_mean_square() : 0;
  fit.start_rms = {fit.rms};
  fit.evaluations = 1;
  fit.outcome = std::isfinite(fit.rms) && data.rows() > 0 ? Outcome::kConverged : Outcome::kFailed;
  fit.message = data.rows() == 0 ? "no usable rows"
                                 : fmt::format("rms {:.4g} N m of {:.4g} by the regression",
                                               fit.rms, std::sqrt(data.target_mean_square()));
  return fit;
}

/// The robot with friction as the regression found it: Coulomb, viscous, and its growth with the
/// load where the data show it.
Arm linear_arm(const Prepared& prepared) {
  using enum friction::Role;
  const std::string law = prepared.under_load ? "load_dependent" : "coulomb_viscous";
  Arm arm{prepared.robot, {}};
  arm.friction.model = friction::RobotFriction(std::vector(
      static_cast<std::size_t>(prepared.robot.n()), friction::JointSpec{{{law, 0, {}}}}));
  const RigidBodyFit& rigid = prepared.rigid_body_of(arm.friction.model);
  arm.robot.pi = rigid.pi;
  const auto value_of = [&](const friction::ParameterInfo& info, int joint) {
    return info.role == kLoadCoefficient ? rigid.growth[joint]
           : info.role == kLoadGrowth    ? 0
           : info.role == kLoadSmoothing ? info.typical
                                         : linear_value(prepared, rigid, info, joint);
  };
  for (const friction::ParameterRef& p : arm.friction.model.parameters())
    arm.friction.theta.push_back(std::clamp(value_of(p.info, p.joint), p.info.lower, p.info.upper));
  return arm;
}

/// The recordings with the load that linear friction predicts. The measured torque as load would
/// explain itself: friction of |tau| sgn(v) is the whole torque of a joint that is mostly friction.
std::vector<signals::Recording> under_linear_load(const Prepared& prepared, int jobs) {
  const Arm arm = linear_arm(prepared);
  std::vector<signals::Recording> out = prepared.recordings;
  parallel_for(static_cast<int>(out.size()), jobs, [&](int i) {
    signals::Recording& r = out[static_cast<std::size_t>(i)];
    r.load = predict_torque(arm, r, prepared.options.cutoff_hz);
  });
  return out;
}

/// A rigid body found beside a law's torque, with the linear friction and the reasons of the
/// regression before it.
RigidBodyFit beside_law(RigidBodyFit fit, const RigidBodyFit& linear) {
  fit.law_factor = std::exchange(fit.Fc, linear.Fc);
  // what the motion determines is for that regression to say: a law's torque may be next to nothing
  if (fit.outcome == Outcome::kIllConditioned || linear.outcome == Outcome::kIllConditioned) {
    fit.outcome = linear.outcome;
    fit.message = linear.message;
    fit.condition = linear.condition;
  }
  for (Eigen::VectorXd RigidBodyFit::*part :
       {&RigidBodyFit::Fv, &RigidBodyFit::offset, &RigidBodyFit::Fc_se, &RigidBodyFit::Fv_se,
        &RigidBodyFit::offset_se, &RigidBodyFit::Fc_beside, &RigidBodyFit::Fv_beside})
    fit.*part = linear.*part;
  fit.lacks_growth = linear.lacks_growth;
  fit.prior = linear.prior;
  fit.slower = linear.slower;
  fit.without_inertia = linear.without_inertia;
  return fit;
}

// The search for a law takes the rigid body as known: its errors are no less than those of the
// regression, which does not.
void widen_errors(const RigidBodyFit& rigid, const friction::RobotFriction& one,
                  std::vector<JointFrictionFit>& joints) {
  using enum friction::Role;
  if (rigid.Fc_se.size() != static_cast<Eigen::Index>(joints.size())) return;
  for (std::size_t i = 0; i < one.parameters().size(); ++i) {
    const friction::Role role = one.parameters()[i].info.role;
    if (role != kCoulomb && role != kViscous) continue;
    for (std::size_t j = 0; j < joints.size(); ++j)
      if (i < joints[j].standard_error.size())
        joints[j].standard_error[i] =
            std::max(joints[j].standard_error[i],
                     (role == kCoulomb ? rigid.Fc_se : rigid.Fv_se)[static_cast<Eigen::Index>(j)]);
  }
}

/// One law, fitted joint by joint to what a rigid body leaves.
class LawFits {
 public:
  LawFits(const Prepared& prepared, const ModelOptions& options, int seed, int jobs)
      : prepared_(prepared),
        options_(options),
        seed_(seed),
        law_({joint_spec_of(options)}),
        linear_(is_linear(law_, 0) && prepared.rigid_body.Fc_beside.size() == prepared.robot.n()),
        temperature_(temperatures_of(prepared.recordings).mean),
        loaded_(law_.reads_load() ? under_linear_load(prepared, jobs)
                                  : std::vector<signals::Recording>{}) {
    if (!linear_) motion_.emplace(recordings(), prepared.options.cutoff_hz, jobs);
  }

  const friction::RobotFriction& law() const { return law_; }  ///< of one joint
  /// Whether it is found by the regression of the rigid body.
  bool linear() const { return linear_; }
  /// Linear friction and rigid body are one regression.
  int passes() const { return linear_ ? 1 : kPasses; }

  /// Fits joint j to `target` and writes the torque of the law in its column of `torque`.
  /// @param before  the fit of the pass before
  JointFrictionFit fit(int pass, int j, const FrictionTorques& target,
                       const JointFrictionFit& before, FrictionTorques& torque) const {
    const RigidBodyFit& rigid = prepared_.rigid_body_of(law_);
    const JointFrictionData data(recordings(), target, j, prepared_.options.cutoff_hz,
                                 offset_prior(rigid, j));
    const JointFrictionFit found =
        linear_ ? linear_fit(prepared_, data, law_, j) : searched(pass, j, data, rigid, before);
    const PerSample f = data.predict(law_, found.theta);
    for (std::size_t s = 0; s < f.size(); ++s)
      torque[s].col(j) = Eigen::VectorXd::Map(f[s].data(), std::ssize(f[s]));
    return found;
  }

 private:
  std::span<const signals::Recording> recordings() const {
    return loaded_.empty() ? prepared_.recordings : loaded_;
  }

  JointFrictionFit searched(int pass, int j, const JointFrictionData& data,
                            const RigidBodyFit& rigid, const JointFrictionFit& before) const {
    FrictionFitOptions options;
    options.seed = static_cast<std::uint64_t>(seed_);
    options.stream = static_cast<std::uint64_t>(j);
    options.starts = pass == 0 ? options_.starts : 1;
    options.grows = rigid.shows_growth(j);
    if (pass + 1 == passes())
      options.motion_error = [&](std::span<const double> theta) {
        return motion_->of(data, j, law_, theta, data.used_rows());
      };
    std::vector<double> start =
        pass == 0 ? friction::start_from(law_, guess_of(rigid, data, j)) : before.theta;
    // Coulomb friction is that at the temperature of the log, not at one that is fitted
    for (std::size_t p = 0; p < start.size(); ++p)
      if (law_.parameters()[p].info.role == friction::Role::kTemperature) {
        start[p] = temperature_;
        options.held.push_back(p);
      }
    return fit_joint_friction(data, law_, start, options);
  }

  const Prepared& prepared_;
  const ModelOptions& options_;
  int seed_;
  friction::RobotFriction law_;
  bool linear_;
  double temperature_;
  std::vector<signals::Recording> loaded_;  // of a law that reads a load
  std::optional<MotionErrors> motion_;
};

/// The verdict is that of the worst part.
void conclude(const dynamics::RobotModel& robot, FitReport& report) {
  report.outcome = report.rigid_body.outcome;
  report.message = "rigid body: " + report.rigid_body.message;
  for (std::size_t j = 0; j < report.joints.size(); ++j)
    if (report.joints[j].outcome > report.outcome) {
      report.outcome = report.joints[j].outcome;
      report.message = fmt::format("{}: {}", robot.joints[j].name, report.joints[j].message);
    }
}

}  // namespace

FitReport fit_conventional(const Prepared& prepared, const ModelOptions& options, int seed,
                           int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const dynamics::RobotModel& robot = prepared.robot;
  const int n = robot.n();
  const LawFits fits(prepared, options, seed, jobs);
  const RigidBodyFit& rigid = prepared.rigid_body_of(fits.law());
  FitReport report = empty_report(prepared, options, seed);
  report.model.arm.friction.model = friction::RobotFriction(
      std::vector<friction::JointSpec>(static_cast<std::size_t>(n), joint_spec_of(options)));
  report.rigid_body = rigid;
  report.joints.resize(static_cast<std::size_t>(n));

  Progress progress(fmt::format("fit {}", report.model.label), fits.passes() * n);
  FrictionTorques friction_torque(prepared.recordings.size());
  for (std::size_t s = 0; s < friction_torque.size(); ++s)
    friction_torque[s].resize(prepared.recordings[s].length(), n);
  int evaluations = 0;
  for (int pass = 0; pass < fits.passes(); ++pass) {
    if (pass > 0) {
      RigidBodyOptions beside = as_needed(prepared.options, rigid);
      beside.memory_periods = kMemoryOfAShape;
      report.rigid_body = beside_law(
          rigid_body_least_squares(robot, prepared.recordings, beside, &friction_torque), rigid);
    }
    const FrictionTorques target =
        friction_target(robot, report.rigid_body.pi, prepared.recordings, jobs);
    report.couplings = find_couplings(prepared.recordings, target);
    parallel_for(n, jobs, [&](int j) {
      JointFrictionFit& joint = report.joints[static_cast<std::size_t>(j)];
      joint = fits.fit(pass, j, target, joint, friction_torque);
      progress.advance(1);
    });
    double left = 0;
    for (const JointFrictionFit& joint : report.joints) {
      left += (1 - joint.explained) / n;
      evaluations += joint.evaluations;
    }
    report.objective.push_back(left);
    for (int j = 0; j < n; ++j)
      score_joint(
          prepared.recordings, j, report.rigid_body.least_speed[static_cast<std::size_t>(j)],
          [&](std::size_t s, int k) { return target[s](k, j) - friction_torque[s](k, j); }, report);
  }

  FrictionTorques residual =
      friction_target(robot, report.rigid_body.pi, prepared.recordings, jobs);
  for (std::size_t s = 0; s < residual.size(); ++s) residual[s] -= friction_torque[s];
  report.disturbances =
      find_disturbances(robot, prepared.recordings, report.rigid_body.least_speed, residual);
  if (prepared.under_load && !fits.linear()) widen_errors(*prepared.under_load, report.rigid_body);
  widen_errors(rigid, fits.law(), report.joints);
  report.weights = other_weights(robot, prepared.recordings, report.rigid_body);
  report.model.arm.robot.pi = report.rigid_body.pi;
  for (const JointFrictionFit& joint : report.joints)
    std::ranges::copy(joint.theta, std::back_inserter(report.model.arm.friction.theta));
  report.model.free_parameters = static_cast<int>(report.rigid_body.base.size()) +
                                 friction::free_parameter_count(report.model.arm.friction);
  conclude(robot, report);
  report.faults = faults_of(prepared, report);
  report.seconds = seconds_since(begin);
  report.model.budget = fmt::format("{} evaluations", evaluations);
  return report;
}

FitReport ConventionalFits::fit(const ModelOptions& options, int seed, int jobs) {
  const friction::RobotFriction law({joint_spec_of(options)});
  const auto same = [&](const Kept& kept) {
    return kept.seed == seed && kept.starts == options.starts &&
           std::ranges::equal(kept.law.parameters(), law.parameters(), friction::is_same);
  };
  auto kept = std::ranges::find_if(kept_, same);
  if (kept == kept_.end()) {
    kept_.push_back({law, options.starts, seed, fit_conventional(prepared_, options, seed, jobs)});
    kept = std::prev(kept_.end());
  }
  FitReport report = kept->report;
  report.model.name = options.name;
  report.model.label = options.label.empty() ? options.name : options.label;
  return report;
}

}  // namespace fricid::estimate
