#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "assumed_noise.hpp"
#include "disturbances.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/estimate/memory.hpp"
#include "fricid/estimate/predict_torque.hpp"
#include "fricid/estimate/torque/by_period.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/weights.hpp"
#include "support.hpp"
#include "torque/fit_joint.hpp"

namespace fricid::estimate {
namespace {

constexpr std::string_view kStartOfLearnedLaws = "dahl";
// How a learned law shares out the Coulomb friction of its start.
constexpr double kWithoutMemory = 0.1, kOfNetwork = 0.5;
constexpr double kEmRidge = 1e-3;         // of EM on laws of the whole robot
constexpr int kBackboneEvaluations = 60;  // of Nelder-Mead, before Levenberg-Marquardt

/// A learned law in every joint that starts as the Dahl law of `start`: its level shared between
/// bristles, its viscous coefficient kept, networks near zero.
Arm learned_start(const Arm& start, const friction::LawSpec& law, std::uint64_t seed,
                  const std::vector<double>& torque) {
  Arm arm = start;
  const int n = arm.robot.n();
  arm.friction.model = friction::RobotFriction(
      std::vector<friction::JointSpec>(static_cast<std::size_t>(n), friction::JointSpec{{law}}));
  const friction::RobotFriction one({friction::JointSpec{{law}}});
  const std::size_t own = friction::parameters_of_law(law.law, law.elements).size();
  arm.friction.theta.clear();
  for (int j = 0; j < n; ++j) {
    using enum friction::Role;
    const auto of_start = [&](friction::Role role) {
      return start.friction
          .theta[static_cast<std::size_t>(find_parameter(start.friction.model, j, role))];
    };
    const friction::FrictionGuess guess{of_start(kCoulomb), of_start(kViscous)};
    std::vector<double> theta = friction::start_from(one, guess);
    const auto bristles = std::ranges::count_if(
        one.parameters(), [](const auto& parameter) { return parameter.info.role == kLevel; });
    for (std::size_t p = 0; p < own; ++p) {
      const friction::ParameterInfo& info = one.parameters()[p].info;
      if (info.role == kMemoryless) theta[p] = kWithoutMemory * guess.Fc;
      if (info.role == kNetworkTorque) theta[p] = kOfNetwork * guess.Fc;
      if (info.role == kLevel)
        theta[p] = (1 - kWithoutMemory) * guess.Fc / static_cast<double>(bristles);
      if (info.role == kLoadScale) theta[p] = torque[static_cast<std::size_t>(j)];
      theta[p] = std::clamp(theta[p], info.lower, info.upper);
    }
    // the modifiers, behind the law in both, as they are
    const auto end = start.friction.theta.begin() + start.friction.model.parameter_begin(j + 1);
    std::copy(end - static_cast<std::ptrdiff_t>(theta.size() - own), end,
              theta.begin() + static_cast<std::ptrdiff_t>(own));
    arm.friction.theta.insert(arm.friction.theta.end(), theta.begin(), theta.end());
  }
  friction::initialise_weights(arm.friction.model, seed, arm.friction.theta);
  return arm;
}

/// Fits the physical parameters of a learned law (levels and lengths of its bristles, Coulomb and
/// viscous torque) to the torque that the rigid body leaves, its networks as they are.
void fit_backbone(Arm& arm, const Prepared& prepared, double cutoff_hz, int seed, int jobs) {
  const friction::JointSpec& spec = arm.friction.model.joints().front();
  const friction::RobotFriction one({spec});
  FrictionFitOptions options;
  options.starts = 1;
  options.evaluations = kBackboneEvaluations;
  options.seed = static_cast<std::uint64_t>(seed);
  const std::size_t of_law =
      friction::parameters_of_law(spec.laws.front().law, spec.laws.front().elements).size();
  for (std::size_t p = 0; p < one.parameters().size(); ++p) {
    using enum friction::Role;
    const friction::Role role = one.parameters()[p].info.role;
    const bool physical = role == kMemoryless || role == kSmoothingSpeed || role == kViscous ||
                          role == kLevel || role == kLength || role == kCoulomb ||
                          role == kStiffness;
    if (p >= of_law || !physical) options.held.push_back(p);
  }
  const FrictionTorques target =
      friction_target(arm.robot, arm.robot.pi, prepared.recordings, jobs);
  parallel_for(arm.robot.n(), jobs, [&](int j) {
    const std::span<double> own =
        std::span(arm.friction.theta)
            .subspan(static_cast<std::size_t>(arm.friction.model.parameter_begin(j)),
                     one.parameters().size());
    const JointFrictionData data(prepared.recordings, target, j, cutoff_hz,
                                 offset_prior(prepared.rigid_body, j));
    FrictionFitOptions of_joint = options;
    of_joint.stream = static_cast<std::uint64_t>(j);
    const JointFrictionFit fit =
        fit_joint_friction(data, one, std::vector<double>(own.begin(), own.end()), of_joint);
    if (fit.outcome != Outcome::kFailed) std::copy(fit.theta.begin(), fit.theta.end(), own.begin());
  });
}

/// A law of the whole robot with random weights in the place of the friction of `start`, its scales
/// those of the training data.
Arm robot_law_start(const Arm& start, const ModelOptions& config, std::uint64_t seed,
                    const TorqueData& data) {
  const int n = start.robot.n();
  Arm arm = start;
  arm.friction.model =
      friction::RobotFriction(std::vector<friction::JointSpec>(static_cast<std::size_t>(n)),
                              {config.law, config.elements, config.n_z});
  arm.friction.theta = friction::default_theta(arm.friction.model);
  for (std::size_t p = 0; p < arm.friction.theta.size(); ++p)
    switch (arm.friction.model.parameters()[p].info.role) {
      case friction::Role::kSampleTime:
        arm.friction.theta[p] = data.recordings.front().dt;
        break;
      case friction::Role::kLength:
        arm.friction.theta[p] = config.length;
        break;
      case friction::Role::kCrossWeights:
        arm.friction.theta[p] = config.cross ? 1 : 0;
        break;
      default:
        break;
    }

  friction::SignalSizes sizes;
  for (int j = 0; j < n; ++j) {
    double rows = 0, q = 0, qq = 0, vv = 0, tt = 0;
    for (std::size_t s = 0; s < data.target.size(); ++s) {
      const signals::Motion& motion = data.recordings[s].motion(data.band);
      const RowMatrix& target = data.target[s];
      for (Eigen::Index k = 0; k < target.rows(); ++k) {
        if (!data.recordings[s].use(k, j)) continue;
        rows += 1;
        q += motion.q(k, j);
        qq += motion.q(k, j) * motion.q(k, j);
        vv += motion.v(k, j) * motion.v(k, j);
        tt += target(k, j) * target(k, j);
      }
    }
    rows = std::max(1.0, rows);
    sizes.q_mean.push_back(q / rows);
    sizes.q_sd.push_back(std::sqrt(std::max(0.0, qq / rows - q / rows * (q / rows))));
    sizes.v_sd.push_back(std::sqrt(vv / rows));
    sizes.tau_sd.push_back(std::sqrt(tt / rows));
  }
  friction::set_signal_sizes(arm.friction.model, sizes, arm.friction.theta);
  friction::initialise_weights(arm.friction.model, seed, arm.friction.theta);
  return arm;
}

}  // namespace

void score_torque(const Prepared& prepared, double cutoff_hz, int jobs, FitReport& report) {
  const auto count = prepared.recordings.size();
  std::vector<RowMatrix> predicted(count);
  parallel_for(static_cast<int>(count), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    predicted[s] = predict_torque(report.model.arm, prepared.recordings[s], cutoff_hz);
  });
  FrictionTorques residual(count);
  for (std::size_t s = 0; s < count; ++s)
    residual[s] = prepared.recordings[s].filtered_tau - predicted[s];
  const std::vector<double>& least_speed = prepared.rigid_body.least_speed;
  for (int j = 0; j < prepared.robot.n(); ++j)
    score_joint(
        prepared.recordings, j, least_speed[static_cast<std::size_t>(j)],
        [&](std::size_t s, int k) { return residual[s](k, j); }, report);
  report.disturbances =
      find_disturbances(prepared.robot, prepared.recordings, least_speed, residual);
  report.weights = other_weights(prepared.robot, prepared.recordings, report.rigid_body);
}

FitReport fit_model(ConventionalFits& conventional, const ModelOptions& config, int seed, int jobs,
                    const optimise::Checkpoint& checkpoint) {
  const Prepared& prepared = conventional.prepared();
  TrainingSize size{.rate_hz = 1 / prepared.recordings.front().dt};
  for (const signals::Recording& recording : prepared.recordings) {
    size.samples += recording.length();
    size.longest = std::max(size.longest, static_cast<double>(recording.length()));
  }
  require_memory_of_fit(config, prepared.robot, size, jobs, prepared.robot.name);

  if (config.method == Method::kJoint) return fit_joint(conventional, config, seed, jobs);
  const bool learned = config.laws.empty() && friction::is_learned(config.law);
  const bool whole = config.laws.empty() && friction::is_robot_law(config.law);
  const double cutoff = prepared.options.cutoff_hz;
  const Method method = config.method.value_or(Method::kConventional);
  ModelOptions start = config;
  if (learned) start.law = whole ? config.rigid_body_of : kStartOfLearnedLaws;
  if (whole) start.elements = ModelOptions{}.elements;
  if (method == Method::kEm) require_length_for_em(prepared.recordings);
  FitReport report = conventional.fit(start, seed, jobs);
  report.method = method;
  if (!report.has_result()) return report;
  if (method == Method::kConventional) {
    report.model.noise = assumed_noise(report.model.arm, prepared, report.residual_rms);
    return report;
  }

  Arm arm = report.model.arm;
  const ByPeriod periods = by_period(prepared.recordings);
  TorqueData explained;
  if (whole || method == Method::kTorque)
    explained = torque_data(arm, periods.recordings, config.torque.filtered);
  if (whole) {
    arm = robot_law_start(arm, config, static_cast<std::uint64_t>(seed), explained);
  } else if (learned) {
    arm = learned_start(arm, {config.law, config.elements, modifiers_of(config.modifiers)},
                        static_cast<std::uint64_t>(seed), torque_rms(prepared.recordings));
    // windows move the bristles themselves, and further from a start that is not yet a minimum
    if (method == Method::kTorque) fit_backbone(arm, prepared, cutoff, seed, jobs);
  }
  report.joints.clear();
  report.model.budget.clear();
  const auto take = [&](const auto& trained, const std::string& budget) {
    report.outcome = trained.outcome;
    report.message = trained.message;
    report.model.arm = trained.arm;
    report.seconds += trained.seconds;
    report.model.budget += (report.model.budget.empty() ? "" : ", ") + budget;
  };
  const auto train_on_torque = [&] {
    TorqueOptions options = config.torque;
    options.cutoff_hz = cutoff;
    options.seed = static_cast<std::uint64_t>(seed);
    report.torque = train_torque(arm, explained, options, report.model.label, jobs);
    take(*report.torque, fmt::format("{} steps (torque)", report.torque->history.loss.size()));
    arm = report.torque->arm;
  };
  if (method == Method::kTorque) {
    train_on_torque();
  } else if (method == Method::kMultiStep) {
    if (whole) train_on_torque();
    MultiStepOptions options = config.train;
    options.torque_scale = torque_rms(prepared.recordings);
    options.seed = static_cast<std::uint64_t>(seed);
    report.multi_step =
        train_multi_step(arm, periods.recordings, options, report.model.label, jobs);
    take(*report.multi_step,
         fmt::format("{} steps (windows)", report.multi_step->history.loss.size()));
  } else {
    EmOptions options = config.em;
    options.torque_scale = torque_rms(prepared.recordings);
    options.seed = static_cast<std::uint64_t>(seed);
    if (whole) {
      options.ridge = kEmRidge;
      options.rigid_body_speed = prepared.rigid_body.least_speed;
    }
    report.em = fit_em(arm, prepared.recordings, options, report.model.label, jobs, checkpoint);
    take(*report.em, fmt::format("{} iterations (EM)", report.em->iterations.size()));
  }
  report.model.free_parameters = static_cast<int>(report.rigid_body.base.size()) +
                                 friction::free_parameter_count(report.model.arm.friction);
  score_torque(prepared, cutoff, jobs, report);
  if (report.em) {
    report.model.noise = report.em->noise;
    report.model.noise->friction = friction_left(report.residual_rms);
  } else {
    report.model.noise = assumed_noise(report.model.arm, prepared, report.residual_rms);
  }
  report.faults = faults_of(prepared, report);
  return report;
}

}  // namespace fricid::estimate
