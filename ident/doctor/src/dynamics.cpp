#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "checks.hpp"
#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/system/transmission.hpp"
#include "local_fit.hpp"

namespace fricid::doctor {
namespace {

using data::RowMatrix;

constexpr int kSamples = 1500;
constexpr double kWindow = 0.03;  // [s] half of that of the local fits
// Gear ripple, which a controller answers late, is averaged out: half of each mean [s].
constexpr double kSmoothing = 0.03;
constexpr double kDegree = std::numbers::pi / 180;
// Log of the factor by which the unexplained variances of all joints must fall, in sum, before a
// hypothesis is believed; a nominal model is some 20 % wrong and keeps no wrong one below it.
constexpr double kBelief = 1.6;
constexpr double kWorse = 0.4;  // log of the factor by which one joint may become worse
constexpr int kMistakes = 4;    // found one after the other
// Factors of the nominal torques that are no modelling error: of most joints alike, and of one,
// whose light link may be anything in a file.
constexpr double kFarOff = 8, kFarOffAlone = 30;
constexpr double kEarliest = -0.02, kLatest = 0.22;  // delays that are tried [s]
constexpr double kBeforeReversal = 0.056;            // [s]

/// Motion and torque of all joints at the chosen samples (S, n), and the rows at which each slides.
struct Sight {
  RowMatrix q, v, a, tau;
  std::vector<std::vector<int>> rows;
};

// Rows at which joint j slides steadily: friction has settled since the last reversal, and the next
// is far. Friction climbs over a travel, which would look like a delay.
std::vector<int> settled_rows(const data::Dataset& d, const Motion& motion, int j) {
  constexpr double kSettled = 0.05;  // [rad or m] of travel
  const int T = d.length(), half = motion.half;
  const int reach = half + 3 * static_cast<int>(std::lround(kSmoothing / d.dt()));
  const int margin = static_cast<int>(std::lround(kBeforeReversal / d.dt()));
  // travel since the last reversal and samples since it and to the next, from displacements over a
  // window
  std::vector<double> travel(static_cast<std::size_t>(T), 0.0);
  std::vector<int> ahead(static_cast<std::size_t>(T), 0), since = ahead;
  const auto direction = [&](int k) {
    const double step = d.q(k + half, j) - d.q(k - half, j);
    return step > 0 ? 1 : step < 0 ? -1 : 0;
  };
  double origin = d.q(0, j);
  for (int k = half + 1; k + half < T; ++k) {
    const bool turns = direction(k) != direction(k - 1) || direction(k) == 0;
    if (turns) origin = d.q(k, j);
    since[static_cast<std::size_t>(k)] = turns ? 0 : since[static_cast<std::size_t>(k - 1)] + 1;
    travel[static_cast<std::size_t>(k)] = std::abs(d.q(k, j) - origin);
  }
  for (int k = T - half - 2; k > half; --k)
    ahead[static_cast<std::size_t>(k)] =
        direction(k) == direction(k + 1) ? ahead[static_cast<std::size_t>(k + 1)] + 1 : 0;
  std::vector<int> rows;
  for (int i = 0; i < motion.length(); ++i) {
    const auto k = static_cast<std::size_t>(motion.samples[static_cast<std::size_t>(i)]);
    if (travel[k] > kSettled && since[k] > reach && ahead[k] > reach + margin) rows.push_back(i);
  }
  return rows;
}

// Motors of a robot whose friction acts on joint j: turns per turn of the joint (0: none).
Eigen::RowVectorXd motors_on(const dynamics::RobotModel* robot, int n, int j) {
  return robot ? Eigen::RowVectorXd(robot->motors_of_joints().col(j).transpose())
               : Eigen::RowVectorXd::Unit(n, j);
}

Sight see(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion) {
  Sight sight{motion.q, motion.v, motion.a, RowMatrix(motion.length(), d.n()), {}};
  const data::Dataset motors = robot ? Transmission(*robot).to_motors(d) : d;
  for (int j = 0; j < d.n(); ++j) {
    sight.tau.col(j) = motion.torque(j, 0);
    std::vector<int> rows = settled_rows(motors, motion, j);
    const Eigen::RowVectorXd acting = motors_on(robot, d.n(), j);
    for (int k = 0; k < d.n(); ++k) {
      if (k == j || acting[k] == 0) continue;
      const std::vector<int> also = settled_rows(motors, motion, k), before = std::move(rows);
      rows.clear();
      std::ranges::set_intersection(before, also, std::back_inserter(rows));
    }
    sight.rows.push_back(std::move(rows));
  }
  return sight;
}

/// A mistake that the log may contain, undone.
struct Hypothesis {
  std::string name;
  bool moves = false, forces = false;  // concerns q v a, concerns tau
  int joint = 0, other = -1;
  double factor = 1;

  Sight undone(Sight s) const {
    if (other >= 0) {
      if (moves) {
        for (RowMatrix* x : {&s.q, &s.v, &s.a}) x->col(joint).swap(x->col(other));
        std::swap(s.rows[static_cast<std::size_t>(joint)], s.rows[static_cast<std::size_t>(other)]);
      }
      if (forces) s.tau.col(joint).swap(s.tau.col(other));
    } else {
      if (moves)
        for (RowMatrix* x : {&s.q, &s.v, &s.a}) x->col(joint) *= factor;
      if (forces) s.tau.col(joint) *= factor;
    }
    return s;
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

  // Positive parts of the torque are friction, with a robot also its nominal torque, friction that
  // grows with it and the armature of a file that states none. Without a robot inertia is, and
  // gravity any sine of any joint.
  std::vector<Explained> explain(const Sight& s) {
    const RowMatrix nominal = robot_ ? torques(s) : RowMatrix();
    const RowMatrix v = robot_ ? motors_->to_motors(s.v) : s.v;
    std::vector<Explained> all;
    for (int j = 0; j < n_; ++j) {
      const std::vector<int>& rows = s.rows[static_cast<std::size_t>(j)];
      const auto size = static_cast<Eigen::Index>(rows.size());
      Eigen::MatrixXd free = Eigen::MatrixXd::Ones(size, robot_ ? 1 : 1 + 2 * n_);
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
        tau[r] = s.tau(k, j);
      }
      all.push_back(size > 3 * (free.cols() + positive.cols()) ? regress(free, positive, tau)
                                                               : Explained{});
    }
    return all;
  }

 private:
  RowMatrix torques(const Sight& s) {
    const auto n = static_cast<std::size_t>(n_);
    const std::span<const double> pi{robot_->pi.data(),
                                     static_cast<std::size_t>(robot_->pi.size())};
    const RowMatrix q = motors_->to_motors(s.q), v = motors_->to_motors(s.v),
                    a = motors_->to_motors(s.a);
    RowMatrix tau(q.rows(), n_);
    for (Eigen::Index k = 0; k < q.rows(); ++k)
      dynamics::rnea<double>(*robot_, *ws_, pi, {q.row(k).data(), n}, {v.row(k).data(), n},
                             {a.row(k).data(), n}, {tau.row(k).data(), n});
    return motors_->torque_to_joints(tau);
  }

  const dynamics::RobotModel* robot_;
  int n_;
  std::optional<dynamics::Workspace<double>> ws_;
  std::optional<Transmission> motors_;
};

std::vector<Hypothesis> hypotheses(bool with_robot, int n) {
  std::vector<Hypothesis> all;
  for (int j = 0; j < n; ++j) {
    all.push_back({"sign", false, true, j, -1, -1});
    if (!with_robot) continue;
    all.push_back({"sign", true, false, j, -1, -1});
    all.push_back({"sign", true, true, j, -1, -1});
    for (int other = j + 1; other < n; ++other) {
      all.push_back({"swapped", true, true, j, other});
      all.push_back({"swapped", true, false, j, other});
      all.push_back({"swapped", false, true, j, other});
    }
  }
  return all;
}

double gain(const std::vector<Explained>& before, const std::vector<Explained>& after) {
  double sum = 0;
  for (std::size_t j = 0; j < before.size(); ++j) {
    const double log_ratio = std::log(before[j].unexplained / after[j].unexplained);
    if (log_ratio < -kWorse) return -1;
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

Finding describe(const data::Dataset& d, const Motion& motion, const Hypothesis& h, double size,
                 const char* unit) {
  std::string signal = h.moves ? "q" : "";
  if (h.moves && velocity_follows(d, motion, h.joint)) signal += " v";
  if (h.forces) signal += h.moves ? " tau" : "tau";
  return {.name = h.name,
          .signal = signal,
          .joint = h.joint,
          .other = h.other,
          .begin_s = d.t[0],
          .end_s = d.t[d.length() - 1],
          .size = size,
          .unit = unit};
}

// Positions far outside the limits, or beyond two turns either way, are degrees.
void undo_degrees(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                  Sight& sight, Findings& findings) {
  Findings found;
  for (int j = 0; j < d.n(); ++j) {
    const double largest = sight.q.col(j).cwiseAbs().maxCoeff();
    double allowed = 4 * std::numbers::pi;
    if (robot) {
      const dynamics::Joint& joint = robot->joints[static_cast<std::size_t>(j)];
      if (joint.type == dynamics::JointType::kPrismatic || joint.continuous) continue;
      if (joint.upper > joint.lower)
        allowed = 1.3 * std::max(std::abs(joint.lower), std::abs(joint.upper)) + 0.5;
    }
    if (largest <= allowed) continue;
    const Hypothesis degrees{"angle_unit", true, false, j, -1, kDegree};
    sight = degrees.undone(std::move(sight));
    found.push_back(describe(d, motion, degrees, largest, "rad at most, as it stands"));
  }
  // What is in degrees for most joints is so for all: a joint that moves little gives no sign of
  // it.
  if (static_cast<int>(found.size()) * 2 > d.n() && d.n() > 1) {
    for (int j = 0; j < d.n(); ++j) {
      const bool done =
          std::any_of(found.begin(), found.end(), [j](const Finding& f) { return f.joint == j; });
      const bool turns = !robot || robot->joints[static_cast<std::size_t>(j)].type ==
                                       dynamics::JointType::kRevolute;
      if (done || !turns) continue;
      sight = Hypothesis{"angle_unit", true, false, j, -1, kDegree}.undone(std::move(sight));
      found.push_back(found.front());
      found.back().joint = j;
    }
    std::sort(found.begin(), found.end(),
              [](const Finding& a, const Finding& b) { return a.joint < b.joint; });
  }
  findings.insert(findings.end(), found.begin(), found.end());
}

void undo_mistakes(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                   Sight& sight, Findings& findings) {
  Judge judge(robot, d.n());
  const std::vector<Hypothesis> all = hypotheses(robot != nullptr, d.n());
  std::vector<Explained> now = judge.explain(sight);
  for (int mistake = 0; mistake < kMistakes; ++mistake) {
    double best = kBelief;
    const Hypothesis* believed = nullptr;
    std::vector<Explained> then;
    for (const Hypothesis& h : all) {
      const std::vector<Explained> after = judge.explain(h.undone(sight));
      const double gained = gain(now, after);
      if (gained <= best) continue;
      best = gained;
      believed = &h;
      then = after;
    }
    if (!believed) break;
    sight = believed->undone(std::move(sight));
    now = then;
    findings.push_back(
        describe(d, motion, *believed, std::exp(best), "times less unexplained if undone"));
  }
  if (!robot) return;
  const auto tells = [](const Explained& e) {
    return e.scale > 0 && e.unexplained <= 0.5 && e.friction_only >= 3 * e.unexplained;
  };
  const auto far_off = [&](const Explained& e, double factor) {
    return tells(e) && std::max(e.scale, 1 / e.scale) >= factor;
  };
  const auto far = std::ranges::count_if(now, [&](const auto& e) { return far_off(e, kFarOff); });
  const bool most = 2 * far > std::ranges::count_if(now, tells);
  for (int j = 0; j < d.n(); ++j)
    if (const Explained& e = now[static_cast<std::size_t>(j)];
        far_off(e, most ? kFarOff : kFarOffAlone))
      findings.push_back(describe(d, motion, {"torque_unit", false, true, j}, e.scale,
                                  "times the nominal torque"));
}

// Regressors of the torque of joint j at given rows: rigid body, and friction as a smooth function
// of speed and load on either side.
Eigen::MatrixXd regressors(const dynamics::RobotModel& robot, const Sight& s, int j,
                           const std::vector<int>& columns, const std::vector<int>& rows) {
  constexpr Eigen::Index kOfMotor = 4, kOfJoint = 3;
  const auto n = static_cast<std::size_t>(robot.n());
  const auto b = static_cast<Eigen::Index>(columns.size());
  dynamics::Workspace<double> ws(robot);
  const Transmission motors(robot);
  const RowMatrix q = motors.to_motors(s.q), v = motors.to_motors(s.v), a = motors.to_motors(s.a);
  const Eigen::RowVectorXd acting = motors_on(&robot, robot.n(), j);
  Eigen::MatrixXd Y(robot.n(), robot.parameter_count());
  Eigen::MatrixXd X(static_cast<Eigen::Index>(rows.size()),
                    b + kOfJoint + kOfMotor * (acting.array() != 0).count());
  for (Eigen::Index r = 0; r < X.rows(); ++r) {
    const int k = rows[static_cast<std::size_t>(r)];
    dynamics::regressor(robot, ws, {q.row(k).data(), n}, {v.row(k).data(), n}, {a.row(k).data(), n},
                        Y);
    const Eigen::RowVectorXd at_joint = acting * Y;
    for (Eigen::Index c = 0; c < b; ++c) X(r, c) = at_joint[columns[static_cast<std::size_t>(c)]];
    const double load = at_joint * robot.pi;
    X.row(r).segment<kOfJoint>(b) << 1, (v(k, j) > 0 ? 1 : -1) * std::abs(load),
        load * std::abs(load);
    Eigen::Index next = b + kOfJoint;
    for (int m = 0; m < robot.n(); ++m) {
      if (acting[m] == 0) continue;
      const double speed = v(k, m), sign = speed > 0 ? 1 : -1;
      X.row(r).segment<kOfMotor>(next) << sign, speed, sign * std::sqrt(std::abs(speed)),
          speed * speed * speed;
      next += kOfMotor;
    }
  }
  return X;
}

/// What the regressions leave of the torque of each joint, moved back by each delay on a grid.
struct DelayCurves {
  static constexpr int kBlocks = 10;  // of the log, for the error of the delay
  double first, step;                 // of the grid [samples]
  // per joint: sum of squares, (delays, blocks of rows)
  std::vector<Eigen::ArrayXXd> rest;

  int size() const { return static_cast<int>(rest.front().rows()); }
  double delay_of(double i) const { return first + step * i; }

  // Sum over the joints of the log of what is left, without one block; -1: with all.
  Eigen::ArrayXd pooled(int without) const {
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(size());
    for (const Eigen::ArrayXXd& joint : rest) {
      Eigen::ArrayXd total = joint.rowwise().sum();
      if (without >= 0) total -= joint.col(without);
      sum += total.log();
    }
    return sum;
  }
};

/// Lowest point of a curve over a grid, by a parabola through it and its neighbours.
/// @return in steps of the grid; nothing at an end of it
std::optional<double> lowest(const Eigen::ArrayXd& x) {
  Eigen::Index at = 0;
  x.minCoeff(&at);
  if (at == 0 || at == x.size() - 1) return {};
  const double bend = x[at - 1] - 2 * x[at] + x[at + 1];
  return static_cast<double>(at) + (bend > 0 ? 0.5 * (x[at - 1] - x[at + 1]) / bend : 0);
}

DelayCurves delay_curves(const data::Dataset& d, const dynamics::RobotModel& robot,
                         const Motion& motion, const Sight& sight) {
  constexpr double kStep = 0.002, kFinest = 0.5;  // [s], [samples]
  const std::vector<int> columns = dynamics::base_parameters(robot).columns;
  DelayCurves curves{kEarliest / d.dt(), std::max(kStep / d.dt(), kFinest), {}};
  const int steps = static_cast<int>((kLatest - kEarliest) / d.dt() / curves.step) + 1;
  for (int j = 0; j < d.n(); ++j) {
    const std::vector<int>& rows = sight.rows[static_cast<std::size_t>(j)];
    const Eigen::MatrixXd X = regressors(robot, sight, j, columns, rows);
    if (X.rows() < 3 * X.cols()) continue;
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(X);
    const Eigen::MatrixXd Q = qr.householderQ() * Eigen::MatrixXd::Identity(X.rows(), qr.rank());
    Eigen::ArrayXXd rest = Eigen::ArrayXXd::Zero(steps, DelayCurves::kBlocks);
    Eigen::VectorXd tau(X.rows());
    for (int i = 0; i < steps; ++i) {
      const Eigen::VectorXd all = motion.torque(j, curves.delay_of(i));
      for (Eigen::Index r = 0; r < X.rows(); ++r) tau[r] = all[rows[static_cast<std::size_t>(r)]];
      const Eigen::VectorXd left = tau - Q * (Q.transpose() * tau);
      for (Eigen::Index r = 0; r < X.rows(); ++r)
        rest(i, r * DelayCurves::kBlocks / X.rows()) += left[r] * left[r] + 1e-12 * tau[r] * tau[r];
    }
    if (rest.allFinite() && (rest.rowwise().sum() > 0).all()) curves.rest.push_back(rest);
  }
  return curves;
}

// Delay of the torque at which the regressions of all joints explain most.
void check_delay(const data::Dataset& d, const dynamics::RobotModel& robot, const Motion& motion,
                 const Sight& sight, Findings& findings) {
  // A torque held from t_k on lags by 0, one measured at t_k seems to lag by half a sample.
  constexpr double kNone = 0.5;
  constexpr double kSmallest = 0.5;  // [samples] beyond that: worth a word
  constexpr double kCertain = 3;     // standard errors
  constexpr double kEarly = 0.01;    // [s] by which the torque of an elastic gear may lead
  constexpr double kClear = 0.035;   // log of the factor of the residuals' variance
  const DelayCurves curves = delay_curves(d, robot, motion, sight);
  if (curves.rest.empty()) return;
  const Eigen::ArrayXd pooled = curves.pooled(-1);
  double undelayed = std::numeric_limits<double>::infinity();
  for (int i = 0; i < curves.size(); ++i)
    if (std::abs(curves.delay_of(i) - kNone / 2) <= std::max(kNone / 2, curves.step / 2))
      undelayed = std::min(undelayed, pooled[i]);
  const double clear = (undelayed - pooled.minCoeff()) / static_cast<double>(curves.rest.size());
  if (clear < kClear) return;

  Finding finding{.name = "delay",
                  .signal = "tau",
                  .begin_s = d.t[0],
                  .end_s = d.t[d.length() - 1],
                  .unit = "samples"};
  const std::optional<double> best = lowest(pooled);
  if (!best) {
    finding.name = "delay_unknown";
    finding.size = 1e3 * (pooled[0] < pooled[pooled.size() - 1] ? kEarliest : kLatest);
    finding.unit = "ms, the end of the search";
    findings.push_back(finding);
    return;
  }
  // error by the jackknife over blocks of time
  double sum = 0, squares = 0;
  for (int block = 0; block < DelayCurves::kBlocks; ++block) {
    const double without = lowest(curves.pooled(block)).value_or(*best + curves.size());
    sum += without - *best;
    squares += (without - *best) * (without - *best);
  }
  const double mean = sum / DelayCurves::kBlocks;
  const double error =
      curves.step * std::sqrt((DelayCurves::kBlocks - 1) *
                              std::max(0.0, squares / DelayCurves::kBlocks - mean * mean));
  finding.size = curves.delay_of(*best);
  const double beyond = finding.size - std::clamp(finding.size, 0.0, kNone);
  const double least = beyond < 0 ? std::max(kSmallest, kEarly / d.dt()) : kSmallest;
  if (std::abs(beyond) < std::max(least, kCertain * error)) return;
  finding.unit = fmt::format("samples, {:.3g} ms, standard error {:.2g} ms",
                             1e3 * d.dt() * finding.size, 1e3 * d.dt() * error);
  findings.push_back(finding);
}

}  // namespace

void check_velocity(const data::Dataset& d, Findings& findings) {
  constexpr double kFactor = 0.1, kRest = 0.1;
  constexpr double kResting = 1e-3;  // [rad/s]
  if (d.v.size() == 0) return;
  const Motion motion = local_motion(d, kSamples, kWindow, 0);
  for (int j = 0; j < d.n(); ++j) {
    const bool stuck = std::any_of(findings.begin(), findings.end(), [j](const Finding& f) {
      return f.name == "stuck" && f.joint == j;
    });
    if (stuck) continue;
    double dot = 0, slope = 0, logged = 0;
    for (int i = 0; i < motion.length(); ++i) {
      const double v =
          local_fit(d.v, j, motion.samples[static_cast<std::size_t>(i)], motion.half).c0;
      if (!std::isfinite(v)) continue;
      dot += v * motion.v(i, j);
      slope += motion.v(i, j) * motion.v(i, j);
      logged += v * v;
    }
    if (slope < kResting * kResting * motion.length()) continue;
    const double factor = dot / slope;
    const double rest = logged > 0 ? 1 - dot * factor / logged : 1;
    if (std::abs(factor - 1) < kFactor && rest < kRest) continue;
    findings.push_back({.name = "velocity",
                        .signal = "v",
                        .joint = j,
                        .begin_s = d.t[0],
                        .end_s = d.t[d.length() - 1],
                        .size = factor,
                        .unit = "times the derivative of q"});
  }
}

void check_dynamics(const data::Dataset& d, const dynamics::RobotModel* robot, Findings& findings) {
  data::Dataset slow = d;
  const int half = std::max(1, static_cast<int>(std::lround(kSmoothing / d.dt())));
  slow.q = smooth(d.q, half);
  slow.tau = smooth(d.tau, half);
  const int margin = static_cast<int>(std::ceil(kLatest / d.dt())) + 2;
  const Motion motion = local_motion(slow, kSamples, kWindow, margin);
  if (motion.length() < 20 * d.n()) return;
  Sight sight = see(slow, robot, motion);
  const std::size_t before = findings.size();
  undo_degrees(d, robot, motion, sight, findings);
  undo_mistakes(d, robot, motion, sight, findings);
  // Of a log whose columns are in doubt the delay means nothing.
  if (robot && findings.size() == before) check_delay(d, *robot, motion, sight, findings);
}

}  // namespace fricid::doctor
