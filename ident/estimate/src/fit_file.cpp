#include "fricid/estimate/fit_report.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/not_finite.hpp"
#include "fricid/base/text.hpp"
#include "fricid/estimate/remarks.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"
#include "fricid/estimate/torque/sum_start.hpp"
#include "fricid/friction/laws/memory_network.hpp"

namespace fricid::estimate {
namespace {

constexpr double kAbsent = 0.01;  // viscous torque at 1 rad/s over Coulomb friction

data::FittedRigidBody rigid_body_of(const RigidBodyFit& fit, const dynamics::RobotModel& robot) {
  data::FittedRigidBody body{
      .outcome = fit.outcome,
      .message = fit.message,
      .prior = fit.prior,
      .slower = fit.slower.empty() ? std::nullopt : std::optional(fit.slower),
      .held_armatures = {},
      .mended_links = robot.mended_links,
      .condition = fit.condition,
      .rows = fit.rows,
      .rows_total = fit.rows_total,
      .equations = fit.equations,
      .sigma = fit.sigma,
      .Fc = fit.Fc,
      .Fv = fit.Fv,
      .offset = fit.offset,
      .Fc_se = fit.Fc_se,
      .Fv_se = fit.Fv_se,
      .offset_se = fit.offset_se,
      .law_factor = fit.law_factor,
      .load_growth = {},
      .base = {}};
  if (fit.growth.size() > 0)
    body.load_growth = {.modelled = !fit.lacks_growth,
                        .side = fit.growth_of,
                        .coefficient = fit.growth,
                        .standard_error = fit.growth_se};
  for (const JointInertia& found : fit.without_inertia)
    body.held_armatures.push_back(
        {.joint = robot.joints[static_cast<std::size_t>(found.joint)].name,
         .inertia = found.value,
         .inertia_se = found.error,
         .armature = fit.pi[robot.armature_begin() + found.joint]});
  const Eigen::VectorXd of_model = fit.base_of_pi * robot.pi;
  for (Eigen::Index i = 0; i < fit.base.size(); ++i) {
    const Verdict verdict = judge(fit.base_se[i], fit.base_size[i]);
    body.base.push_back({.name = fit.base_names[static_cast<std::size_t>(i)],
                         .verdict = std::string(name_of(verdict)),
                         .value = fit.base[i],
                         .standard_error = verdict == Verdict::kNot ? kNan : fit.base_se[i],
                         .physical = of_model[i]});
  }
  return body;
}

data::FittedJoint joint_of(const FitReport& report, std::size_t j) {
  const JointFrictionFit& fit = report.joints[j];
  const friction::RobotFriction& friction = report.model.arm.friction.model;
  const auto begin = static_cast<std::size_t>(friction.parameter_begin(static_cast<int>(j)));
  data::FittedJoint joint{.joint = report.model.arm.robot.joints[j].name,
                          .outcome = fit.outcome,
                          .message = fit.message,
                          .offset = fit.offset,
                          .rms = fit.rms,
                          .explained = fit.explained,
                          .residual_rms = report.residual_rms[j],
                          .r2 = report.r2[j],
                          .start_rms = fit.start_rms,
                          .at_bound = fit.at_bound,
                          .guessed = fit.guessed,
                          .evaluations = fit.evaluations,
                          .parameters = {},
                          .correlation = fit.correlation};
  for (std::size_t i = 0; i < fit.theta.size(); ++i)
    joint.parameters.push_back({friction.parameters()[begin + i].symbol, fit.theta[i],
                                i < fit.standard_error.size() ? fit.standard_error[i] : kNan,
                                i < fit.motion_error.size() && std::isfinite(fit.motion_error[i])
                                    ? std::optional(fit.motion_error[i])
                                    : std::nullopt});
  return joint;
}

/// Whether a parameter is on a bound of the table that is not zero: at zero a term is absent. No
/// bound is that of a phase, where its values begin anew, and of the exponent of a torque that is
/// absent.
bool on_bound(const friction::Friction& friction, int parameter) {
  const friction::ParameterRef& p =
      friction.model.parameters()[static_cast<std::size_t>(parameter)];
  const double value = friction.theta[static_cast<std::size_t>(parameter)];
  if (p.info.role == friction::Role::kPhase) return false;
  if (p.info.role == friction::Role::kExponent) {
    const auto size = [&](friction::Role role) {
      const int found = friction::find_parameter(friction.model, p.joint, role);
      return found < 0 ? 0 : friction.theta[static_cast<std::size_t>(found)];
    };
    if (size(friction::Role::kPowerViscous) < kAbsent * size(friction::Role::kCoulomb))
      return false;
  }
  return value == p.info.upper || (value == p.info.lower && value != 0);
}

/// Friction of a joint that was fitted together with the rigid body. A parameter without an error
/// is held: NaN.
data::FittedJoint jointly_fitted(const FitReport& report, std::size_t j) {
  const friction::Friction& friction = report.model.arm.friction;
  const auto joint_number = static_cast<int>(j);
  const int begin = friction.model.parameter_begin(joint_number),
            size = friction.model.parameter_begin(joint_number + 1) - begin;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd of_motion = Eigen::VectorXd::Zero(size);
  if (const Eigen::MatrixXd& root = report.errors.root; root.size() > 0) {
    const auto own = root.middleRows(report.model.arm.robot.pi.size() + begin, size);
    covariance = own * own.transpose();
    of_motion = own.rightCols(root.cols() - report.errors.before_motion).rowwise().norm();
  }
  const Eigen::VectorXd error = covariance.diagonal().cwiseSqrt();
  const std::vector<std::size_t> slowest = slowest_stribeck_velocities(report.model.arm);
  data::FittedJoint joint{.joint = report.model.arm.robot.joints[j].name,
                          .outcome = report.outcome,
                          .message = "fitted together with the rigid body",
                          .offset = 0,
                          .rms = report.residual_rms[j],
                          .explained = kNan,
                          .residual_rms = report.residual_rms[j],
                          .r2 = report.r2[j],
                          .start_rms = {},
                          .at_bound = {},
                          .guessed = {},
                          .evaluations = 0,
                          .parameters = {},
                          .correlation = Eigen::MatrixXd::Constant(size, size, kNan)};
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto p = static_cast<std::size_t>(begin + i);
    const friction::ParameterRef& parameter = friction.model.parameters()[p];
    joint.parameters.push_back({parameter.symbol, friction.theta[p], error[i] > 0 ? error[i] : kNan,
                                error[i] > 0 ? std::optional(of_motion[i]) : std::nullopt});
    if (error[i] > 0 &&
        (on_bound(friction, begin + static_cast<int>(i)) || std::ranges::count(slowest, p) > 0))
      joint.at_bound.push_back(parameter.symbol);
    for (Eigen::Index k = 0; k < size; ++k)
      if (error[i] > 0 && error[k] > 0)
        joint.correlation(i, k) = std::clamp(covariance(i, k) / (error[i] * error[k]), -1., 1.);
  }
  return joint;
}

data::FittedTraining training_of(const TorqueReport& report) {
  return {.outcome = report.outcome,
          .message = report.message,
          .loss = report.history.loss,
          .checked = report.history.checked,
          .held_out = report.history.held_out,
          .chosen = report.history.best,
          .skipped = report.history.skipped};
}

data::FittedTraining training_of(const MultiStepReport& report) {
  return {.outcome = report.outcome,
          .message = report.message,
          .loss = report.history.loss,
          .checked = report.history.checked,
          .held_out = report.history.held_out,
          .chosen = report.history.best,
          .skipped = report.history.skipped,
          .returns = report.history.returns,
          .leap = report.leap};
}

data::FittedEm em_of(const EmReport& report) {
  data::FittedEm em{.outcome = report.outcome,
                    .message = report.message,
                    .held_out_start = report.held_out_start,
                    .iterations = {},
                    .chosen = report.best,
                    .warnings = report.warnings,
                    .variance_q = report.noise.q,
                    .variance_v = report.noise.v,
                    .variance_z = report.noise.z,
                    .variance_observation = report.noise.R};
  for (const EmIteration& i : report.iterations)
    em.iterations.push_back({i.log_likelihood, i.nis, i.least_roots, i.least_backward_ess,
                             i.objective, i.velocity_sd, i.held_out});
  return em;
}

}  // namespace

data::FitFile fit_file(const FitReport& report) {
  data::FitFile file{.name = report.model.name,
                     .label = report.model.label,
                     .seed = report.model.seed,
                     .method = std::string(name_of(report.method)),
                     .outcome = report.outcome,
                     .usable = report.usable(),
                     .message = report.message,
                     .prior_left_out = report.prior_left_out,
                     .faults = {},
                     .remarks = {},
                     .objective = report.objective,
                     .parameters = report.model.free_parameters,
                     .fitted_to = report.fitted_to,
                     .rigid_body = rigid_body_of(report.rigid_body, report.model.arm.robot),
                     .joints = {},
                     .torque = {},
                     .multi_step = {},
                     .em = {},
                     .candidates = {},
                     .parts = {},
                     .without = {},
                     .draws = {}};
  for (const Fault& fault : report.faults)
    file.faults.push_back({fault.joint, fault.found, fault.remedy});
  for (std::size_t j = 0; j < report.joints.size(); ++j) file.joints.push_back(joint_of(report, j));
  if (report.method == Method::kJoint)
    for (std::size_t j = 0; j < report.residual_rms.size(); ++j)
      file.joints.push_back(jointly_fitted(report, j));
  std::vector<data::FittedRemark> remarks = remarks_on(file.joints, report.model.arm.friction.model,
                                                       report.waves, report.bends, report.spots);
  if (!report.weights.empty())
    remarks.push_back(
        {"the torque of gravity is not that of the robot's file: root mean square on " +
             enumeration(report.weights),
         "a load, a counterweight or a spring that the file lacks, or its masses or lengths are "
         "others; a spring passes for mass, and inertia and gravity then disagree",
         "state what the arm carries: payload_kg of [robot], springs as "
         "[[robot.torque]]"});
  std::vector<std::string> with_networks;
  const friction::RobotFriction& model = report.model.arm.friction.model;
  for (std::size_t j = 0; j < model.joints().size(); ++j)
    if (const auto& laws = model.joints()[j].laws;
        laws.size() > 1 &&
        std::ranges::count(laws, friction::MemoryNetwork::kName, &friction::LawSpec::law) > 0)
      with_networks.push_back(report.model.arm.robot.joints[j].name);
  if (!with_networks.empty())
    remarks.push_back({"networks hold a part of the friction of " + enumeration(with_networks),
                       "coefficients of the laws beside them are those of the rest, not of the "
                       "friction",
                       "use the model as a whole, and for coefficients a law alone"});
  if (report.frictionless)
    remarks.push_back({"no joint shows friction",
                       "no gear is without: this is a torque that a model or a controller computed "
                       "from the motion (feed-forward, commanded, inverse dynamics), or that of a "
                       "simulated arm without friction",
                       "log the measured torque, or the current of the motors"});
  if (report.disturbances)
    remarks.push_back({report.disturbances->found,
                       "a push, a collision or a cable that catches is no friction, and pulls what "
                       "is fitted",
                       report.disturbances->remedy});
  if (!remarks.empty()) file.remarks = std::move(remarks);
  if (report.torque) file.torque = training_of(*report.torque);
  if (report.multi_step) file.multi_step = training_of(*report.multi_step);
  if (report.em) file.em = em_of(*report.em);
  const std::vector<bool> from = eligible(report.candidates);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Candidate& c = report.candidates[i];
    file.candidates.push_back({c.name, c.held_out, c.torque, c.parameters, from[i], c.taken});
  }
  for (const PartEvidence& p : report.parts)
    file.parts.push_back({report.model.arm.robot.joints[static_cast<std::size_t>(p.joint)].name,
                          std::string(name_of(p.part)), p.gain, p.error, p.on});
  for (const FitWithout& fit : report.without)
    file.without.push_back(
        {fit.recording, fit.left_out.begin, fit.left_out.end, fit.arm.robot.pi,
         Eigen::VectorXd::Map(fit.arm.friction.theta.data(), std::ssize(fit.arm.friction.theta))});
  if (!report.errors.draws.empty()) {
    data::FittedDraws& draws = file.draws.emplace();
    const auto count = std::ssize(report.errors.draws);
    const Arm& first = report.errors.draws.front();
    draws.pi.resize(count, first.robot.pi.size());
    draws.theta.resize(count, std::ssize(first.friction.theta));
    for (Eigen::Index i = 0; i < count; ++i) {
      const Arm& arm = report.errors.draws[static_cast<std::size_t>(i)];
      draws.pi.row(i) = arm.robot.pi;
      draws.theta.row(i) = Eigen::VectorXd::Map(arm.friction.theta.data(), draws.theta.cols());
    }
  }
  return file;
}

}  // namespace fricid::estimate
