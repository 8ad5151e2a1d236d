// Friction in MJCF's own words.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "fricid/base/error.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/deploy/c_header.hpp"
#include "fricid/system/driven_friction.hpp"
#include "fricid/system/transmission.hpp"
#include "mjcf.hpp"
#include "writers.hpp"

namespace fricid::deploy {
namespace {

using friction::JointSpec;
using friction::LawSpec;
using friction::RobotFriction;
using friction::Role;

constexpr std::string_view kStartElsewhere =
    "springs that yield are relaxed at q = 0 and would move an arm that starts elsewhere. In "
    "Python, after each time that d.qpos is set:\n"
    "    mujoco.mj_forward(m, d)\n"
    "    for a, length in zip(m.tendon_plasticadr, d.ten_length):\n"
    "        if a >= 0: d.plastic[a : a + 2] = length";

/// A fixed tendon with a spring that yields: one element of a Maxwell slip bank.
struct Spring {
  double stiffness;  ///< [N m/rad]
  double level;      ///< torque at which it slips [N m]
};
/// A dcmotor without input: LuGre with constant damping.
struct Bristle {
  double sigma0, sigma1, Fc, Fs, vs;
};
/// The friction of a joint as MJCF says it.
struct Native {
  double damping = 0, frictionloss = 0;
  std::vector<Spring> springs;
  std::vector<Bristle> bristles;
};

/// One law of a joint with its modifiers and parameters.
struct JointLaw {
  LawSpec spec;
  std::vector<double> theta;
  double fastest;  ///< [rad/s] of the joint

  /// The parameter of a role; element: 1, 2, ... where each element has one.
  double operator()(Role role, int element = 0) const {
    const auto infos = friction::parameters_of_law(spec.law, spec.elements);
    for (std::size_t i = 0; i < infos.size(); ++i)
      if (infos[i].role == role && infos[i].element == element) return theta[i];
    throw std::logic_error(fmt::format("{} lacks a parameter", spec.law));
  }
  /// Its sum over the elements.
  double sum(Role role) const {
    double total = 0;
    for (int i = 1; i <= spec.elements; ++i) total += (*this)(role, i);
    return total;
  }
};

void add_coulomb_viscous(const JointLaw& law, Native& native) {
  native.frictionloss += law(Role::kCoulomb);
  native.damping += law(Role::kViscous);
}

void add_viscous(const JointLaw& law, Native& native) { native.damping += law(Role::kViscous); }

void add_dahl(const JointLaw& law, Native& native) {
  native.bristles.push_back(
      {law(Role::kStiffness), 0, law(Role::kCoulomb), law(Role::kCoulomb), 1});
  native.damping += law(Role::kViscous);
}

void add_lugre(const JointLaw& law, Native& native) {
  native.bristles.push_back({law(Role::kStiffness), law(Role::kDamping), law(Role::kCoulomb),
                             law(Role::kStatic), law(Role::kStribeckVelocity)});
  native.damping += law(Role::kViscous);
}

void add_maxwell_slip(const JointLaw& law, Native& native) {
  for (int i = 1; i <= law.spec.elements; ++i)
    native.springs.push_back({law(Role::kStiffness, i), law(Role::kLevel, i)});
}

// Springs of the level Fc, and a bristle for what the curve of Stribeck has above it: together they
// begin as stiff as the elements and slip at Fs.
void add_gms(const JointLaw& law, Native& native) {
  const double Fc = law(Role::kCoulomb), Fs = std::max(law(Role::kStatic), Fc),
               shares = law.sum(Role::kShare);
  for (int i = 1; i <= law.spec.elements; ++i)
    native.springs.push_back(
        {law(Role::kStiffness, i) * Fc / Fs, law(Role::kShare, i) / shares * Fc});
  constexpr double kLeast = 1e-6;  // of Fs: the bristle needs a level at all speeds
  if (Fs > (1 + kLeast) * Fc)
    native.bristles.push_back({law.sum(Role::kStiffness) * (1 - Fc / Fs), 0, kLeast * Fs, Fs - Fc,
                               law(Role::kStribeckVelocity)});
  native.damping += law(Role::kViscous);
}

void add_prandtl_ishlinskii(const JointLaw& law, Native& native) {
  const double shares = law.sum(Role::kShare);
  for (int i = 1; i <= law.spec.elements; ++i)
    native.springs.push_back(
        {law(Role::kStiffness, i), law(Role::kShare, i) / shares * law(Role::kCoulomb)});
  native.damping += law(Role::kViscous);
}

RobotFriction alone(const LawSpec& spec) { return RobotFriction({JointSpec{{spec}}}); }

// Level and damping that are closest to the steady curve, at speeds up to the fastest, of which the
// slow are more.
void fit_steady(const JointLaw& law, double& level, double& damping) {
  constexpr int kSpeeds = 40;
  const RobotFriction friction = alone(law.spec);
  double n = 0, sum_v = 0, sum_vv = 0, sum_t = 0, sum_tv = 0, tau = 0;
  for (int i = 1; i <= kSpeeds; ++i)
    for (const double direction : {-1.0, 1.0}) {
      const double v = law.fastest * std::pow(static_cast<double>(i) / kSpeeds, 2);
      const std::vector<friction::Input<double>> in{{0, direction * v, 0, kRoomTemperature}};
      friction.steady_torque<double>(law.theta, in, {&tau, 1});
      n += 1, sum_v += v, sum_vv += v * v, sum_t += direction * tau, sum_tv += direction * tau * v;
    }
  damping = std::max(0.0, (n * sum_tv - sum_v * sum_t) / (n * sum_vv - sum_v * sum_v));
  level = std::max(0.0, (sum_t - damping * sum_v) / n);
  if (level == 0) damping = std::max(0.0, sum_tv / sum_vv);
}

// Torque over travel from rest, slowly, as a share of the last: at travels that grow evenly on a
// logarithmic scale.
std::vector<std::pair<double, double>> virgin_curve(const JointLaw& law) {
  constexpr double kShortest = 1e-5, kLongest = 0.1;  // [rad]
  constexpr int kKnots = 9, kSteps = 40;              // steps from one knot to the next
  const RobotFriction friction = alone(law.spec);
  std::vector<double> z(static_cast<std::size_t>(friction.state_size()));
  const double v = 1e-3 * law.fastest;
  double q = 0, tau = 0;
  std::vector<std::pair<double, double>> curve;
  for (int i = 0; i < kKnots; ++i) {
    const double to = kShortest * std::pow(kLongest / kShortest, i / (kKnots - 1.0));
    const double dq = (to - q) / kSteps;
    for (int s = 0; s < kSteps; ++s) {
      q += dq;
      const std::vector<friction::Input<double>> in{{q, v, 0, kRoomTemperature}};
      friction.step<double>(law.theta, in, dq / v, z);
      friction.torque<double>(law.theta, in, z, {&tau, 1});
    }
    curve.emplace_back(q, tau);
  }
  for (auto& [travel, torque] : curve) torque /= tau;
  return curve;
}

// Springs whose virgin curve is the least concave one above the law's.
void add_bank(const JointLaw& law, double level, Native& native) {
  std::vector<std::pair<double, double>> hull{{0, 0}};
  const auto slope = [](const auto& a, const auto& b) {
    return (b.second - a.second) / (b.first - a.first);
  };
  for (const auto& point : virgin_curve(law)) {
    while (hull.size() > 1 &&
           slope(hull.back(), point) >= slope(hull[hull.size() - 2], hull.back()))
      hull.pop_back();
    if (point.second > hull.back().second) hull.push_back(point);
  }
  const double top = hull.back().second;
  for (std::size_t i = 1; i < hull.size(); ++i) {
    const double next = i + 1 < hull.size() ? slope(hull[i], hull[i + 1]) : 0;
    const double stiffness = (slope(hull[i - 1], hull[i]) - next) * level / top;
    if (stiffness > 0) native.springs.push_back({stiffness, stiffness * hull[i].first});
  }
}

// Any law: its steady curve as a line, what it does before sliding as a bank of springs.
void add_fitted(const JointLaw& law, Native& native) {
  double level = 0, damping = 0;
  fit_steady(law, level, damping);
  native.damping += damping;
  if (alone(law.spec).state_size() > 0 && level > 0)
    add_bank(law, level, native);
  else
    native.frictionloss += level;
}

void add_none(const JointLaw&, Native&) {}

void add(const JointLaw& law, Native& native) {
  static const std::map<std::string_view, void (*)(const JointLaw&, Native&)> kKnown{
      {"none", add_none},
      {"viscous", add_viscous},
      {"coulomb_viscous", add_coulomb_viscous},
      {"dahl", add_dahl},
      {"lugre", add_lugre},
      {"lugre_classic", add_lugre},
      {"maxwell_slip", add_maxwell_slip},
      {"gms", add_gms},
      {"prandtl_ishlinskii", add_prandtl_ishlinskii}};
  const auto known = law.spec.modifiers.empty() ? kKnown.find(law.spec.law) : kKnown.end();
  if (known == kKnown.end())
    add_fitted(law, native);
  else
    known->second(law, native);
}

double fastest(const dynamics::Joint& joint) {
  constexpr double kUsual = 3;  // [rad/s] where no limit is given
  return joint.velocity > 0 ? joint.velocity : kUsual;
}

std::vector<Native> natives_of(const data::ModelFile& model) {
  const friction::Friction& friction = model.arm.friction;
  std::vector<Native> natives(model.arm.robot.joints.size());
  for (std::size_t j = 0; j < friction.model.joints().size(); ++j) {
    auto theta = friction.theta.begin() + friction.model.parameter_begin(static_cast<int>(j));
    for (const LawSpec& spec : friction.model.joints()[j].laws) {
      const int size = alone(spec).parameter_count();
      add({spec, {theta, theta + size}, fastest(model.arm.robot.joints[j])}, natives[j]);
      theta += size;
    }
  }
  return natives;
}

/// The same as laws of the table.
friction::Friction as_laws(const std::vector<Native>& natives) {
  constexpr double kSmoothing = 1e-5;  // [rad/s] of frictionloss, which has none
  std::vector<JointSpec> joints;
  std::vector<double> theta;
  for (const Native& native : natives) {
    JointSpec& joint = joints.emplace_back();
    joint.laws.push_back({"coulomb_viscous", 0, {}});
    theta.insert(theta.end(), {native.frictionloss, native.damping, kSmoothing});
    for (const Spring& spring : native.springs) {
      joint.laws.push_back({"maxwell_slip", 1, {}});
      theta.insert(theta.end(), {spring.stiffness, spring.level});
    }
    for (const Bristle& b : native.bristles) {
      joint.laws.push_back({"lugre_classic", 0, {}});
      theta.insert(theta.end(), {b.Fc, b.Fs, b.vs, b.sigma0, b.sigma1, 0});
    }
  }
  return {RobotFriction(std::move(joints)), std::move(theta)};
}

Motion usual_motion(const dynamics::RobotModel& robot) {
  constexpr int kSteps = 8000;
  constexpr double kDt = 1e-3, kLoad = 0.2, kUsualEffort = 50;  // load as a share of the effort
  const auto n = static_cast<Eigen::Index>(robot.joints.size());
  Motion motion{.name = "reversals, rests and sliding",
                .dt = kDt,
                .q = RowMatrix::Zero(kSteps, n),
                .v = RowMatrix::Zero(kSteps, n),
                .load = RowMatrix::Zero(kSteps, n)};
  for (Eigen::Index j = 0; j < n; ++j) {
    const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    const double effort = joint.effort > 0 ? joint.effort : kUsualEffort;
    double q = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double t = k * kDt;
      const double size = 0.5 * fastest(joint) * std::pow(10, -3 + 3.0 * k / kSteps);
      const double shape = std::sin(6 * t) + 0.7 * std::sin(19 * t) + 0.2 * std::cos(77 * t);
      const double v = k % 1000 >= 900 ? 0 : size * shape;
      motion.q(k, j) = q += kDt * v;
      motion.v(k, j) = v;
      motion.load(k, j) = kLoad * effort * std::sin(5 * t);
    }
  }
  return motion;
}

Xml attributes_of(const Native& native) {
  Xml text;
  if (native.damping > 0) text += Xml::of(" damping=\"{:.17g}\"", native.damping);
  if (native.frictionloss > 0) text += Xml::of(" frictionloss=\"{:.17g}\"", native.frictionloss);
  return text;
}

Xml bank_of(const dynamics::RobotModel& robot, int motor, const Native& native) {
  Xml text;
  for (std::size_t i = 0; i < native.springs.size(); ++i) {
    const Spring& spring = native.springs[i];
    text += Xml::of("<fixed name={} stiffness=\"{:.17g}\" springyield=\"{:.17g}\">\n{}</fixed>\n",
                    xml_attribute(fmt::format("friction {} of {}", i + 1,
                                              robot.joints[static_cast<std::size_t>(motor)].name)),
                    spring.stiffness, spring.level / spring.stiffness, motor_angle(robot, motor));
  }
  return text;
}

Xml bristles_of(const dynamics::RobotModel& robot, int motor, const Native& native) {
  Xml text;
  const std::string& joint = robot.joints[static_cast<std::size_t>(motor)].name;
  for (std::size_t i = 0; i < native.bristles.size(); ++i) {
    const Bristle& b = native.bristles[i];
    text += Xml::of(
        "<dcmotor name={} {} input=\"none\" motorconst=\"0\" resistance=\"1\" lugre=\"{:.17g} "
        "{:.17g} {:.17g} {:.17g} {:.17g}\"/>\n",
        xml_attribute(fmt::format("friction {} of {}", i + 1, joint)),
        turns_alone(robot, motor) ? Xml::of("joint={}", xml_attribute(joint))
                                  : Xml::of("tendon={}", xml_attribute(motor_name(robot, motor))),
        b.sigma0, b.sigma1, b.Fc, b.Fs, b.vs);
  }
  return text;
}

double rms(const RowMatrix& values, Eigen::Index j) {
  return std::sqrt(values.col(j).squaredNorm() / static_cast<double>(values.rows()));
}

}  // namespace

Motion motion_of(const signals::Dataset& joints, const dynamics::RobotModel& robot) {
  const signals::Dataset log = Transmission(robot).to_motors(joints);
  Eigen::Index T = 0;
  while (T < log.q.rows() && log.q.row(T).allFinite() && log.tau.row(T).allFinite()) ++T;
  Motion motion{.name = log.name,
                .dt = log.dt(),
                .q = log.q.topRows(T),
                .v = RowMatrix::Zero(T, log.q.cols()),
                .load = log.tau.topRows(T)};
  if (log.v.size() > 0 && log.v.topRows(T).allFinite())
    motion.v = log.v.topRows(T);
  else if (T > 2)
    motion.v.middleRows(1, T - 2) =
        (motion.q.bottomRows(T - 2) - motion.q.topRows(T - 2)) / (2 * motion.dt);
  if (log.temperature.size() > 0 && log.temperature.topRows(T).allFinite())
    motion.temperature = log.temperature.topRows(T);
  return motion;
}

Exported write_mjcf_friction(const data::ModelFile& model, const Motion* held_out) {
  const dynamics::RobotModel& robot = model.arm.robot;
  const RobotFriction& friction = model.arm.friction.model;
  if (friction.has_whole())
    throw UserError(
        "{}: mjcf_friction cannot represent {}, a network over all joints; allowed: plugin, c, "
        "fmu, onnx",
        model.name, friction.whole().law);

  const std::vector<Native> natives = natives_of(model);
  MjcfExtras extras;
  Xml bristles;
  for (int k = 0; k < robot.n(); ++k) {
    const Native& native = natives[static_cast<std::size_t>(k)];
    extras.motor_attributes.push_back(attributes_of(native));
    extras.tendons += bank_of(robot, k, native);
    bristles += bristles_of(robot, k, native);
  }
  if (!bristles.empty()) extras.rest = Xml::of("<actuator>\n{}</actuator>\n", bristles);

  // what is lost, along the motion
  Exported exported{.files = {}, .losses = torques_left_out(robot, true)};
  const Motion motion = held_out ? *held_out : usual_motion(robot);
  const auto along = [&](const friction::Friction& driven) {
    return drive_friction(driven, motion.dt, motion.q, motion.v, motion.load, motion.temperature)
        .tau_f;
  };
  if (friction.joint_count() > 0) {
    const RowMatrix law = along(model.arm.friction), said = along(as_laws(natives));
    const RowMatrix error = said - law;
    for (int j = 0; j < robot.n(); ++j) {
      if (!(rms(error, j) > 1e-9 * rms(law, j))) continue;
      const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
      const std::string unit = unit_of_joint("N m", slides(joint));
      exported.losses.push_back(fmt::format(
          "{}, friction of {}: {:.3g} {} RMS from the law's {:.3g} {} RMS, along {}",
          code_name(model), joint.name, rms(error, j), unit, rms(law, j), unit, motion.name));
    }
  }
  for (const std::string& loss : exported.losses) extras.head += xml_comment(loss) + Xml::of("\n");
  if (!extras.tendons.empty()) {
    exported.notes.emplace_back(kStartElsewhere);
    for (std::string_view rest = kStartElsewhere; !rest.empty();) {  // a comment per line
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      extras.head += xml_comment(rest.substr(0, end)) + Xml::of("\n");
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    extras.head += xml_comment(
                       "springs that yield: integrator Euler, implicit or implicitfast; RK4 and "
                       "discrete let them yield differently") +
                   Xml::of("\n");
  }
  exported.files.push_back({code_name(model) + "_friction.xml", mjcf_text(model, extras)});
  return exported;
}

}  // namespace fricid::deploy
