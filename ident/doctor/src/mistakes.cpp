// Columns of a log that are not what they are taken for: signs, swaps and units of torque.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "explained.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/dynamics/mount.hpp"
#include "hypothesis.hpp"
#include "mount.hpp"

namespace fricid::doctor {
namespace {

constexpr double kBothWays = 0.05;  // share of the sliding in the rarer direction
// What a hypothesis gains by chance in the few seconds in which a joint slides: of one joint, of
// the best of the many couplings that no file has, and of each joint under another gravity [s].
constexpr double kChance = 4, kChanceOfCoupling = 6, kChanceOfMount = 2;
constexpr double kUnderstood = 0.3;  // mean share unexplained where another mount is believed
constexpr double kWorseOfAll = 1.6;  // log of the factor by which one joint may become worse where
                                     // all are concerned
// A joint that is taken the wrong way round looks as if the mass of its link lay on the other side.
// Any other place of it leaves not much less then; where one leaves less than this share, the place
// in the file is wrong.
constexpr double kMirrored = 0.5;
constexpr int kMistakes = 6;       // found one after the other
constexpr double kOfCoupling = 2;  // mistakes that motors coupled by a factor count as
constexpr double kFine =
    0.01;  // share unexplained of all joints beyond which no more is looked for
// Factors of the nominal torques that are no modelling error: of most joints alike, and of one,
// whose light link may be anything in a file.
constexpr double kFarOff = 8, kFarOffAlone = 30;
constexpr double kBeyondEffort = 10;  // root mean square of a torque over the effort limit

/// @param motors  of the robot; nullptr: none is known
std::vector<Hypothesis> hypotheses(const Transmission* motors, int n) {
  std::vector<Hypothesis> all;
  const bool with_robot = motors;
  if (motors && motors->coupled())
    for (const bool at_joints : {false, true})
      for (const auto& [moves, forces] : {std::pair{false, true}, {true, false}, {true, true}})
        all.push_back({FindingKind::kCoupled, moves, forces, -1, -1, 1, motors, at_joints});
  if (with_robot && n > 2)
    for (const auto& [moves, forces] : {std::pair{true, true}, {true, false}, {false, true}}) {
      all.push_back({FindingKind::kSwapped, moves, forces, -1});
      all.back().reversed = true;
    }
  for (int j = 0; j < n; ++j) {
    all.push_back({FindingKind::kSign, false, true, j, -1, -1});
    if (!with_robot) continue;
    all.push_back({FindingKind::kSign, true, false, j, -1, -1});
    all.push_back({FindingKind::kSign, true, true, j, -1, -1});
    for (int other = j + 1; other < n; ++other) {
      all.push_back({FindingKind::kSwapped, true, true, j, other});
      all.push_back({FindingKind::kSwapped, true, false, j, other});
      all.push_back({FindingKind::kSwapped, false, true, j, other});
    }
  }
  return all;
}

/// Several axes that turn the other way than taken, of few joints all sets of them: each alone may
/// make the others worse.
void add_axes(int n, std::vector<Hypothesis>& all) {
  constexpr int kFew = 7;
  const auto add = [&](std::vector<int> axes) {
    all.push_back({FindingKind::kSign, true, true, axes.front(), -1, -1});
    all.back().axes = std::move(axes);
  };
  if (n > kFew) {
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) add({i, j});
    return;
  }
  for (unsigned set = 1; set < 1U << static_cast<unsigned>(n); ++set) {
    std::vector<int> axes;
    for (int j = 0; j < n; ++j)
      if ((set >> static_cast<unsigned>(j) & 1U) != 0) axes.push_back(j);
    if (axes.size() > 1) add(std::move(axes));
  }
}

/// The arm with motors that its file does not couple.
struct CoupledArm {
  dynamics::RobotModel robot;
  Transmission motors;
};

/// Motors of neighbouring joints that turn, by the factors that wrists and belts have.
std::vector<CoupledArm> coupled_arms(const dynamics::RobotModel& robot) {
  std::vector<CoupledArm> arms;
  for (int j = 1; j < robot.n(); ++j) {
    if (slides(robot.joints[static_cast<std::size_t>(j)]) ||
        slides(robot.joints[static_cast<std::size_t>(j) - 1]))
      continue;
    for (const double factor : {1.0, 0.5, 0.25, 2.0})
      for (const double sign : {1.0, -1.0}) {
        dynamics::RobotModel coupled = robot;
        coupled.couplings = {{.joint = j, .motor = j - 1, .factor = sign * factor}};
        Transmission motors(coupled);
        arms.push_back({std::move(coupled), std::move(motors)});
      }
  }
  return arms;
}

/// Rows in the rarer direction of those at which a joint slides.
double rarer_rows(const Motion& motion, const Sight& sight, int j) {
  const std::vector<int>& rows = sight.rows[static_cast<std::size_t>(j)];
  const auto back = std::ranges::count_if(rows, [&](int k) { return motion.v(k, j) < 0; });
  return static_cast<double>(std::min(back, std::ssize(rows) - back));
}

/// Time in which a joint slides, twice that in the rarer direction [s]: the friction of one
/// direction alone is a constant torque.
double seconds_of(const data::Dataset& d, const Motion& motion, const Sight& sight, int j) {
  constexpr double kOneWay = 0.1;  // that time counts by itself
  const auto all = static_cast<double>(sight.rows[static_cast<std::size_t>(j)].size());
  return std::max({1.0, kOneWay * all, 2 * rarer_rows(motion, sight, j)}) / motion.length() *
         d.length() * d.dt();
}

/// Whether a joint slides in both directions: in one alone its friction is a constant torque, with
/// which many a mistake explains a slow log.
bool slides_both_ways(const Motion& motion, const Sight& sight, int j) {
  const auto all = static_cast<double>(sight.rows[static_cast<std::size_t>(j)].size());
  return rarer_rows(motion, sight, j) >= kBothWays * all;
}

/// The mistakes believed in, one after the other, under one direction of gravity.
struct Account {
  Sight sight;  ///< with the mistakes undone
  std::vector<Explained> explained;
  Findings mistakes;

  double unexplained() const {
    double sum = 0;
    for (const Explained& e : explained) sum += e.unexplained;
    return sum / static_cast<double>(explained.size());
  }
  double worst() const {
    return std::ranges::max(explained, {}, &Explained::unexplained).unexplained;
  }
  /// Log of what is left unexplained, a mistake counting as much as it must gain.
  double cost() const {
    return kBelief * static_cast<double>(mistakes.size()) + log_unexplained(explained);
  }
};

/// Whether the rigid body is what explains the torque of a joint.
bool tells(const Explained& e) {
  return e.scale > 0 && e.unexplained <= 0.5 && e.friction_only >= 3 * e.unexplained;
}

bool far_off(const Explained& e, double factor) {
  return tells(e) && std::max(e.scale, 1 / e.scale) >= factor;
}

/// Of most joints that tell.
bool mostly_far_off(const std::vector<Explained>& all) {
  const auto far = std::ranges::count_if(all, [](const auto& e) { return far_off(e, kFarOff); });
  return 2 * far > std::ranges::count_if(all, tells);
}

/// Whether the rigid body's torque of a joint is that of a mass such as its link has, a hand's
/// breadth from where the file has it: of a flange that carries something.
bool may_be_centre(const dynamics::RobotModel& robot, const Explained& e, int j) {
  constexpr double kReach = 0.1;     // [m]
  constexpr double kGravity = 9.81;  // [m/s^2]
  return e.scale > 1 && e.rigid < kGravity * kReach * robot.pi[10 * j];
}

/// Root mean square of a torque over the effort limit of its joint, where that is far beyond it; 0:
/// it is not, or limits that are all the same are nobody's.
double beyond_effort(const dynamics::RobotModel& robot, const Sight& sight, int j) {
  const double effort = robot.joints[static_cast<std::size_t>(j)].effort;
  const bool stated = std::ranges::any_of(
      robot.joints, [&](const dynamics::Joint& other) { return other.effort != effort; });
  if (!stated || !(effort > 0)) return 0;
  const double times =
      std::sqrt(sight.tau.col(j).squaredNorm() / static_cast<double>(sight.tau.rows())) / effort;
  return times > kBeyondEffort ? times : 0;
}

/// Two joints are not swapped where one then would carry next to nothing of its nominal torque, or
/// a multiple of it: so does a joint that stands still beside one that moves.
bool is_absurd(const Hypothesis& h, const std::vector<Explained>& after) {
  if (h.other < 0) return false;
  std::vector<Explained> others = after;
  bool far = false;
  for (const int j : {h.joint, h.other}) {
    far = far || far_off(after[static_cast<std::size_t>(j)], kFarOffAlone);
    others[static_cast<std::size_t>(j)] = {};
  }
  return far && !mostly_far_off(others);
}

/// A coupling of motors that the robot's file does not have, and what it gains.
struct FoundCoupling {
  Hypothesis hypothesis;
  double gained = 0;
};

/// What regressions leave, but no less than friction that no regression has leaves anyhow.
std::vector<Explained> not_finer(std::vector<Explained> explained) {
  constexpr double kFinest = 1e-3;  // share unexplained
  for (Explained& e : explained) e.unexplained = std::max(e.unexplained, kFinest);
  return explained;
}

/// The coupling that explains most, of those that do by more than `most` beyond what they need: of
/// motors whose columns the log has, of both or of the torque, or of joints. One that leaves next
/// to nothing of one joint alone is not that of two.
template <class Needs>
std::optional<FoundCoupling> find_coupling(std::span<const CoupledArm> arms, const Account& account,
                                           const Needs& needs, double most) {
  constexpr double kOfFiner = 0.1;  // that what is finer counts
  std::optional<FoundCoupling> found;
  double best = 0;
  for (const CoupledArm& arm : arms) {
    Judge judge(&arm.robot, arm.robot.n());
    const dynamics::Coupling& coupling = arm.robot.couplings.front();
    for (const auto& [moves, forces] : {std::pair{true, true}, {false, true}, {false, false}}) {
      const Hypothesis h{FindingKind::kCoupled, moves,           forces,     coupling.joint,
                         coupling.motor,        coupling.factor, &arm.motors};
      const std::vector<Explained> after = judge.explain(h.undone(account.sight));
      const double gained = gain(account.explained, after), needed = needs(h);
      if (gained - needed <= most) continue;
      const double told =
          gain(not_finer(account.explained), not_finer(after)) + kOfFiner * gained - needed;
      if (found && told <= best) continue;
      best = told;
      found = {h, gained};
    }
  }
  return found;
}

Finding describe_coupling(const data::Dataset& d, const Motion& motion,
                          const dynamics::RobotModel& robot, const FoundCoupling& coupling) {
  const Hypothesis& h = coupling.hypothesis;
  const auto name = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  Finding found = describe(d, motion, h, std::exp(coupling.gained), "");
  found.unit = fmt::format(
      "times less unexplained as columns of motors with [[coupling]] joint = \"{}\", motor = "
      "\"{}\", factor = {:.3g}",
      name(h.joint), name(h.other), h.factor);
  return found;
}

/// What a torque of such a scale may be in, in words.
std::string unit_of(double scale, const dynamics::Joint& joint) {
  constexpr double kAbout = 2;
  if (scale > 1e3 / kAbout && scale < 1e3 * kAbout) return slides(joint) ? ": in mN" : ": in N mm";
  if (scale > 1e-3 / kAbout && scale < 1e-3 * kAbout)
    return slides(joint) ? ": in kN" : ": in kN m";
  return {};
}

/// A hypothesis that is believed, as one finding or one for each axis or pair of columns.
void add_findings(Finding found, const Hypothesis& h, int n, Findings& findings) {
  if (h.reversed) {
    found.unit = "times less unexplained with all joints in reversed order";
    for (int j = 0; j < n - 1 - j; ++j) {
      found.joint = j;
      found.other = n - 1 - j;
      findings.push_back(found);
    }
    return;
  }
  found.unit = !h.axes.empty()
                   ? fmt::format("times less unexplained with {} axes turned", h.axes.size())
               : !h.coupled  ? "times less unexplained if undone"
               : h.at_joints ? "times less unexplained as columns of joints"
                             : "times less unexplained as columns of motors";
  if (h.axes.empty()) findings.push_back(found);
  for (const int j : h.axes) {
    found.joint = j;
    findings.push_back(found);
  }
}

Account account_for(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                    const Sight& sight) {
  Judge judge(robot, d.n());
  const std::optional<Transmission> motors =
      robot ? std::optional<Transmission>(*robot) : std::nullopt;
  std::vector<Hypothesis> all = hypotheses(motors ? &*motors : nullptr, d.n());
  Account account{sight, judge.explain(sight), {}};
  std::vector<CoupledArm> arms;
  if (motors && account.worst() > kFine) {
    add_axes(d.n(), all);
    if (!motors->coupled()) arms = coupled_arms(*robot);
  }
  const auto needs = [&](const Hypothesis& h) {
    double seconds = d.length() * d.dt();
    if (!h.reversed && !std::ranges::all_of(h.joints(), [&](int j) {
          return slides_both_ways(motion, account.sight, j);
        }))
      return kInfinity;
    for (const int j : h.joints()) seconds = std::min(seconds, seconds_of(d, motion, sight, j));
    const bool chosen = h.coupled && h.joint >= 0;  // of many that no file has
    const double mistakes = h.reversed ? d.n()
                            : chosen   ? kOfCoupling
                                       : std::max(1.0, static_cast<double>(h.axes.size()));
    return kBelief * mistakes + (chosen ? kChanceOfCoupling : kChance) / seconds;
  };
  const auto may_be_centres = [&](const Hypothesis& h, const std::vector<Explained>& after) {
    return std::ranges::any_of(h.joints(), [&](int j) {
      return judge.unexplained_with_centre(account.sight, j) <
             kMirrored * after[static_cast<std::size_t>(j)].unexplained;
    });
  };
  for (int mistake = 0; mistake < kMistakes; ++mistake) {
    double best = 0, most = 0;
    const Hypothesis* believed = nullptr;
    std::vector<Explained> then;
    for (const Hypothesis& h : all) {
      const std::vector<Explained> after = judge.explain(h.undone(account.sight));
      const double gained = gain(account.explained, after, h.reversed ? kWorseOfAll : kWorse),
                   beyond = gained - needs(h);
      if (beyond <= most || is_absurd(h, after)) continue;
      if (robot && h.mirrors() && may_be_centres(h, after)) continue;
      best = gained;
      most = beyond;
      believed = &h;
      then = after;
    }
    if (const auto coupled = find_coupling(arms, account, needs, most)) {
      // joints that coupled motors turn: friction alone is of another arm, and the fit says so
      if (coupled->hypothesis.forces)
        account.mistakes.push_back(describe_coupling(d, motion, *robot, *coupled));
      break;
    }
    if (!believed) break;
    account.sight = believed->undone(std::move(account.sight));
    account.explained = then;
    add_findings(describe(d, motion, *believed, std::exp(best), ""), *believed, d.n(),
                 account.mistakes);
  }
  return account;
}

}  // namespace

void undo_mistakes(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                   Sight& sight, Findings& findings) {
  Account best = account_for(d, robot, motion, sight);
  std::optional<Finding> mount;
  double chance = 0;
  for (int j = 0; j < d.n(); ++j) chance += kChanceOfMount / seconds_of(d, motion, sight, j);
  for (const auto& [turned, belief] :
       robot ? other_mounts(*robot, sight) : std::vector<OtherMount>{}) {
    const bool weightless = turned.gravity.isZero();
    if (mount && !weightless) continue;
    Account other = account_for(d, &turned, motion, sight);
    const double gained = best.cost() - other.cost();
    if (!(gained > belief + chance && other.unexplained() < kUnderstood)) continue;
    best = std::move(other);
    const FindingKind kind = weightless ? FindingKind::kNoGravity : FindingKind::kMount;
    mount = describe(d, motion, {kind, false, true}, std::exp(gained / d.n()), "");
    mount->joint = -1;
    const Eigen::Vector3d up = -turned.gravity.normalized();
    mount->unit = weightless
                      ? "times less of each joint unexplained where no gravity is in the torque"
                      : fmt::format(
                            "times less of each joint unexplained where ({:.2g} {:.2g} {:.2g}) of "
                            "the base is up: {}{}",
                            up[0], up[1], up[2], dynamics::mount_in_words(turned.gravity),
                            zero_instead(*robot, turned.gravity));
  }
  if (mount) findings.push_back(*mount);
  sight = std::move(best.sight);
  const std::vector<Explained>& now = best.explained;
  findings.insert(findings.end(), best.mistakes.begin(), best.mistakes.end());
  if (!robot) return;
  const bool most = mostly_far_off(now);
  Judge judge(robot, d.n());
  for (int j = 0; j < d.n(); ++j) {
    const Explained& e = now[static_cast<std::size_t>(j)];
    const Hypothesis unit{FindingKind::kTorqueUnit, false, true, j};
    const auto centre_explains = [&] {
      return judge.unexplained_with_centre(sight, j) < kMirrored * e.unexplained;
    };
    if (far_off(e, most ? kFarOff : kFarOffAlone) && !may_be_centre(*robot, e, j) &&
        (most || (slides_both_ways(motion, sight, j) && !centre_explains())))
      findings.push_back(
          describe(d, motion, unit, e.scale,
                   fmt::format("times the nominal torque{}",
                               unit_of(e.scale, robot->joints[static_cast<std::size_t>(j)]))));
    else if (const double times = beyond_effort(*robot, sight, j); times > 0)
      findings.push_back(describe(d, motion, unit, times, "times the effort limit"));
  }
}

}  // namespace fricid::doctor
