#include "fricid/estimate/fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/data/training_part.hpp"
#include "fricid/estimate/friction/motion_errors.hpp"
#include "fricid/system/driven_friction.hpp"
#include "fricid/system/initial_state.hpp"
#include "fricid/system/transmission.hpp"
#include "rigid_body/contradictions.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/regression_start.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr int kPasses = 2;             // friction, rigid body with friction removed, friction again
constexpr double kMemoryOfAShape = 1;  // memory_periods once a law describes the reversals
constexpr double kSmoothing = 0.01;    // [rad/s]
constexpr double kNoisySpeed = 3;      // standard deviations

// The robot that is fitted: a constant torque at every joint that has none takes up sensor offsets
// and friction that differs between the directions, which no odd law can represent.
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

/// Where the search for a law begins: the linear friction of the regression, a hundredth of the
/// largest torque at least.
friction::FrictionGuess guess_of(const RigidBodyFit& rigid, const JointFrictionData& data, int j) {
  return {std::max(rigid.Fc[j], 0.01 * data.largest_target()), std::max(rigid.Fv[j], 0.0)};
}

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

}  // namespace

Temperatures temperatures_of(std::span<const signals::Recording> recordings) {
  double sum = 0, square = 0, count = 0;
  for (const signals::Recording& r : recordings) {
    sum += r.temperature.sum();
    square += r.temperature.squaredNorm();
    count += static_cast<double>(r.temperature.size());
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, square / count - mean * mean))};
}

friction::JointSpec joint_spec_of(const ModelOptions& config) {
  const auto law_of = [&](std::string_view name, int elements,
                          const std::vector<std::string>& modifiers) -> friction::LawSpec {
    for (const friction::LawInfo& law : friction::law_table())
      if (law.name == name)
        return {std::string(name), law.has_elements ? elements : 0, modifiers_of(modifiers)};
    std::string known = "simple";
    for (const friction::LawInfo& law : friction::law_table())
      known += fmt::format(", {}", law.name);
    throw UserError("model {}: unknown law \"{}\"; known: {}", config.name, name, known);
  };
  friction::JointSpec joint;
  for (const LawOptions& law : config.laws)
    joint.laws.push_back(law_of(law.law, law.elements, law.modifiers));
  if (!joint.laws.empty()) return joint;
  const std::string_view given = config.law.empty() ? config.name : config.law;
  joint.laws.push_back(
      law_of(given == "simple" ? "coulomb_viscous" : given, config.elements, config.modifiers));
  return joint;
}

FrictionTorques friction_target(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                                std::span<const signals::Recording> sequences, int jobs) {
  FrictionTorques target(sequences.size());
  parallel_for(static_cast<int>(sequences.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    target[s] = sequences[s].filtered_tau - rigid_body_torque(robot, pi, sequences[s]);
  });
  return target;
}

std::vector<signals::Recording> recordings_of(const dynamics::RobotModel& robot,
                                              std::span<const data::Dataset> logs, double cutoff_hz,
                                              int jobs) {
  const Transmission motors(robot);
  std::vector<signals::Recording> recordings(logs.size());
  parallel_for(static_cast<int>(logs.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    recordings[s] = signals::make_recording(motors.to_motors(logs[s]), cutoff_hz);
  });
  return recordings;
}

RegressionStart start_of_regression(const dynamics::RobotModel& robot, RigidBodyOptions options) {
  dynamics::Nominal nominal = dynamics::complete(robot);
  options.guesses = std::move(nominal.guesses);
  options.offset = false;  // the robot has them
  return {with_offsets(std::move(nominal.robot)), std::move(options)};
}

namespace {

// Rates that differ by less are one: clocks do, and a speed is then off by as much.
constexpr double kOneRate = 1e-3;

// What brings two recordings to one rate.
std::string to_one_rate(const data::Dataset& a, const data::Dataset& b) {
  constexpr double kAlike = 0.01;
  const bool a_is_faster = a.rate_hz > b.rate_hz;
  const data::Dataset& faster = a_is_faster ? a : b;
  const double ratio = faster.rate_hz / (a_is_faster ? b : a).rate_hz;
  if (ratio < 1 + kAlike)
    return fmt::format("if both were sampled alike, give both even times of {:.5g} Hz",
                       std::round(a.rate_hz));
  const double whole = std::round(ratio);
  if (std::abs(ratio - whole) < kAlike * whole)
    return fmt::format("filter {} and keep one row in {:g}, or fit it in a scene of its own",
                       faster.name, whole);
  return "resample one of them, or fit each in a scene of its own";
}

}  // namespace

namespace {

// Rests of a joint tell nothing of its friction where the noise of its encoder (one standard
// deviation) or a step is worth this share of it: then its torque wanders while nothing is seen to
// move.
constexpr double kUnseen = 1.0 / 60;
constexpr double kRestingShare = 0.02;  // of the rows, that matters

/// Rows at rest go in joints whose bristles are too stiff for the encoder, by the stiffness of a
/// Dahl law fitted to the others.
void leave_out_rests(Prepared& prepared, int jobs) {
  if (prepared.rigid_body.Fc.size() != prepared.robot.n()) return;  // nothing moves
  const double cutoff = prepared.options.cutoff_hz;
  std::vector<signals::Recording> moving = prepared.recordings;
  Eigen::ArrayXd used = Eigen::ArrayXd::Zero(prepared.robot.n()), left = used, noise = used;
  for (signals::Recording& r : moving) {
    used += r.use.cast<double>().colwise().sum().transpose();
    r.use = r.use && !signals::at_rest(r, cutoff);
    left += r.use.cast<double>().colwise().sum().transpose();
    noise = noise.max(r.noise_sd.cwiseMax(r.step).array());
  }
  if ((left > (1 - kRestingShare) * used).all()) return;
  const friction::RobotFriction one({friction::JointSpec{{{"dahl", 0, {}}}}});
  const FrictionTorques target =
      friction_target(prepared.robot, prepared.rigid_body.pi, prepared.recordings, jobs);
  parallel_for(prepared.robot.n(), jobs, [&](int j) {
    if (left[j] > (1 - kRestingShare) * used[j]) return;
    const JointFrictionData data(moving, target, j, cutoff, offset_prior(prepared.rigid_body, j));
    if (data.rows() == 0) return;
    const std::vector<double> start =
        friction::start_from(one, guess_of(prepared.rigid_body, data, j));
    const std::vector<double> theta = fit_joint_friction(data, one, start, {}).theta;
    const auto value = [&](friction::Role role) {
      return theta[static_cast<std::size_t>(friction::find_parameter(one, 0, role))];
    };
    if (value(friction::Role::kStiffness) * noise[j] < kUnseen * value(friction::Role::kCoulomb))
      return;
    for (std::size_t s = 0; s < moving.size(); ++s)
      prepared.recordings[s].use.col(j) = moving[s].use.col(j);
  });
}

}  // namespace

Prepared prepare(const dynamics::RobotModel& robot, const RigidBodyOptions& options,
                 std::span<const data::Dataset> train, int jobs) {
  if (train.empty()) throw UserError("no training data");
  for (const data::Dataset& d : train) {
    if (d.n() != robot.n())
      throw UserError("{}: {} joints, the robot has {}", d.name, d.n(), robot.n());
    if (std::abs(d.rate_hz / train.front().rate_hz - 1) > kOneRate)
      throw UserError("{}: {:.7g} Hz, and {} {:.7g} Hz; allowed: one rate in a scene: {}", d.name,
                      d.rate_hz, train.front().name, train.front().rate_hz,
                      to_one_rate(d, train.front()));
  }
  Prepared out;
  const data::TrainingPart part = data::training_part(train);
  if (!part.is_all())
    out.fitted_to = {part.seconds, part.of_seconds, static_cast<int>(part.recordings.size())};
  out.recordings = recordings_of(robot, part.recordings, options.cutoff_hz, jobs);
  RegressionStart start = start_of_regression(robot, options);
  out.robot = std::move(start.robot);
  out.options = std::move(start.options);
  out.rigid_body = rigid_body_least_squares(out.robot, out.recordings, out.options);
  out.contradictions = find_contradictions(out.robot, out.recordings, out.options, out.rigid_body);
  for (const JointInertia& found : out.rigid_body.without_inertia) {
    const int k = out.robot.armature_begin() + found.joint;
    out.robot.pi[k] = out.rigid_body.pi[k];  // held there in further fits too
  }
  leave_out_rests(out, jobs);
  out.under_load = rigid_body_under_load(out.robot, out.recordings, out.options, out.rigid_body);
  if (out.under_load) {
    widen_errors(*out.under_load, out.rigid_body);
    out.rigid_body.lacks_growth = true;
  }
  if (out.rigid_body.Fc.size() != robot.n())
    throw UserError("{}: {}; allowed: training data in which the arm moves", robot.name,
                    out.rigid_body.message);
  return out;
}

std::vector<std::string> FitReport::doubts() const {
  std::vector<std::string> lines;
  for (const Fault& fault : faults) lines.push_back(in_words(fault));
  if (lines.empty() && !usable()) lines.push_back(message);
  return lines;
}

std::string FitReport::brief() const {
  double sum = 0, finite = 0;
  for (const double value : r2)
    if (std::isfinite(value)) sum += value, finite += 1;
  const std::string explained =
      finite > 0 ? fmt::format("R2 {:.4f} on training torque", sum / finite) : "no finite torque";
  return fmt::format("{} seed {}: {}{}, {}, {} parameters, {:.1f} s{}", model.name, model.seed,
                     usable() ? "" : "NOT TO BE TRUSTED: ", name_of(outcome), explained,
                     model.free_parameters, seconds,
                     fitted_to ? ", fitted to " + data::in_words(*fitted_to) : "");
}

double smoothing_speed(const dynamics::RobotModel& robot,
                       std::span<const signals::Recording> recordings, double cutoff_hz,
                       int joint) {
  constexpr int kFrequencies = 1000;  // of the sum over the band
  double noise = 0;
  for (const signals::Recording& r : recordings) {
    // white noise of the position through the wide band and the central difference
    const double rate = 1 / r.dt;
    const signals::ZeroPhaseButterworth low_pass(signals::wide_band(cutoff_hz, rate), rate);
    double variance = 0;
    for (int i = 0; i < kFrequencies; ++i) {
      const double f = (i + 0.5) / kFrequencies * rate / 2;
      const double slope = low_pass.gain(f) * std::sin(2 * std::numbers::pi * f * r.dt) / r.dt;
      variance += slope * slope / kFrequencies;
    }
    noise = std::max(noise, r.noise_sd[joint] * std::sqrt(variance));
  }
  const dynamics::Joint& of = robot.joints[static_cast<std::size_t>(joint)];
  return std::max(kSmoothing * dynamics::travel_scale(of), kNoisySpeed * noise);
}

FitReport fit_conventional(const Prepared& prepared, const ModelOptions& config, int seed,
                           int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const dynamics::RobotModel& robot = prepared.robot;
  const int n = robot.n();
  const double cutoff = prepared.options.cutoff_hz;
  const friction::JointSpec joint_spec = joint_spec_of(config);
  const friction::RobotFriction one({joint_spec});
  const bool linear = is_linear(one, 0) && prepared.rigid_body.Fc_beside.size() == n;

  FitReport report;
  report.fitted_to = prepared.fitted_to;
  report.model.name = config.name;
  report.model.label = config.label.empty() ? config.name : config.label;
  report.model.seed = seed;
  report.model.arm.robot = robot;
  report.model.arm.friction.model = friction::RobotFriction(
      std::vector<friction::JointSpec>(static_cast<std::size_t>(n), joint_spec));
  const RigidBodyFit& rigid = prepared.rigid_body_of(one);
  report.rigid_body = rigid;
  report.joints.resize(static_cast<std::size_t>(n));
  report.residual_rms.resize(static_cast<std::size_t>(n));
  for (std::vector<double>* of_joints : {&report.r2, &report.sliding_r2, &report.resting_rms})
    of_joints->resize(static_cast<std::size_t>(n));

  const int passes = linear ? 1 : kPasses;  // linear friction and rigid body are one regression
  Progress progress(fmt::format("fit {}", report.model.label), passes * n);
  FrictionTorques friction_torque(prepared.recordings.size());
  for (std::size_t s = 0; s < friction_torque.size(); ++s)
    friction_torque[s].resize(prepared.recordings[s].length(), n);

  std::vector<signals::Recording> loaded;
  if (one.reads_load()) loaded = under_linear_load(prepared, jobs);
  const std::span<const signals::Recording> recordings =
      loaded.empty() ? prepared.recordings : loaded;
  const double temperature = temperatures_of(prepared.recordings).mean;
  std::optional<MotionErrors> motion;
  if (!linear) motion.emplace(recordings, cutoff, jobs);
  int evaluations = 0;
  for (int pass = 0; pass < passes; ++pass) {
    if (pass > 0) {
      RigidBodyOptions options = as_needed(prepared.options, rigid);
      options.memory_periods = kMemoryOfAShape;
      report.rigid_body = beside_law(
          rigid_body_least_squares(robot, prepared.recordings, options, &friction_torque), rigid);
    }
    const FrictionTorques target =
        friction_target(robot, report.rigid_body.pi, prepared.recordings, jobs);
    report.couplings = find_couplings(prepared.recordings, target);
    std::vector<double> share(static_cast<std::size_t>(n));
    parallel_for(n, jobs, [&](int j) {
      const auto i = static_cast<std::size_t>(j);
      const JointFrictionData data(recordings, target, j, cutoff, offset_prior(rigid, j));
      FrictionFitOptions options;
      options.seed = static_cast<std::uint64_t>(seed);
      options.stream = static_cast<std::uint64_t>(j);
      options.starts = pass == 0 ? config.starts : 1;
      options.grows = rigid.shows_growth(j);
      if (motion && pass + 1 == passes)
        options.motion_error = [&](std::span<const double> theta) {
          return motion->of(data, j, one, theta, data.used_rows());
        };
      std::vector<double> start =
          pass == 0 ? friction::start_from(one, guess_of(rigid, data, j)) : report.joints[i].theta;
      // Coulomb friction is that at the temperature of the log, not at one that is fitted
      for (std::size_t p = 0; p < start.size(); ++p)
        if (one.parameters()[p].info.role == friction::Role::kTemperature) {
          start[p] = temperature;
          options.held.push_back(p);
        }
      report.joints[i] = linear ? linear_fit(prepared, data, one, j)
                                : fit_joint_friction(data, one, start, options);
      const PerSample f = data.predict(one, report.joints[i].theta);
      for (std::size_t s = 0; s < f.size(); ++s)
        friction_torque[s].col(j) = Eigen::VectorXd::Map(f[s].data(), std::ssize(f[s]));
      share[i] = 1 - report.joints[i].explained;
      progress.advance(1);
    });
    double mean = 0;
    for (const double value : share) mean += value / n;
    for (const JointFrictionFit& joint : report.joints) evaluations += joint.evaluations;
    report.objective.push_back(mean);

    // Residual and explained variance of the whole torque.
    for (int j = 0; j < n; ++j)
      score_joint(
          prepared.recordings, j, report.rigid_body.least_speed[static_cast<std::size_t>(j)],
          [&](std::size_t s, int k) { return target[s](k, j) - friction_torque[s](k, j); }, report);
  }

  if (prepared.under_load && !linear) widen_errors(*prepared.under_load, report.rigid_body);
  widen_errors(rigid, one, report.joints);
  report.model.arm.robot.pi = report.rigid_body.pi;
  for (const JointFrictionFit& joint : report.joints)
    report.model.arm.friction.theta.insert(report.model.arm.friction.theta.end(),
                                           joint.theta.begin(), joint.theta.end());
  report.model.free_parameters = static_cast<int>(report.rigid_body.base.size()) +
                                 friction::free_parameter_count(report.model.arm.friction);

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

RowMatrix predict_torque(const Arm& arm, const signals::Recording& measured, double cutoff_hz) {
  const std::vector<double> z0 =
      initial_friction_state(arm, measured.dt, measured.wide.q, measured.wide.v,
                             measured.filtered_tau, measured.temperature);
  const signals::ZeroPhaseButterworth low_pass(cutoff_hz, 1 / measured.dt);
  const RowMatrix rigid = rigid_body_torque(arm.robot, arm.robot.pi, measured);
  return rigid + drive_under_own_load(arm.friction, measured.dt, measured.wide.q, measured.wide.v,
                                      rigid, measured.temperature, z0,
                                      [&](RowMatrix& tau_f) { low_pass.apply(tau_f); })
                     .tau_f;
}

}  // namespace fricid::estimate
