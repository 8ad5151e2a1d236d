// Columns of a log that are not what they are taken for: signs, swaps and units.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/system/transmission.hpp"
#include "sight.hpp"

namespace fricid::doctor {
namespace {

using data::RowMatrix;

constexpr double kDegree = std::numbers::pi / 180;
// Log of the factor by which the unexplained variances of all joints must fall, in sum, before a
// hypothesis is believed; a nominal model is some 20 % wrong and keeps no wrong one below it.
constexpr double kBelief = 1.6;
constexpr double kBeliefInSlope = 2 * kBelief;  // of any angles
// What it gains by chance in the few seconds in which a joint slides: of one joint, and of each
// under another gravity [s].
constexpr double kChance = 4, kChanceOfMount = 2;
constexpr double kUnderstood = 0.3;  // mean share unexplained where another mount is believed
constexpr double kLeastTilt = 0.06;  // [rad] of another mount
constexpr int kMostTilts = 6;        // of one size
constexpr double kWorse = 0.4;       // log of the factor by which one joint may become worse
constexpr double kWorseOfAll = 1.6;  // .. where all joints are concerned
// A joint that is taken the wrong way round looks as if the mass of its link lay on the other side.
// Any other place of it leaves not much less then; where one leaves less than this share, the place
// in the file is wrong.
constexpr double kMirrored = 0.5;
constexpr int kMistakes = 4;  // found one after the other
// Factors of the nominal torques that are no modelling error: of most joints alike, and of one,
// whose light link may be anything in a file.
constexpr double kFarOff = 8, kFarOffAlone = 30;
constexpr double kBeyondEffort = 10;  // root mean square of a torque over the effort limit

/// A mistake that the log may contain, undone.
struct Hypothesis {
  FindingKind kind;
  bool moves = false, forces = false;  // concerns q v a, concerns tau
  int joint = 0, other = -1;
  double factor = 1;                      // of the column of `joint`, where there is no other
  const Transmission* coupled = nullptr;  // of columns of motors read as those of joints,
  bool at_joints = false;                 // or the other way round
  bool reversed = false;                  // concerns all columns, from the last to the first

  /// Whether the joint turns the other way than taken.
  bool mirrors() const { return kind == FindingKind::kSign && moves && forces; }

  Sight undone(Sight s) const {
    if (coupled) {
      if (moves)
        for (RowMatrix* x : {&s.q, &s.v, &s.a})
          *x = at_joints ? coupled->to_motors(*x) : coupled->to_joints(*x);
      if (forces)
        s.tau = at_joints ? coupled->torque_to_motors(s.tau) : coupled->torque_to_joints(s.tau);
    } else if (reversed) {
      for (int j = 0, n = static_cast<int>(s.q.cols()); j < n - 1 - j; ++j) swap(j, n - 1 - j, s);
    } else if (other >= 0) {
      swap(joint, other, s);
    } else {
      if (moves)
        for (RowMatrix* x : {&s.q, &s.v, &s.a}) x->col(joint) *= factor;
      if (forces) s.tau.col(joint) *= factor;
    }
    return s;
  }

 private:
  void swap(int one, int two, Sight& s) const {
    if (moves) {
      for (RowMatrix* x : {&s.q, &s.v, &s.a}) x->col(one).swap(x->col(two));
      std::swap(s.rows[static_cast<std::size_t>(one)], s.rows[static_cast<std::size_t>(two)]);
    }
    if (forces) s.tau.col(one).swap(s.tau.col(two));
  }
};

/// How well physics explains the torque of one joint.
struct Explained {
  double unexplained = 1;    ///< share of the variance
  double friction_only = 1;  ///< the same without the rigid body
  double scale = 0;          ///< measured over nominal torque; 0: does not count
};

// Least squares of y on the free columns and on those columns of `positive` whose coefficient is
// not negative in the best such solution.
Explained regress(const Eigen::MatrixXd& free, const Eigen::MatrixXd& positive,
                  const Eigen::VectorXd& y) {
  const double variance = (y.array() - y.mean()).square().sum();
  Explained best;
  if (!(variance > 0)) return best;
  const Eigen::Index f = free.cols(), p = positive.cols();
  Eigen::MatrixXd X(y.size(), f + p);
  X << free, positive;
  const Eigen::MatrixXd H = X.transpose() * X;
  const Eigen::VectorXd g = X.transpose() * y;
  for (int mask = 0; mask < 1 << p; ++mask) {
    std::vector<Eigen::Index> columns;
    for (Eigen::Index c = 0; c < f + p; ++c)
      if (c < f || (mask >> (c - f) & 1)) columns.push_back(c);
    const auto size = static_cast<Eigen::Index>(columns.size());
    Eigen::MatrixXd Hs(size, size);
    Eigen::VectorXd gs(size);
    for (Eigen::Index r = 0; r < size; ++r) {
      gs[r] = g[columns[static_cast<std::size_t>(r)]];
      for (Eigen::Index c = 0; c < size; ++c)
        Hs(r, c) = H(columns[static_cast<std::size_t>(r)], columns[static_cast<std::size_t>(c)]);
    }
    Hs.diagonal() *= 1 + 1e-9;
    const Eigen::VectorXd x = Hs.ldlt().solve(gs);
    bool allowed = x.allFinite();
    for (Eigen::Index i = f; i < size; ++i) allowed = allowed && x[i] >= 0;
    if (!allowed) continue;
    const double rest = y.squaredNorm() - 2 * x.dot(gs) + x.dot(Hs * x);
    const double unexplained = std::clamp(rest / variance, 1e-9, 1.0);
    const bool rigid = mask & 1;
    if (!rigid) best.friction_only = std::min(best.friction_only, unexplained);
    if (unexplained >= best.unexplained) continue;
    best.unexplained = unexplained;
    best.scale = rigid ? x[f] : 0;
  }
  return best;
}

/// Judges a sight, with a robot or without.
class Judge {
 public:
  Judge(const dynamics::RobotModel* robot, int n) : robot_(robot), n_(n) {
    if (!robot_) return;
    ws_.emplace(*robot_);
    motors_.emplace(*robot_);
  }

  // Share of the torque of a joint that is unexplained if the centre of mass of its own link is
  // free: that of a light link, a tool or a flange is often wrong in a file.
  double unexplained_with_centre(const Sight& s, int joint) {
    dynamics::RobotModel moment = *robot_;
    RowMatrix centre(s.q.rows(), 3);
    for (int axis = 0; axis < 3; ++axis) {
      moment.pi.setZero();
      moment.pi[10 * joint + 1 + axis] = 1;
      centre.col(axis) = torques(s, moment).col(joint);
    }
    return explain(s, torques(s, *robot_), speeds_of_motors(s), joint, centre).unexplained;
  }

  // Positive parts of the torque are friction, with a robot also its nominal torque, friction that
  // grows with it and the armature of a file that states none. Without a robot inertia is, and
  // gravity any sine of any joint.
  std::vector<Explained> explain(const Sight& s) {
    const RowMatrix nominal = robot_ ? torques(s, *robot_) : RowMatrix();
    const RowMatrix v = speeds_of_motors(s);
    std::vector<Explained> all;
    for (int j = 0; j < n_; ++j) all.push_back(explain(s, nominal, v, j, {}));
    return all;
  }

 private:
  RowMatrix speeds_of_motors(const Sight& s) const {
    return robot_ ? motors_->to_motors(s.v) : s.v;
  }

  // @param nominal  torque with a robot
  // @param v        of the motors
  // @param further  (T, ..) torques that are free
  Explained explain(const Sight& s, const RowMatrix& nominal, const RowMatrix& v, int j,
                    const RowMatrix& further) {
    const std::vector<int>& rows = s.rows[static_cast<std::size_t>(j)];
    const auto size = static_cast<Eigen::Index>(rows.size());
    const Eigen::Index of_gravity = robot_ ? 1 : 1 + 2 * n_;
    Eigen::MatrixXd free = Eigen::MatrixXd::Ones(size, of_gravity + further.cols());
    const bool bare = robot_ && robot_->pi[robot_->armature_begin() + j] == 0;
    const Eigen::RowVectorXd acting = motors_on(robot_, n_, j);
    const Eigen::Index of_motors = 3 * (acting.array() != 0).count();
    Eigen::MatrixXd positive(size, 1 + of_motors + (robot_ ? 1 + bare : 0));
    Eigen::VectorXd tau(size);
    for (Eigen::Index r = 0; r < size; ++r) {
      const int k = rows[static_cast<std::size_t>(r)];
      positive(r, 0) = robot_ ? nominal(k, j) : s.a(k, j);
      Eigen::Index next = 1;
      for (int m = 0; m < n_; ++m) {
        if (acting[m] == 0) continue;
        const double speed = v(k, m), sign = speed > 0 ? 1 : -1;
        positive.row(r).segment<3>(next) << acting[m] * sign, acting[m] * speed,
            acting[m] * sign * std::sqrt(std::abs(speed));
        next += 3;
      }
      if (robot_) positive(r, next++) = (v(k, j) > 0 ? 1 : -1) * std::abs(nominal(k, j));
      if (bare) positive(r, next) = s.a(k, j);
      for (int i = 0; !robot_ && i < n_; ++i) {
        free(r, 1 + 2 * i) = std::sin(s.q(k, i));
        free(r, 2 + 2 * i) = std::cos(s.q(k, i));
      }
      if (further.cols() > 0) free.row(r).tail(further.cols()) = further.row(k);
      tau[r] = s.tau(k, j);
    }
    return size > 3 * (free.cols() + positive.cols()) ? regress(free, positive, tau) : Explained{};
  }

  RowMatrix torques(const Sight& s, const dynamics::RobotModel& robot) {
    const auto n = static_cast<std::size_t>(n_);
    const std::span<const double> pi{robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
    const RowMatrix q = motors_->to_motors(s.q), v = motors_->to_motors(s.v),
                    a = motors_->to_motors(s.a);
    RowMatrix tau(q.rows(), n_);
    for (Eigen::Index k = 0; k < q.rows(); ++k)
      dynamics::rnea<double>(robot, *ws_, pi, {q.row(k).data(), n}, {v.row(k).data(), n},
                             {a.row(k).data(), n}, {tau.row(k).data(), n});
    return motors_->torque_to_joints(tau);
  }

  const dynamics::RobotModel* robot_;
  int n_;
  std::optional<dynamics::Workspace<double>> ws_;
  std::optional<Transmission> motors_;
};

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

// @param worse  log of the factor by which each joint may become worse
double gain(const std::vector<Explained>& before, const std::vector<Explained>& after,
            double worse = kWorse) {
  double sum = 0;
  for (std::size_t j = 0; j < before.size(); ++j) {
    const double log_ratio = std::log(before[j].unexplained / after[j].unexplained);
    if (log_ratio < -worse) return -1;
    sum += log_ratio;
  }
  return sum;
}

// Whether the logged velocity goes with the logged position of joint j.
bool velocity_follows(const data::Dataset& d, const Motion& motion, int j) {
  if (d.v.size() == 0) return false;
  double dot = 0, square = 0;
  for (int i = 0; i < motion.length(); ++i) {
    const double logged = d.v(motion.samples[static_cast<std::size_t>(i)], j);
    if (!std::isfinite(logged)) continue;
    dot += logged * motion.v(i, j);
    square += motion.v(i, j) * motion.v(i, j);
  }
  return dot > 0.5 * square;
}

// Whether the logged velocity is that of a position in degrees, in radians.
bool velocity_tells_degrees(const data::Dataset& d, const Motion& motion, int j) {
  if (d.v.size() == 0) return false;
  double dot = 0, square = 0, logged_square = 0;
  for (int i = 0; i < motion.length(); ++i) {
    const double logged = d.v(motion.samples[static_cast<std::size_t>(i)], j);
    if (!std::isfinite(logged)) continue;
    dot += logged * motion.v(i, j);
    square += motion.v(i, j) * motion.v(i, j);
    logged_square += logged * logged;
  }
  return dot > 0.5 * kDegree * square && dot < 2 * kDegree * square &&
         dot * dot > 0.5 * square * logged_square;
}

Finding describe(const data::Dataset& d, const Motion& motion, const Hypothesis& h, double size,
                 const char* unit) {
  std::string signal = h.moves ? "q" : "";
  if (h.moves && d.v.size() > 0 && (h.joint < 0 || velocity_follows(d, motion, h.joint)))
    signal += " v";
  if (h.forces) signal += h.moves ? " tau" : "tau";
  return {.kind = h.kind,
          .signal = signal,
          .joint = h.joint,
          .other = h.other,
          .begin_s = d.t[0],
          .end_s = d.t[d.length() - 1],
          .size = size,
          .unit = unit};
}

/// Sliding joints far outside their limits: not in metres.
void check_lengths(const data::Dataset& d, const dynamics::RobotModel* robot, const Sight& sight,
                   Findings& findings) {
  constexpr double kFarOut = 2, kAnyway = 0.1;  // of the largest limit, [m]
  if (!robot) return;
  for (int j = 0; j < d.n(); ++j) {
    const dynamics::Joint& joint = robot->joints[static_cast<std::size_t>(j)];
    if (!slides(joint) || joint.upper <= joint.lower) continue;
    const double largest = sight.q.col(j).cwiseAbs().maxCoeff();
    if (largest <= kFarOut * std::max(std::abs(joint.lower), std::abs(joint.upper)) + kAnyway)
      continue;
    findings.push_back({.kind = FindingKind::kLengthUnit,
                        .signal = "q",
                        .joint = j,
                        .begin_s = d.t[0],
                        .end_s = d.t[d.length() - 1],
                        .size = largest,
                        .unit = fmt::format("m at most, as it stands, limits {:g} and {:g} m",
                                            joint.lower, joint.upper)});
  }
}

}  // namespace

// Positions far outside the limits, unless the torque contradicts it, or beyond two turns either
// way, are degrees. A continuous joint may turn: there degrees must explain more of the torque, or
// the velocity must say so.
void undo_degrees(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                  Sight& sight, Findings& findings) {
  constexpr double kTwoTurns = 4 * std::numbers::pi;
  Findings found;
  const auto gain_of = [&](const Sight& undone) {
    Judge judge(robot, d.n());
    return gain(judge.explain(sight), judge.explain(undone));
  };
  for (int j = 0; j < d.n(); ++j) {
    const double largest = sight.q.col(j).cwiseAbs().maxCoeff();
    double allowed = kTwoTurns;
    if (robot) {
      const dynamics::Joint& joint = robot->joints[static_cast<std::size_t>(j)];
      if (slides(joint) || joint.continuous) continue;
      if (joint.upper > joint.lower)
        allowed = 1.3 * std::max(std::abs(joint.lower), std::abs(joint.upper)) + 0.5;
    }
    if (largest <= allowed) continue;
    const Hypothesis degrees{FindingKind::kAngleUnit, true, false, j, -1, kDegree};
    Sight undone = degrees.undone(sight);
    // within two turns the limits may be nobody's, and the torque tells
    if (robot && largest <= kTwoTurns && gain_of(undone) < 0) continue;
    sight = std::move(undone);
    found.push_back(describe(d, motion, degrees, largest, "rad at most, as it stands"));
  }
  for (int j = 0; robot && j < d.n(); ++j) {
    const dynamics::Joint& joint = robot->joints[static_cast<std::size_t>(j)];
    const double largest = sight.q.col(j).cwiseAbs().maxCoeff();
    if (slides(joint) || !joint.continuous || largest <= kTwoTurns) continue;
    const Hypothesis degrees{FindingKind::kAngleUnit, true, false, j, -1, kDegree};
    Sight undone = degrees.undone(sight);
    if (!velocity_tells_degrees(d, motion, j) && gain_of(undone) <= kBelief) continue;
    sight = std::move(undone);
    found.push_back(describe(d, motion, degrees, largest, "rad at most, as it stands"));
  }
  check_lengths(d, robot, sight, findings);
  // What is in degrees for most joints is so for all: a joint that moves little gives no sign of
  // it.
  if (static_cast<int>(found.size()) * 2 > d.n() && d.n() > 1) {
    for (int j = 0; j < d.n(); ++j) {
      const bool done =
          std::any_of(found.begin(), found.end(), [j](const Finding& f) { return f.joint == j; });
      const bool turns = !robot || robot->joints[static_cast<std::size_t>(j)].type ==
                                       dynamics::JointType::kRevolute;
      if (done || !turns) continue;
      sight =
          Hypothesis{FindingKind::kAngleUnit, true, false, j, -1, kDegree}.undone(std::move(sight));
      found.push_back(found.front());
      found.back().joint = j;
    }
    std::sort(found.begin(), found.end(),
              [](const Finding& a, const Finding& b) { return a.joint < b.joint; });
  }
  findings.insert(findings.end(), found.begin(), found.end());
}

namespace {

/// Log of the shares of all joints' variances that stay unexplained, in sum.
double log_unexplained(const std::vector<Explained>& explained) {
  double sum = 0;
  for (const Explained& e : explained) sum += std::log(e.unexplained);
  return sum;
}

/// Time in which a joint slides [s].
double seconds_of(const data::Dataset& d, const Motion& motion, const Sight& sight, int j) {
  const auto rows = static_cast<double>(sight.rows[static_cast<std::size_t>(j)].size());
  return std::max(1.0, rows) / motion.length() * d.length() * d.dt();
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

Account account_for(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                    const Sight& sight) {
  Judge judge(robot, d.n());
  const std::optional<Transmission> motors =
      robot ? std::optional<Transmission>(*robot) : std::nullopt;
  const std::vector<Hypothesis> all = hypotheses(motors ? &*motors : nullptr, d.n());
  Account account{sight, judge.explain(sight), {}};
  const auto needs = [&](const Hypothesis& h) {
    double seconds = d.length() * d.dt();
    for (const int j : {h.joint, h.other})
      if (j >= 0) seconds = std::min(seconds, seconds_of(d, motion, sight, j));
    return kBelief * (h.reversed ? d.n() : 1) + kChance / seconds;
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
      if (robot && h.mirrors() &&
          judge.unexplained_with_centre(account.sight, h.joint) <
              kMirrored * after[static_cast<std::size_t>(h.joint)].unexplained)
        continue;
      best = gained;
      most = beyond;
      believed = &h;
      then = after;
    }
    if (!believed) break;
    account.sight = believed->undone(std::move(account.sight));
    account.explained = then;
    Finding found = describe(d, motion, *believed, std::exp(best),
                             !believed->coupled    ? "times less unexplained if undone"
                             : believed->at_joints ? "times less unexplained as columns of joints"
                                                   : "times less unexplained as columns of motors");
    if (believed->reversed) {
      found.unit = "times less unexplained with all joints in reversed order";
      for (int j = 0; j < d.n() - 1 - j; ++j) {
        found.joint = j;
        found.other = d.n() - 1 - j;
        account.mistakes.push_back(found);
      }
    } else {
      account.mistakes.push_back(std::move(found));
    }
  }
  return account;
}

/// The axis of all joints in the base frame, where they turn about parallel ones: gravity along it
/// is in no torque, so that a tilt across it and a lighter arm are the same.
std::optional<Eigen::Vector3d> common_axis(const dynamics::RobotModel& robot) {
  constexpr double kParallel = 1e-3;  // sine of the angle between two
  std::vector<Eigen::Matrix3d> to_base;
  std::optional<Eigen::Vector3d> common;
  for (const dynamics::Joint& joint : robot.joints) {
    const Eigen::Matrix3d parent = joint.parent < 0
                                       ? Eigen::Matrix3d::Identity()
                                       : to_base[static_cast<std::size_t>(joint.parent)];
    to_base.emplace_back(parent * joint.R0);
    const Eigen::Vector3d axis = to_base.back() * joint.axis;
    if (slides(joint) || (common && common->cross(axis).norm() > kParallel)) return std::nullopt;
    if (!common) common = axis;
  }
  return common;
}

/// Another mount that explains more of the torque, and what it has to gain to be believed.
struct OtherMount {
  dynamics::RobotModel robot;
  double belief;
};

/// The robot on a slope, on its head or on a side, whichever explains most of the torque as it
/// stands; those that are the mount as it is stated, within a few degrees, are left out. Last,
/// without gravity: drivers take it off.
std::vector<OtherMount> other_mounts(const dynamics::RobotModel& robot, const Sight& sight) {
  const Eigen::Vector3d g = robot.gravity;
  std::vector<Eigen::Vector3d> gravities{g, -g};
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d side = g.cross(Eigen::Vector3d::Unit(axis));
    if (side.norm() < 0.5 * g.norm()) continue;
    gravities.emplace_back(side.normalized() * g.norm());
    gravities.emplace_back(-gravities.back());
  }
  const auto unexplained = [&](const Eigen::Vector3d& gravity) {
    dynamics::RobotModel turned = robot;
    turned.gravity = gravity;
    return log_unexplained(Judge(&turned, robot.n()).explain(sight));
  };
  const Eigen::Vector3d upright = *std::ranges::min_element(gravities, {}, unexplained);
  Eigen::Vector3d best = upright;
  double least = unexplained(best);
  // on a slope: tilted further while that explains more
  const std::optional<Eigen::Vector3d> turned_about = common_axis(robot);
  for (const double tilt : {0.3, 0.1, 0.03}) {
    for (int moves = 0; moves < kMostTilts; ++moves) {
      const Eigen::Vector3d now = best, across = now.unitOrthogonal();
      std::vector<Eigen::Vector3d> axes{across, now.cross(across).normalized()};
      if (turned_about) axes = {*turned_about};
      for (const Eigen::Vector3d& axis : std::vector(axes)) axes.emplace_back(-axis);
      for (const Eigen::Vector3d& axis : axes) {
        const Eigen::Vector3d tilted = Eigen::AngleAxisd(tilt, axis) * now;
        if (const double left = unexplained(tilted); left < least) least = left, best = tilted;
      }
      if (best == now) break;
    }
  }
  std::vector<OtherMount> mounts;
  for (const auto& [gravity, belief] : {std::pair{best, kBeliefInSlope},
                                        {upright, kBelief},
                                        {Eigen::Vector3d::Zero().eval(), kBelief}}) {
    if (gravity.dot(g) > std::cos(kLeastTilt) * g.squaredNorm()) continue;
    mounts.push_back({robot, belief});
    mounts.back().robot.gravity = gravity;
  }
  return mounts;
}

/// Angles of `mount_rpy` that have this direction of the base up.
std::string mount_of(const Eigen::Vector3d& up) {
  return fmt::format("mount = \"rpy\", mount_rpy = [{:.2f}, {:.2f}, 0]", std::atan2(up[1], up[2]),
                     -std::asin(std::clamp(up[0], -1.0, 1.0)));
}

/// Gravity turned about the axis of all joints is the same as a wrong zero of the first.
std::string zero_instead(const dynamics::RobotModel& robot, const Eigen::Vector3d& gravity) {
  const std::optional<Eigen::Vector3d> axis = common_axis(robot);
  if (!axis) return "";
  const double turned =
      std::atan2(axis->dot(robot.gravity.cross(gravity)),
                 robot.gravity.dot(gravity) - axis->dot(robot.gravity) * axis->dot(gravity));
  return fmt::format(", or where offset_rad of {} is {:.2f} more", robot.joints.front().name,
                     -turned);
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
    mount->unit =
        weightless ? "times less of each joint unexplained where no gravity is in the torque"
                   : fmt::format(
                         "times less of each joint unexplained where ({:.2g} {:.2g} {:.2g}) of "
                         "the base is up: {}{}",
                         up[0], up[1], up[2], mount_of(up), zero_instead(*robot, turned.gravity));
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
    if (far_off(e, most ? kFarOff : kFarOffAlone) &&
        (most || judge.unexplained_with_centre(sight, j) >= kMirrored * e.unexplained))
      findings.push_back(describe(d, motion, unit, e.scale, "times the nominal torque"));
    else if (const double times = beyond_effort(*robot, sight, j); times > 0)
      findings.push_back(describe(d, motion, unit, times, "times the effort limit"));
  }
}

}  // namespace fricid::doctor
