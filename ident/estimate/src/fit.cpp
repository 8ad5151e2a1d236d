#include "fricid/estimate/fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/system/driven_friction.hpp"
#include "fricid/system/initial_state.hpp"
#include "rigid_body/regression.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr int kPasses = 2;             // friction, rigid body with friction removed, friction again
constexpr double kMemoryOfAShape = 1;  // memory_periods once a law describes the reversals

RigidBodyOptions rigid_body_options(const data::Problem& problem,
                                    const dynamics::RobotModel& robot) {
  RigidBodyOptions options;
  options.offset = false;
  options.cutoff_hz = problem.scene.identify.cutoff_hz;
  options.min_speed = problem.scene.identify.min_speed_rad_s;
  options.prior = problem.scene.identify.prior;
  for (const data::TorqueConfig& torque : problem.scene.robot.torques)
    for (std::size_t i = 0; i < torque.terms.size(); ++i)
      options.linear_prior_sd.push_back(i < torque.prior_sd.size()
                                            ? torque.prior_sd[i]
                                            : std::numeric_limits<double>::infinity());
  options.linear_prior_sd.resize(robot.linear_torques.size(),
                                 std::numeric_limits<double>::infinity());
  return options;
}

// The robot that is fitted: a constant torque at every joint that has none takes up sensor offsets
// and what friction differs between the directions, which no odd law can hold.
dynamics::RobotModel with_offsets(dynamics::RobotModel robot) {
  using dynamics::LinearTorque;
  for (int j = 0; j < robot.n(); ++j) {
    const bool has_one = std::any_of(
        robot.linear_torques.begin(), robot.linear_torques.end(), [&](const LinearTorque& torque) {
          return torque.joint == j && torque.shape == LinearTorque::Shape::kConstant;
        });
    if (has_one) continue;
    LinearTorque offset;
    offset.name = robot.joints[static_cast<std::size_t>(j)].name + " 1";
    offset.joint = j;
    offset.shape = LinearTorque::Shape::kConstant;
    dynamics::add_linear_torque(robot, offset);
  }
  return robot;
}

// Law of the table that a model name stands for, with its modifiers.
friction::LawSpec law_of(const data::ModelConfig& config) {
  const std::string_view given = config.law.empty() ? config.name : config.law;
  const std::string_view name = given == "simple" ? "coulomb_viscous" : given;
  for (const friction::LawInfo& law : friction::law_table())
    if (law.name == name)
      return {std::string(name), law.has_elements ? config.elements : 0, modifiers_of(config)};
  std::string known = "simple";
  for (const friction::LawInfo& law : friction::law_table()) known += fmt::format(", {}", law.name);
  throw UserError("model {}: unknown law \"{}\"; known: {}", config.name, name, known);
}

// Coulomb and viscous coefficients of a law that is these two and no more but a smoothed step;
// empty for every other law.
std::vector<std::size_t> linear_friction(const friction::RobotFriction& one) {
  using enum friction::Role;
  const friction::LawSpec& law = one.joints().front().laws.front();
  for (const auto& info : friction::parameters_of_law(law.law, law.elements))
    if (info.role != kCoulomb && info.role != kViscous && info.role != kSmoothingSpeed) return {};
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < one.parameters().size(); ++i)
    if (const friction::Role role = one.parameters()[i].info.role;
        role == kCoulomb || role == kViscous)
      found.push_back(i);
  return found;
}

}  // namespace

FrictionTorques friction_target(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                                std::span<const Filtered> sequences, int jobs) {
  FrictionTorques target(sequences.size());
  parallel_for(static_cast<int>(sequences.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    target[s] = sequences[s].tau - rigid_body_torque(robot, pi, sequences[s]);
  });
  return target;
}

Prepared prepare(const data::Problem& problem, std::span<const data::Dataset> train, int jobs) {
  if (train.empty()) throw UserError("{}: no training data", problem.scene.name);
  for (const data::Dataset& d : train) {
    if (d.n() != problem.robot.n())
      throw UserError("{}: {} joints, the robot has {}", d.name, d.n(), problem.robot.n());
    if (d.rate_hz != train.front().rate_hz)
      throw UserError("{}: rate {} Hz differs from {} Hz of {}", d.name, d.rate_hz,
                      train.front().rate_hz, train.front().name);
  }
  Prepared out;
  out.sequences.resize(train.size());
  out.recordings.resize(train.size());
  parallel_for(static_cast<int>(train.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    const double cutoff = problem.scene.identify.cutoff_hz;
    out.sequences[s] = filter_dataset(train[s], cutoff);
    out.recordings[s] = make_recording(train[s], out.sequences[s], cutoff);
  });
  out.robot = with_offsets(problem.robot);
  out.rigid_body =
      rigid_body_least_squares(out.robot, out.sequences, rigid_body_options(problem, out.robot));
  return out;
}

std::string FitReport::brief() const {
  double r2_mean = 0;
  for (const double value : r2) r2_mean += value / static_cast<double>(r2.size());
  std::string text =
      fmt::format("{} seed {}: {}{}, R2 {:.4f} on training torque, {} parameters, {:.1f} s",
                  model.name, model.seed, usable() ? "" : "NOT TO BE TRUSTED: ", to_string(outcome),
                  r2_mean, model.free_parameters, seconds);
  for (const Fault& fault : faults) text += "; " + in_words(fault);
  return text;
}

FitReport fit_conventional(const data::Problem& problem, const Prepared& prepared,
                           const data::ModelConfig& config, int seed, int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const dynamics::RobotModel& robot = prepared.robot;
  const int n = robot.n();
  const double cutoff = problem.scene.identify.cutoff_hz;
  const friction::LawSpec law = law_of(config);
  const friction::RobotFriction one({friction::JointSpec{{law}}});
  const std::vector<std::size_t> linear = linear_friction(one);

  FitReport report;
  report.model.name = config.name;
  report.model.label = config.label.empty() ? config.name : config.label;
  report.model.seed = seed;
  report.model.arm.robot = robot;
  report.model.arm.friction.model = friction::RobotFriction(
      std::vector<friction::JointSpec>(static_cast<std::size_t>(n), friction::JointSpec{{law}}));
  report.rigid_body = prepared.rigid_body;
  report.joints.resize(static_cast<std::size_t>(n));
  report.residual_rms.resize(static_cast<std::size_t>(n));
  report.r2.resize(static_cast<std::size_t>(n));

  Progress progress(fmt::format("fit {}", report.model.label), kPasses * n);
  FrictionTorques friction_torque(prepared.sequences.size());
  for (std::size_t s = 0; s < friction_torque.size(); ++s)
    friction_torque[s].resize(prepared.sequences[s].length(), n);

  int evaluations = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    if (pass > 0) {
      RigidBodyOptions options = rigid_body_options(problem, robot);
      options.memory_periods = kMemoryOfAShape;
      report.rigid_body =
          rigid_body_least_squares(robot, prepared.sequences, options, &friction_torque);
    }
    const FrictionTorques target =
        friction_target(robot, report.rigid_body.pi, prepared.sequences, jobs);
    std::vector<double> share(static_cast<std::size_t>(n));
    parallel_for(n, jobs, [&](int j) {
      const auto i = static_cast<std::size_t>(j);
      const JointFrictionData data(prepared.sequences, target, j, cutoff);
      FrictionFitOptions options;
      options.seed = static_cast<std::uint64_t>(seed);
      options.stream = static_cast<std::uint64_t>(j);
      options.starts = pass == 0 ? config.starts : 1;
      const double smallest = 0.01 * data.largest_target();
      const friction::FrictionGuess guess{std::max(prepared.rigid_body.Fc[j], smallest),
                                          std::max(prepared.rigid_body.Fv[j], 0.0)};
      // Linear friction is what the regression found; only how it turns over is left to fit.
      if (prepared.rigid_body.Fc[j] > smallest) options.held = linear;
      const std::vector<double> start =
          pass == 0 ? friction::start_from(one, guess) : report.joints[i].theta;
      report.joints[i] = fit_joint_friction(data, one, start, options);
      for (std::size_t s = 0; s < prepared.sequences.size(); ++s)
        friction_torque[s].col(j) =
            data.predicted(one, report.joints[i].theta, static_cast<int>(s));
      share[i] = 1 - report.joints[i].explained;
      progress.advance(1);
    });
    double mean = 0;
    for (const double value : share) mean += value / n;
    for (const JointFrictionFit& joint : report.joints) evaluations += joint.evaluations;
    report.objective.push_back(mean);

    // Residual and explained variance of the whole torque.
    for (int j = 0; j < n; ++j) {
      double residual = 0, sum = 0, square = 0, count = 0;
      for (std::size_t s = 0; s < prepared.sequences.size(); ++s)
        for (int k = 0; k < prepared.sequences[s].length(); ++k) {
          if (!prepared.sequences[s].use(k, j)) continue;
          const double tau = prepared.sequences[s].tau(k, j);
          residual += std::pow(target[s](k, j) - friction_torque[s](k, j), 2);
          sum += tau, square += tau * tau, count += 1;
        }
      const auto i = static_cast<std::size_t>(j);
      report.residual_rms[i] = std::sqrt(residual / std::max(1.0, count));
      report.r2[i] = 1 - residual / (square - sum * sum / std::max(1.0, count));
    }
  }

  report.model.arm.robot.pi = report.rigid_body.pi;
  for (const JointFrictionFit& joint : report.joints)
    report.model.arm.friction.theta.insert(report.model.arm.friction.theta.end(),
                                           joint.theta.begin(), joint.theta.end());
  report.model.free_parameters = static_cast<int>(report.rigid_body.base.size()) +
                                 friction::free_parameter_count(report.model.arm.friction.model);

  // The verdict is that of the worst part.
  report.outcome = report.rigid_body.outcome;
  report.message = "rigid body: " + report.rigid_body.message;
  for (std::size_t j = 0; j < report.joints.size(); ++j)
    if (report.joints[j].outcome > report.outcome) {
      report.outcome = report.joints[j].outcome;
      report.message = fmt::format("{}: {}", robot.joints[j].name, report.joints[j].message);
    }
  report.faults = faults_of(prepared, report);
  report.seconds = seconds_since(begin);
  report.model.budget = fmt::format("{} evaluations", evaluations);
  return report;
}

data::RowMatrix predict_torque(const Arm& arm, const Filtered& measured, double cutoff_hz) {
  const std::vector<double> z0 = initial_friction_state(
      arm, measured.dt, measured.q_wide, measured.v_wide, measured.tau, measured.temperature);
  data::RowMatrix tau_f = drive_friction(arm.friction, measured.dt, measured.q_wide,
                                         measured.v_wide, measured.tau, measured.temperature, z0)
                              .tau_f;
  const ZeroPhaseButterworth low_pass(cutoff_hz, 1 / measured.dt);
  std::vector<double> work;
  Eigen::VectorXd column(tau_f.rows());
  for (Eigen::Index j = 0; j < tau_f.cols(); ++j) {
    column = tau_f.col(j);
    low_pass.apply(std::span<double>(column.data(), static_cast<std::size_t>(column.size())), work);
    tau_f.col(j) = column;
  }
  return tau_f + rigid_body_torque(arm.robot, arm.robot.pi, measured);
}

}  // namespace fricid::estimate
