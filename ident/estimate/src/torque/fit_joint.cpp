#include "torque/fit_joint.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "assumed_noise.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/estimate/couplings.hpp"
#include "fricid/estimate/prior.hpp"
#include "fricid/estimate/torque/carry_over.hpp"
#include "fricid/estimate/torque/joint_fit.hpp"
#include "fricid/estimate/torque/networks.hpp"
#include "fricid/estimate/torque/sum_fit.hpp"
#include "fricid/estimate/torque/sum_start.hpp"
#include "fricid/friction/laws/memory_network.hpp"
#include "friction/ripple_search.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/regression_start.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

// Conventional laws that the sum has to beat, the linear one first.
constexpr std::pair<const char*, int> kRivals[] = {
    {"coulomb_viscous", 0}, {"stribeck", 0}, {"dahl", 0}, {"lugre", 0}, {"gms", 4}};
constexpr double kLost = 10;  // a law is lost beyond this many held-out torque errors of the sum
// Choices of parts: another one where the load of the last moved by so much of it.
constexpr int kMostChoices = 3;
constexpr double kLoadOfAnother = 0.05;
constexpr double kNetworksGain = 1.25;  // rollouts of the best law over those of networks
constexpr double kPoor = 1e-3;          // held-out torque error of a sum: no law of it is exact
constexpr int kDraws = 39;              // of arms, for bands
constexpr double kNear = 3;  // times the least held-out error: windows may turn the order round

/// Base parameters of a robot that was fitted together with its friction.
void take_base_of(const ArmErrors& errors, const dynamics::RobotModel& robot, RigidBodyFit& fit) {
  if (errors.root.size() == 0 || fit.base.size() == 0) return;
  fit.base = fit.base_physical = fit.base_of_pi * robot.pi;
  fit.base_se = (fit.base_of_pi * errors.root.topRows(robot.pi.size())).rowwise().norm();
}

/// A law that knows no load, where friction grows with it: errors contain what the load moves in
/// the regression, see `widen_errors`.
void add_error_of_load(const Prepared& prepared, const Arm& arm, ArmErrors& errors,
                       RigidBodyFit& fit) {
  const friction::RobotFriction& model = arm.friction.model;
  if (!prepared.under_load || model.reads_load() || errors.root.size() == 0) return;
  const RigidBodyFit &with = *prepared.under_load, &without = prepared.rigid_body;
  if (with.base.size() == fit.base_se.size())
    fit.base_se =
        (fit.base_se.array().square() + (without.base - with.base).array().square()).sqrt();
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(errors.root.rows(), arm.robot.n());
  const auto move = [&](int joint, friction::Role role, double by) {
    if (const int p = friction::find_parameter(model, joint, role); p >= 0)
      moved(arm.robot.pi.size() + p, joint) = by;
  };
  for (int j = 0; j < arm.robot.n(); ++j) {
    move(j, friction::Role::kCoulomb, with.Fc[j] - without.Fc[j]);
    move(j, friction::Role::kViscous, with.Fv[j] - without.Fv[j]);
  }
  const Eigen::Index before = errors.before_motion;
  Eigen::MatrixXd root(errors.root.rows(), errors.root.cols() + moved.cols());
  root << errors.root.leftCols(before), moved, errors.root.rightCols(errors.root.cols() - before);
  errors.root = std::move(root);
  errors.before_motion += moved.cols();
}

/// The arm of the method conventional, if it has a result.
std::optional<Arm> arm_of(ConventionalFits& fits, const char* law, int seed, int jobs) {
  ModelOptions config;
  config.name = config.law = law;
  const FitReport report = fits.fit(config, seed, jobs);
  if (!report.has_result()) return std::nullopt;
  return report.model.arm;
}

Arm roughly_fitted(JointFits& fits, const Arm& start) {
  return fits
      .under_own_load(
          fits.on_torque(start, JointFits::Rows::kTraining, WaveSearch::kGears, kRoughGain).arm,
          JointFits::Rows::kTraining, kRoughGain)
      .arm;
}

/// `start`, or fitted again from cables where it has single springs and the held-out torque is then
/// explained better.
Arm with_soft_springs(JointFits& fits, const Arm& start) {
  bool any = false;
  for (int j = 0; j < fits.n(); ++j)
    any = any || single_spring(start.friction.model, j).has_value();
  Arm soft = start;
  if (!any || !start_cables(fits.promising_cables(start), soft.friction)) return start;
  soft = fits.on_torque_of_springs(soft);
  if (fits.held_out_torque(soft) < fits.held_out_torque(start)) return soft;
  fits.take_springs_of(start);
  return start;
}

/// `with`, fitted roughly with the prior, or what is fitted from `start` where held-out torque
/// contradicts the prior, which is then forgotten.
Arm without_wrong_prior(JointFits& fits, const Arm& with, const Arm& start) {
  const double error = fits.held_out_torque(with);
  const ArmPrior prior = *fits.prior();
  fits.take_prior(std::nullopt);
  const Arm without = roughly_fitted(fits, start);
  if (!fits.keeps_prior(error, fits.held_out_torque(without))) return without;
  fits.take_prior(prior);
  fits.take_load_of(with);
  return with;
}

/// Candidates for the model that contains the laws: the sum, and conventional laws, fitted like it
/// and, where that comes near or costs nothing, by the method conventional too.
/// @param rough          of the sum
/// @param evidence_near  for the parts of a sum near the regression
std::vector<Candidate> of_sum(ConventionalFits& conventional, JointFits& fits, const Arm& rough,
                              int seed, std::vector<friction::LvmParts>& parts,
                              std::vector<PartEvidence>& evidence,
                              std::vector<PartEvidence>& evidence_near, Progress& progress) {
  std::vector<Candidate> found;
  const auto add = [&](Candidate candidate) {
    progress.advance(1, fmt::format("{} {:.2e} rad2", candidate.name, candidate.held_out));
    found.push_back(std::move(candidate));
  };
  const auto add_rival = [&](Candidate candidate) {
    candidate.rival = true;
    add(std::move(candidate));
  };
  const auto search = [&](std::vector<friction::LvmParts>& of, std::vector<PartEvidence>& why) {
    Candidate sum;
    sum.arm = rough;
    for (int choice = 0; choice < kMostChoices; ++choice) {
      sum = fit_sum(fits, sum.arm, of, why);
      if (!sum.arm.friction.model.reads_load()) break;
      const JointFits::UnderOwnLoad settled = fits.under_own_load(sum.arm, JointFits::Rows::kAll);
      sum = fits.judged(sum.name, settled.arm, sum.seconds);
      if (settled.moved < kLoadOfAnother || fits.is_short()) break;
    }
    return sum;
  };
  const Candidate sum = search(parts, evidence);
  add(sum);
  if (fits.is_short() && !fits.prior() && sum.torque > kPoor) {
    std::vector<friction::LvmParts> parts_near;
    fits.pull_to_regression(true);
    Candidate near = search(parts_near, evidence_near);
    fits.pull_to_regression(false);
    fits.take_load_of(sum.arm);
    near.name = "sum near the regression";
    near.near_regression = true;
    add(std::move(near));
  }
  const std::size_t first_rival = found.size();
  for (const auto& [law, elements] : kRivals) {
    const auto begin = std::chrono::steady_clock::now();
    const Arm start = fits.start(friction::JointSpec{{{law, elements, {}}}});
    Arm arm = fits.on_torque(start, JointFits::Rows::kAll, WaveSearch::kNone, kRoughGain).arm;
    if (fits.held_out_torque(arm) < kLost * found[0].torque)
      arm = fits.on_torque(arm, JointFits::Rows::kAll, WaveSearch::kNone).arm;
    if (const std::optional<Arm> rising = with_rising_curves(arm, start)) {
      const Arm other = fits.on_torque(*rising, JointFits::Rows::kAll, WaveSearch::kNone).arm;
      if (fits.held_out_torque(other) < fits.held_out_torque(arm)) arm = other;
    }
    add_rival(fits.judged(law, arm, seconds_since(begin)));
  }
  const double near = kNear * std::ranges::min_element(found, {}, &Candidate::held_out)->held_out;
  for (std::size_t i = 0; i < std::size(kRivals); ++i) {
    const bool linear = i == 0;  // which is one regression, without rows near standstill
    if (found[first_rival + i].held_out > near && !linear) continue;
    const auto begin = std::chrono::steady_clock::now();
    const char* law = kRivals[i].first;
    if (const std::optional<Arm> arm = arm_of(conventional, law, seed, fits.jobs()))
      add_rival(fits.judged(fmt::format("{}, conventional", law), *arm, seconds_since(begin)));
  }
  return found;
}

/// Where the search for the friction of a model begins: fitted roughly, from the prior where there
/// is one that the data do not contradict.
Arm start_of(JointFits& fits, const ModelOptions& options, const dynamics::RobotModel& robot,
             bool sum) {
  const Arm own = sum ? fits.start(fits.all_parts()) : fits.start(joint_spec_of(options));
  if (!options.prior.empty()) {
    fits.take_prior(ArmPrior{load_prior(options.prior, robot), options.prior_sd});
    if (!sum && !fits.is_like_prior(own))
      throw UserError("{}: other laws than those of model {}; allowed as a prior: the same ones",
                      options.prior, options.name);
  }
  const Arm start = roughly_fitted(fits, fits.prior() ? fits.prior()->arm : own);
  if (sum) return start;
  return with_soft_springs(fits, fits.prior() ? without_wrong_prior(fits, start, own) : start);
}

/// All linear viscous friction in the power law: a fit that ends with c at zero leaves p without a
/// gradient. @return whether a joint has one
bool put_viscous_friction_in_power_laws(const Arm& unfitted, Arm& arm) {
  using enum friction::Role;
  bool any = false;
  for (int j = 0; j < arm.robot.n(); ++j) {
    const auto of = [j](auto& friction, friction::Role role) {
      const int p = friction::find_parameter(friction.model, j, role);
      return p < 0 ? nullptr : &friction.theta[static_cast<std::size_t>(p)];
    };
    double* const c = of(arm.friction, kPowerViscous);
    if (!c) continue;
    *c = std::max(*c, *of(unfitted.friction, kPowerViscous));
    *of(arm.friction, kExponent) = 1;
    if (double* const Fv = of(arm.friction, kViscous)) *c += std::exchange(*Fv, 0);
    any = true;
  }
  return any;
}

/// Speeds that ended at a limit of the lvm beyond it, and Stribeck curves wider or narrower: a soft
/// bristle hides them. @return whether any moves
bool move_speeds(Arm& arm) {
  constexpr double kAtLimit = 1.01, kBeyond = 4;
  bool any = false;
  for (const Limit& limit : sum_limits(arm)) {
    const friction::ParameterInfo& info = arm.friction.model.parameters()[limit.parameter].info;
    double& value = arm.friction.theta[limit.parameter];
    const bool is_curve = info.role == friction::Role::kStribeckVelocity,
               is_speed = is_curve || info.role == friction::Role::kSmoothingSpeed;
    const bool low = value<kAtLimit * limit.lower, high = kAtLimit * value> limit.upper;
    if (!is_speed || limit.lower == limit.upper || !(low || high || is_curve)) continue;
    const bool up = high || (!low && value < info.typical);
    value = std::clamp(up ? kBeyond * value : value / kBeyond, info.lower, info.upper);
    any = true;
  }
  return any;
}

/// Where else a fit of laws may begin: waves over the joint angle unknown, of any order; viscous
/// friction in power laws; other speeds; and gaps that closed open. Nothing where the laws have
/// none of these.
std::optional<Arm> another_start(const JointFits& fits, Arm fitted) {
  constexpr double kOpenGap = 3e-4;  // half of it [rad]
  const Arm unfitted = fits.start(fitted.friction.model.joints());
  const std::vector<std::size_t> waves = ripple_terms(fitted.friction.model);
  for (const std::size_t term : waves) fitted.friction.theta[ripple_amplitude(term)] = 0;
  const bool has_power_law = put_viscous_friction_in_power_laws(unfitted, fitted);
  const std::optional<Arm> rising = with_rising_curves(fitted, unfitted);
  const bool has_speeds = move_speeds(fitted);
  if (rising) fitted = *rising;
  const Arm open = with_open_gaps(fitted, kOpenGap);
  const bool any =
      !waves.empty() || has_power_law || has_speeds || open.friction.theta != fitted.friction.theta;
  return any ? std::optional<Arm>(open) : std::nullopt;
}

/// Of two fits of the same laws: each joint with the friction that leaves less of its torque.
Arm better_of(JointFits& fits, const Arm& first, const Arm& second,
              const std::vector<double>& rms_of_first) {
  constexpr double kBetterFit = 0.999;  // root mean square of the residual
  std::vector<const Arm*> of_joint;
  for (int j = 0; j < fits.n(); ++j)
    of_joint.push_back(fits.residual_rms(second, j) <
                               kBetterFit * rms_of_first[static_cast<std::size_t>(j)]
                           ? &second
                           : &first);
  if (std::ranges::count(of_joint, &first) == std::ssize(of_joint)) {
    fits.take_springs_of(first);
    return first;
  }
  const Arm start = joined(of_joint, first);
  fits.take_springs_of(start);
  return fits.on_torque(start, JointFits::Rows::kAll, WaveSearch::kNone).arm;
}

/// The laws of a scene, fitted from two starts, and from a third where a bristle and a single
/// spring have changed places; each joint keeps the better.
Candidate of_laws(JointFits& fits, const Arm& start) {
  const auto begin = std::chrono::steady_clock::now();
  Arm best = fits.on_torque(start, JointFits::Rows::kAll).arm;
  const auto rms = [&] {
    std::vector<double> of_joint;
    for (int j = 0; j < fits.n(); ++j) of_joint.push_back(fits.residual_rms(best, j));
    return of_joint;
  };
  if (const std::optional<Arm> other = another_start(fits, best))
    best = better_of(fits, best,
                     fits.on_torque(*other, JointFits::Rows::kAll, WaveSearch::kAll).arm, rms());
  if (const std::optional<Arm> other = with_springs_in_place(best)) {
    const std::vector<double> before = rms();
    best = better_of(fits, best, fits.on_torque_of_springs(*other), before);
  }
  return fits.judged("torque", fits.under_own_load(best, JointFits::Rows::kAll).arm,
                     seconds_since(begin));
}

/// Whether two candidates are of the same laws.
bool are_of_one_law(const Candidate& a, const Candidate& b) {
  return std::ranges::equal(a.arm.friction.model.parameters(), b.arm.friction.model.parameters(),
                            friction::is_same);
}

/// Adds what windows make of the candidates that are near the best; of a law that was fitted in two
/// ways, of the better one.
void add_windows(JointFits& fits, std::string_view label, std::vector<Candidate>& found) {
  const std::vector<Candidate> fitted = found;
  const double near = kNear * std::ranges::min_element(fitted, {}, &Candidate::held_out)->held_out;
  for (const Candidate& candidate : fitted) {
    const bool has_better_twin = std::ranges::any_of(fitted, [&](const Candidate& other) {
      return other.held_out < candidate.held_out && are_of_one_law(candidate, other);
    });
    if (candidate.held_out > near || has_better_twin) continue;
    fits.pull_to_regression(candidate.near_regression);
    found.push_back(fits.on_windows(candidate, label));
  }
  fits.pull_to_regression(false);
}

/// Adds candidates with networks where they promise something. @return the candidate to take
std::size_t add_networks(const JointFits& fits, std::string_view label, std::size_t taken,
                         const std::vector<friction::LvmParts>& parts,
                         std::vector<Candidate>& found, std::vector<PartEvidence>& evidence) {
  const std::optional<Candidate> with =
      fit_networks(fits, found[taken].arm, found[0].arm, parts, evidence);
  if (with) {
    found.push_back(*with);
    found.push_back(fits.on_windows(*with, label));
    const std::size_t best = found.size() - 2 + choose(std::span(found).last(2));
    if (kNetworksGain * found[best].held_out < found[taken].held_out ||
        explains_far_more(found[best], found[taken]))
      taken = best;
  }
  return taken;
}

/// How the candidate was found, and what it is not.
std::string message_of(const JointFits& fits, const Candidate& taken, std::size_t candidates,
                       bool sum) {
  std::string message = fmt::format("{} of {} candidates, held-out error {:.2e} rad2", taken.name,
                                    candidates, taken.held_out);
  if (const double period = fits.periods().longest_s; period > 0)
    message += fmt::format(
        "; of motion that repeats (after {:.3g} s at most) the end of each period is held out",
        period);
  if (sum && fits.is_short())
    message += fmt::format(
        "; less than {:.0f} s are held out: no cable was looked for, and parts may be on or off by "
        "chance",
        kFewSeconds);
  return message;
}

/// The arm as each fold gives it, by the recordings that it leaves out.
std::vector<FitWithout> cross_fits(const JointFits& fits, const Arm& fitted) {
  std::vector<FitWithout> without;
  const std::vector<Arm> folds = fits.cross_fit(fitted);
  for (std::size_t f = 0; f < folds.size(); ++f)
    for (std::size_t i = 0; i < fits.periods().recordings.size(); ++i)
      if (const auto stretch = fits.folds()[f].left_out_of(static_cast<int>(i))) {
        const Origin from = fits.periods().origins[i];
        without.push_back({fits.periods().recordings[i].log.name,
                           {from.recording, from.begin + stretch->begin, from.begin + stretch->end},
                           folds[f]});
      }
  return without;
}

/// The law that explains most of the torque, whose parts do not stand for a torque that bends; the
/// arm that was taken where there is none.
const Arm& strongest_law(const std::vector<Candidate>& found, const Candidate& taken) {
  const auto of_laws = [](const Candidate& c) { return c.rival ? c.torque : kInfinity; };
  const auto law = std::ranges::min_element(found, {}, of_laws);
  return law->rival ? law->arm : taken.arm;
}

}  // namespace

Arm load_prior(const std::string& file, const dynamics::RobotModel& robot) {
  const data::ModelFile model = data::load_model(file);
  const auto joints_of = [](const dynamics::RobotModel& of) {
    return fmt::format("{}", fmt::join(of.joint_names(), ", "));
  };
  const std::string found = joints_of(model.arm.robot), own = joints_of(robot);
  if (found != own)
    throw UserError("{}: joints {}; allowed as a prior: those of this robot, {}", file, found, own);
  const Eigen::Index fitted = start_of_regression(robot, {}).robot.pi.size();
  if (model.arm.robot.pi.size() != fitted)
    throw UserError(
        "{}: a rigid body of {} parameters; allowed as a prior: {}, those of this robot", file,
        model.arm.robot.pi.size(), fitted);
  const auto is_sum = [](const friction::JointSpec& joint) {
    return !joint.laws.empty() && std::ranges::all_of(joint.laws, [](const friction::LawSpec& law) {
      return !friction::is_learned(law.law) || law.law == friction::MemoryNetwork::kName;
    });
  };
  const friction::RobotFriction& friction = model.arm.friction.model;
  if (!std::ranges::all_of(friction.joints(), is_sum))
    throw UserError("{}: friction of {}; allowed as a prior: an lvm or a sum of laws", file,
                    model.name);
  Arm arm{robot, model.arm.friction};
  arm.robot.pi = model.arm.robot.pi;
  for (const std::size_t term : ripple_terms(arm.friction.model))  // at other phases in each arm
    arm.friction.theta[ripple_amplitude(term)] = 0;
  return arm;
}

FitReport fit_joint(ConventionalFits& conventional, const ModelOptions& options, int seed,
                    int jobs) {
  const Prepared& prepared = conventional.prepared();
  const auto begin = std::chrono::steady_clock::now();
  FitReport report = empty_report(prepared, options, seed);
  report.method = Method::kJoint;
  const std::string& label = report.model.label;
  MultiStepOptions windows = options.train;
  windows.seed = static_cast<std::uint64_t>(seed);
  const bool sum = options.laws.empty() && options.law == friction::kLvm;
  JointFits fits(prepared, windows, jobs);
  const Arm start = start_of(fits, options, prepared.robot, sum);

  Progress progress(fmt::format("fit {}", label),
                    sum ? 3 + 2 * static_cast<int>(std::size(kRivals)) : 1);
  std::vector<Candidate>& found = report.candidates;
  std::vector<friction::LvmParts> parts;
  std::vector<PartEvidence> evidence_near;
  if (sum) {
    found = of_sum(conventional, fits, start, seed, parts, report.parts, evidence_near, progress);
  } else {
    found.push_back(of_laws(fits, start));
    progress.advance(1);
  }
  const bool room = fits.has_room_for_windows();
  if (room) add_windows(fits, label, found);
  std::size_t taken = choose(found);
  if (sum && options.networks && room && !fits.is_short()) {
    taken = add_networks(fits, label, taken, parts, found, report.parts);
    progress.advance(1);
  }
  Candidate& best = found[taken];
  best.taken = true;
  report.model.arm = best.arm;
  if (best.near_regression) {
    report.parts = evidence_near;
    fits.pull_to_regression(true);
    fits.take_load_of(best.arm);
  }
  for (PartEvidence& part : report.parts)  // that was judged in the sum, or beside it
    part.on = friction::has(friction::parts_of(best.arm.friction, part.joint), part.part);
  report.rigid_body = prepared.rigid_body_of(best.arm.friction.model);
  report.model.budget = fmt::format("{} candidates", found.size());
  report.model.free_parameters =
      best.parameters + static_cast<int>(prepared.rigid_body.base.size());
  report.message = message_of(fits, best, found.size(), sum);
  if (!options.prior.empty() && !fits.is_like_prior(found.front().arm))
    report.prior_left_out = "the prior is left out: held-out torque contradicts it";
  if (!std::isfinite(best.held_out) || !best.arm.robot.pi.allFinite()) {
    report.outcome = Outcome::kFailed;
    return report;
  }
  report.outcome = Outcome::kConverged;
  report.without = cross_fits(fits, best.arm);
  report.errors = fits.errors_of(best.arm, kDraws, static_cast<std::uint64_t>(seed));
  take_base_of(report.errors, best.arm.robot, report.rigid_body);
  add_error_of_load(prepared, best.arm, report.errors, report.rigid_body);
  report.waves = fits.waves_of(best.arm);
  report.spots = fits.spots_of(best.arm);
  report.bends = fits.bends_of(strongest_law(found, best));
  report.couplings = find_couplings(
      prepared.recordings,
      friction_target(prepared.robot, prepared.rigid_body.pi, prepared.recordings, jobs));
  score_torque(prepared, prepared.options.cutoff_hz, jobs, report);
  report.model.noise = assumed_noise(report.model.arm, prepared, report.residual_rms);
  report.faults = faults_of(prepared, report);
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace fricid::estimate
