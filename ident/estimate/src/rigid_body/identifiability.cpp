#include "fricid/estimate/rigid_body/identifiability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "friction/memory_seen.hpp"
#include "rigid_body/contradictions.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/regression_start.hpp"

namespace fricid::estimate {
namespace {

constexpr double kIdentified = 0.1, kWeak = 0.5;
constexpr double kConfused = 0.9;  // correlation worth a word
constexpr double kCertain = 3;     // standard errors below zero of friction
constexpr const char* kOfModifiers = " (modifier)";
constexpr const char* kConstantTorque = " constant torque";

// Names and columns of the unknowns: base parameters, then the friction that any row excites.
struct Unknowns {
  std::vector<int> columns;
  std::vector<std::string> names;
};

Unknowns unknowns_of(const dynamics::RobotModel& robot, const dynamics::BaseParameters& base,
                     const Regression& data) {
  Unknowns unknowns{base.columns, base.names};
  const int p = robot.parameter_count(), n = robot.n();
  const char* kinds[] = {"Coulomb friction", "viscous friction"};
  for (int kind = 0; kind < 2; ++kind)
    for (int j = 0; j < n; ++j) {
      const int column = p + kind * n + j;
      if (data.rows.col(column).squaredNorm() == 0) continue;
      unknowns.columns.push_back(column);
      unknowns.names.push_back(
          fmt::format("{} {}", robot.joints[static_cast<std::size_t>(j)].name, kinds[kind]));
    }
  return unknowns;
}

// Covariance without a prior, rows weighed by the noise of their joint.
Eigen::MatrixXd covariance_of(const Regression& data, const Unknowns& unknowns,
                              const Eigen::VectorXd& sigma) {
  const Eigen::MatrixXd X = data.rows(Eigen::all, unknowns.columns);
  Eigen::VectorXd weight(X.rows());
  for (Eigen::Index r = 0; r < X.rows(); ++r)
    weight[r] = std::pow(sigma[data.joint[static_cast<std::size_t>(r)]], -2);
  return invert(X.transpose() * weight.asDiagonal() * X, nullptr);
}

// "strongly correlated with A, B in these data": the most correlated others.
std::string confusion(Eigen::Index i, const Eigen::MatrixXd& covariance, const Unknowns& unknowns) {
  std::vector<std::pair<double, Eigen::Index>> others;
  for (Eigen::Index k = 0; k < covariance.cols(); ++k) {
    const double r = std::abs(covariance(i, k)) / std::sqrt(covariance(i, i) * covariance(k, k));
    if (k != i && r > kConfused) others.emplace_back(r, k);
  }
  if (others.empty()) return "its effect on the torque is too small in these data";
  std::sort(others.rbegin(), others.rend());
  std::string words = "in these data strongly correlated with ";
  for (std::size_t o = 0; o < std::min<std::size_t>(3, others.size()); ++o)
    words += (o ? ", " : "") + unknowns.names[static_cast<std::size_t>(others[o].second)];
  return words;
}

void judge_parameters(const dynamics::RobotModel& robot,
                      std::span<const signals::Recording> recordings,
                      const RigidBodyOptions& options, Identifiability& report) {
  const dynamics::BaseParameters base = dynamics::base_parameters(robot);
  RigidBodyFit fit = rigid_body_least_squares(robot, recordings, options);
  if (fit.sigma.size() == 0) {
    report.message = fit.message;
    return;
  }
  if (auto under_load = rigid_body_under_load(robot, recordings, options, fit))
    fit = *std::move(under_load);
  RigidBodyFit counts;
  const Regression data = stack(robot, recordings, options, nullptr, counts);
  const Unknowns unknowns = unknowns_of(robot, base, data);
  const Eigen::MatrixXd covariance = covariance_of(data, unknowns, fit.sigma);

  const auto b = static_cast<Eigen::Index>(base.columns.size());
  const int n = robot.n(), p = robot.parameter_count();
  for (std::size_t i = 0; i < unknowns.columns.size(); ++i) {
    const int column = unknowns.columns[i], j = (column - p) % n;
    const auto at = static_cast<Eigen::Index>(i);
    ParameterVerdict v{.name = unknowns.names[i]};
    if (at < b) {
      const bool shows = data.rows.col(column).squaredNorm() > 0;
      for (const dynamics::LinearTorque& torque : robot.linear_torques)
        if (v.name == torque.name && torque.shape == dynamics::LinearTorque::Shape::kConstant)
          v.name = robot.joints[static_cast<std::size_t>(torque.joint)].name + kConstantTorque;
      if (!shows && v.name != unknowns.names[i]) continue;
      v.value = fit.base[at];
      v.standard_error = shows ? fit.base_se[at] : std::numeric_limits<double>::infinity();
      v.size = fit.base_size[at];
    } else {
      const bool coulomb = column < p + n;
      v.value = (coulomb ? fit.Fc : fit.Fv)[j];
      v.standard_error = (coulomb ? fit.Fc_se : fit.Fv_se)[j];
      v.size = std::max(std::abs(v.value), fit.friction_size[column - p]);
    }
    v.verdict = judge(v.standard_error, v.size);
    if (at >= b && fit.moves_at_one_speed(j)) {
      v.verdict = Verdict::kNot;
      const auto& [slow, fast] = fit.speeds[static_cast<std::size_t>(j)];
      v.words = fmt::format("all its sliding is at one speed, {:.2g} to {:.2g}", slow, fast);
    } else if (at >= b && v.value < -kCertain * v.standard_error) {
      v.verdict = Verdict::kNot;
      v.words = "negative: friction falls with the speed here, or another torque looks like it";
    } else if (v.verdict != Verdict::kIdentified) {
      v.words = confusion(at, covariance, unknowns);
    }
    report.parameters.push_back(v);
  }
  report.growth_of = fit.growth_of;
  for (int j = 0; j < n; ++j)
    if (fit.shows_growth(j))
      report.parameters.push_back(
          {.name = fmt::format("{}{}", robot.joints[static_cast<std::size_t>(j)].name,
                               kFrictionPerTorque),
           .value = fit.growth[j],
           .standard_error = fit.growth_se[j],
           .size = fit.growth[j],
           .verdict = judge(fit.growth_se[j], fit.growth[j]),
           .words = {}});
}

/// What the regression of a fit finds beside parameters.
void look_at_fit(const dynamics::RobotModel& robot, std::span<const signals::Recording> recordings,
                 const RigidBodyOptions& options, Identifiability& report) {
  const RigidBodyFit fit = rigid_body_least_squares(robot, recordings, options);
  report.without_inertia = fit.without_inertia;
  for (const Fault& fault : find_contradictions(robot, recordings, options, fit))
    report.doubts.push_back(in_words(fault));
  const FrictionTorques target = friction_target(robot, fit.pi, recordings, 1);
  report.couplings = find_couplings(recordings, target);
  for (int j = 0; j < robot.n(); ++j)
    report.joints[static_cast<std::size_t>(j)].memory =
        fit.Fc.size() == robot.n() && shows_memory(recordings, target, fit, j, options.cutoff_hz);
}

void group_parameters(const dynamics::RobotModel& robot, Identifiability& report) {
  const dynamics::BaseParameters base = dynamics::base_parameters(robot);
  const std::vector<std::string> names = robot.parameter_names();
  for (int k = 0; k < robot.parameter_count(); ++k) {
    const std::string& name = names[static_cast<std::size_t>(k)];
    std::vector<std::string> hosts;
    for (Eigen::Index i = 0; i < base.K.rows(); ++i)
      if (base.K(i, k) != 0) hosts.push_back(base.names[static_cast<std::size_t>(i)]);
    if (hosts.empty())
      report.groupings.push_back({name, "no effect on any torque of this robot"});
    else if (hosts.size() > 1 || hosts[0] != name)
      report.groupings.push_back({name, fmt::format("only within {}", fmt::join(hosts, "; "))});
  }
}

// A travel below this share of that in which friction climbs is the sensor's noise.
constexpr double kNoise = 0.03;

/// Turns of joint j in one recording. @param made_up  see `beside_missing`
void count_turns(const signals::Recording& s, const std::vector<bool>& made_up, int j,
                 const IdentifiabilityOptions& options, Coverage& c, std::vector<double>& climbs) {
  double last_turn = s.wide.q(0, j);
  int climb = -1;     // samples since the last turn while friction climbs
  double before = 0;  // last speed that was not zero
  for (int k = 1; k < s.length(); ++k) {
    if (made_up[static_cast<std::size_t>(k)]) {
      last_turn = s.wide.q(k, j);
      climb = -1;
      before = 0;
      continue;
    }
    const double v = s.wide.v(k, j);
    if (climb >= 0) {
      ++climb;
      if (std::abs(s.wide.q(k, j) - last_turn) > options.presliding) {
        climbs.push_back(climb);
        climb = -1;
      }
    }
    const bool turns = v * before < 0;
    if (v != 0) before = v;
    const double travel = std::abs(s.wide.q(k, j) - last_turn);
    if (!turns || travel < kNoise * options.presliding) continue;
    (travel > options.presliding ? c.reversals : c.presliding) += 1;
    last_turn = s.wide.q(k, j);
    climb = 0;
  }
}

/// @param joint    j of the robot
/// @param options  of joints that turn
Coverage cover(std::span<const signals::Recording> recordings, const dynamics::Joint& joint, int j,
               IdentifiabilityOptions options) {
  options.stribeck_speed *= dynamics::travel_scale(joint);
  options.presliding *= dynamics::travel_scale(joint);
  const double moving = 1e-3 * dynamics::travel_scale(joint);  // [rad/s or m/s]
  const double infinity = std::numeric_limits<double>::infinity();
  Coverage c{.slides = slides(joint),
             .load_low = infinity,
             .load_high = -infinity,
             .temperature_low = infinity,
             .temperature_high = -infinity,
             .resolution = infinity};
  std::vector<double> climbs;
  for (const signals::Recording& s : recordings) {
    const std::vector<bool> made_up = signals::beside_missing(s.log, options.rigid_body.cutoff_hz);
    for (int k = 0; k < s.length(); ++k) {
      if (made_up[static_cast<std::size_t>(k)]) continue;
      const double speed = std::abs(s.narrow.v(k, j));
      c.fastest = std::max(c.fastest, speed);
      if (speed > moving && speed < options.stribeck_speed) c.slow_s += s.dt;
    }
    c.load_low = std::min(c.load_low, s.filtered_tau.col(j).minCoeff());
    c.load_high = std::max(c.load_high, s.filtered_tau.col(j).maxCoeff());
    if (s.log.temperature.size() > 0) {
      c.temperature_low = std::min(c.temperature_low, s.temperature.col(j).minCoeff());
      c.temperature_high = std::max(c.temperature_high, s.temperature.col(j).maxCoeff());
    }
    if (s.step[j] > 0) c.resolution = std::min(c.resolution, s.step[j]);
    count_turns(s, made_up, j, options, c, climbs);
  }
  if (!climbs.empty()) {
    const auto middle = climbs.begin() + static_cast<std::ptrdiff_t>(climbs.size() / 2);
    std::nth_element(climbs.begin(), middle, climbs.end());
    c.samples_per_climb = *middle;
  }
  return c;
}

// One demand of a family on the data of a joint.
struct Demand {
  const char* words;
  bool (*met)(const Coverage&);
  bool of_memory = false;  // so that a law with a memory can be fitted: needless where one was seen
};

constexpr Demand kSpeeds{"speeds up to 0.2 rad/s (0.02 m/s) or more",
                         [](const Coverage& c) { return c.fastest >= (c.slides ? 0.02 : 0.2); }};
constexpr Demand kTurns{"2 reversals or more", [](const Coverage& c) { return c.reversals >= 2; }};
constexpr Demand kSlow{"half a second below the Stribeck speed",
                       [](const Coverage& c) { return c.slow_s >= 0.5; }};
constexpr Demand kSlowOrMemory{kSlow.words, kSlow.met, true};
constexpr Demand kManyTurns{
    "4 reversals or more", [](const Coverage& c) { return c.reversals + c.presliding >= 4; }, true};
constexpr Demand kClimbs{"3 samples or more in presliding after a reversal",
                         [](const Coverage& c) { return c.samples_per_climb >= 3; }, true};
constexpr Demand kFine{"positions in steps of 0.1 mrad (0.01 mm) or less",
                       [](const Coverage& c) { return c.resolution <= (c.slides ? 1e-5 : 1e-4); },
                       true};
constexpr Demand kLoads{"torques of both signs, or over a wide range",
                        [](const Coverage& c) { return varies_enough(c.load_low, c.load_high); }};
constexpr Demand kWarming{"5 K of warming or more", [](const Coverage& c) {
                            return c.temperature_high - c.temperature_low >= 5;
                          }};

// Requirements on the data by the roles of a law's parameters.
struct Demands {
  std::vector<const Demand*> of_joints;
  bool learns = false;  // networks also need a length of data
};

bool operator==(const Demands& a, const Demands& b) {
  return a.of_joints == b.of_joints && a.learns == b.learns;
}

Demands demands_of_law(const std::vector<friction::ParameterInfo>& parameters) {
  using enum friction::Role;
  const auto any = [&](auto... roles) {
    return std::ranges::any_of(parameters,
                               [&](const auto& info) { return ((info.role == roles) || ...); });
  };
  const bool learns = any(kWeight);
  const bool remembers = learns || any(kStiffness, kLength);
  Demands demands{{&kSpeeds}, learns};
  if (remembers)
    demands.of_joints.insert(demands.of_joints.end(),
                             {&kSlowOrMemory, &kManyTurns, &kClimbs, &kFine});
  else
    demands.of_joints.push_back(&kTurns);
  if (!remembers && any(kStribeckVelocity)) demands.of_joints.push_back(&kSlow);
  if (any(kLoadCoefficient, kLoadGrowth)) demands.of_joints.push_back(&kLoads);
  return demands;
}

Demands demands_of_modifier(const std::vector<friction::ParameterInfo>& parameters) {
  using enum friction::Role;
  Demands demands;
  for (const auto& info : parameters) {
    if (info.role == kLoadGrowth) demands.of_joints.push_back(&kLoads);
    if (info.role == kTemperatureCoefficient) demands.of_joints.push_back(&kWarming);
  }
  return demands;
}

// Laws, then modifiers, those of equal demands in one family under all their names.
std::vector<std::pair<std::string, Demands>> families() {
  std::vector<std::pair<std::string, Demands>> found;
  const auto add = [&](std::size_t begin, std::string_view name, const Demands& demands) {
    const auto same = std::find_if(found.begin() + static_cast<std::ptrdiff_t>(begin), found.end(),
                                   [&](const auto& family) { return family.second == demands; });
    if (same == found.end())
      found.emplace_back(name, demands);
    else
      same->first += fmt::format(", {}", name);
  };
  for (const friction::LawInfo& law : friction::law_table())
    if (const auto parameters = friction::parameters_of_law(law.name, 1); !parameters.empty())
      add(0, law.name, demands_of_law(parameters));
  const std::size_t laws = found.size();
  for (const friction::LawInfo& modifier : friction::modifier_table()) {
    const Demands demands = demands_of_modifier(friction::parameters_of_modifier(modifier.name, 1));
    if (!demands.of_joints.empty()) add(laws, modifier.name, demands);
  }
  for (std::size_t i = laws; i < found.size(); ++i) found[i].first += kOfModifiers;
  return found;
}

void judge_families(const dynamics::RobotModel& robot, double seconds, Identifiability& report) {
  constexpr double kLearning = 30;  // [s] of data for networks
  for (const auto& [family, demands] : families()) {
    FamilyVerdict verdict{family, true, ""};
    for (const Demand* demand : demands.of_joints) {
      std::string joints;
      for (std::size_t j = 0; j < report.joints.size(); ++j)
        if (const Coverage& of_joint = report.joints[j]; !demand->met(of_joint)) {
          joints += " " + robot.joints[j].name;
          verdict.supported = verdict.supported && demand->of_memory && of_joint.memory;
        }
      if (joints.empty()) continue;
      verdict.words += fmt::format("{}{} lacking on{}", verdict.words.empty() ? "" : "; ",
                                   demand->words, joints);
    }
    if (demands.learns && seconds < kLearning) {
      verdict.words += fmt::format("{}{:.0f} s of data, {:.0f} s or more needed",
                                   verdict.words.empty() ? "" : "; ", seconds, kLearning);
      verdict.supported = false;
    }
    if (verdict.supported && !verdict.words.empty())
      verdict.words += "; held-out torque shows a memory all the same: its parameters are weak";
    report.families.push_back(verdict);
  }
  const auto is_modifier = [](const FamilyVerdict& f) { return f.family.ends_with(kOfModifiers); };
  if (std::ranges::any_of(report.families,
                          [&](const FamilyVerdict& f) { return f.supported && !is_modifier(f); }))
    return;
  for (FamilyVerdict& f : report.families)
    if (is_modifier(f) && f.supported) f.supported = false, f.words = "no law can be fitted";
}

}  // namespace

bool varies_enough(double low, double high) {
  return high - low >= 0.5 * std::max(std::abs(low), std::abs(high));
}

Verdict judge(double standard_error, double size) {
  if (!(standard_error < kWeak * size)) return Verdict::kNot;
  return standard_error < kIdentified * size ? Verdict::kIdentified : Verdict::kWeak;
}

Identifiability examine_data(const dynamics::RobotModel& robot,
                             std::span<const signals::Recording> recordings,
                             const IdentifiabilityOptions& options) {
  Identifiability report;
  const RegressionStart start = start_of_regression(robot, options.rigid_body);
  RigidBodyOptions alone = start.options;
  alone.prior.use = alone.prior_where_needed = false;
  judge_parameters(start.robot, recordings, alone, report);
  group_parameters(start.robot, report);
  double seconds = 0;
  for (const signals::Recording& s : recordings)
    seconds += s.dt * static_cast<double>(std::ranges::count(
                          signals::beside_missing(s.log, options.rigid_body.cutoff_hz), false));
  for (int j = 0; j < robot.n(); ++j) {
    report.joints.push_back(
        cover(recordings, robot.joints[static_cast<std::size_t>(j)], j, options));
  }
  look_at_fit(start.robot, recordings, start.options, report);
  judge_families(robot, seconds, report);
  return report;
}

Eigen::MatrixXd base_information(const dynamics::RobotModel& robot,
                                 std::span<const signals::Recording> recordings, double cutoff_hz) {
  const std::vector<int> columns = dynamics::base_parameters(robot).columns;
  const auto b = static_cast<Eigen::Index>(columns.size());
  const auto n = static_cast<std::size_t>(robot.n());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(b, b), Y(robot.n(), robot.parameter_count()),
                  Y_b(robot.n(), b);
  dynamics::Workspace<double> ws(robot);
  for (const signals::Recording& s : recordings) {
    const std::vector<bool> made_up = signals::beside_missing(s.log, cutoff_hz);
    for (int k = 0; k < s.length(); ++k) {
      if (made_up[static_cast<std::size_t>(k)]) continue;
      dynamics::regressor(robot, ws, {s.narrow.q.row(k).data(), n}, {s.narrow.v.row(k).data(), n},
                          {s.narrow.a.row(k).data(), n}, Y);
      for (Eigen::Index c = 0; c < b; ++c) Y_b.col(c) = Y.col(columns[static_cast<std::size_t>(c)]);
      for (int j = 0; j < robot.n(); ++j)
        if (const double effort = robot.joints[static_cast<std::size_t>(j)].effort; effort > 0)
          Y_b.row(j) /= effort;
      H.noalias() += s.dt * (Y_b.transpose() * Y_b);
    }
  }
  return H;
}

}  // namespace fricid::estimate
