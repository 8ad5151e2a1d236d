#include "rigid_body/frames.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"

namespace fricid::estimate {
namespace {

constexpr double kBeliefInFrames = 1;  // held-out gain: log of the variances, all joints
constexpr double kWorthAJoint = 0.3;   // of another joint beside those found
constexpr double kWorthTrying = 0.2;   // gain of first order over that of the best joint
constexpr int kMostJoints = 3;
constexpr double kLeastShift = 0.01, kLeastTurn = 0.03;  // [m], [rad]
constexpr double kMostShift = 1.5;  // [m]: more is no link of an arm, but another cause
constexpr double kCertainMove = 4;  // standard errors
constexpr double kUsualShift = 0.3,
                 kUsualTurn = 1;             // [m], [rad]: sd of a weak prior about the file
constexpr double kLargestTurnOfFrame = 0.5;  // [rad] of a step
constexpr int kStepsOfFrames = 6;            // of Gauss-Newton
constexpr double kSettled = 0.01;            // gain of a last step
constexpr int kHalvings = 3;                 // of a step that does not gain
constexpr int kMostSamples = 2000;
constexpr Eigen::Index kRowsPerFramesUnknown = 5;
constexpr Eigen::Index kDofs = 6;  // of a placement: shift, turn
constexpr double kDifference = 1e-6;

using Twist = Eigen::Matrix<double, kDofs, 1>;

Eigen::Matrix3d rotation(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()
                   : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

void move(dynamics::Joint& joint, const Twist& by) {
  joint.p0 += by.head<3>();
  joint.R0 = joint.R0 * rotation(by.tail<3>());
}

/// The regression on evenly chosen samples.
StackedByJoint thinned(const StackedByJoint& all) {
  const auto is_new = [&](std::size_t r) {
    return r == 0 || all.sample[r] != all.sample[r - 1] || all.sequence[r] != all.sequence[r - 1];
  };
  std::vector<int> count;  // of samples up to each row
  for (std::size_t r = 0; r < all.sample.size(); ++r)
    count.push_back((r == 0 ? 0 : count.back()) + (is_new(r) ? 1 : 0));
  const int step = count.empty() ? 1 : std::max(1, count.back() / kMostSamples);
  std::vector<Eigen::Index> now(count.size(), -1);
  StackedByJoint out;
  for (std::size_t r = 0; r < count.size(); ++r) {
    if ((count[r] - 1) % step != 0) continue;
    now[r] = out.rows++;
    out.sample.push_back(all.sample[r]);
    out.sequence.push_back(all.sequence[r]);
    out.passage.push_back(all.passage[r]);
  }
  out.base = all.base;
  out.plain = out.with_growth = out.size = all.plain;
  out.parameters = all.parameters;
  for (const JointRows& rows : all.joints) {
    Columns at, chosen;
    for (std::size_t i = 0; i < rows.at.size(); ++i)
      if (const Eigen::Index row = now[static_cast<std::size_t>(rows.at[i])]; row >= 0) {
        at.push_back(row);
        chosen.push_back(static_cast<Eigen::Index>(i));
      }
    out.joints.push_back(
        with_rows(std::move(at), rows.X.leftCols(all.plain)(chosen, Eigen::all), rows.y(chosen)));
  }
  return out;
}

/// d(Y pi)/d(xi) of the placements of some joints in the rows of each joint (N_j x 6 joints) [N m
/// per m and rad].
std::vector<Eigen::MatrixXd> torque_of_placements(const dynamics::RobotModel& robot,
                                                  const StackedByJoint& all,
                                                  const Eigen::VectorXd& x,
                                                  std::span<const signals::Recording> recordings,
                                                  const std::vector<int>& joints) {
  const auto n = static_cast<std::size_t>(robot.n());
  const Eigen::VectorXd pi = all.standard(x, robot.parameter_count());
  std::vector<dynamics::RobotModel> moved{robot};
  for (const int joint : joints)
    for (Eigen::Index k = 0; k < kDofs; ++k) {
      moved.push_back(robot);
      move(moved.back().joints[static_cast<std::size_t>(joint)], kDifference * Twist::Unit(k));
    }
  const auto columns = std::ssize(moved) - 1;
  std::vector<dynamics::Workspace<double>> workspaces(moved.begin(), moved.end());
  Eigen::RowVectorXd unmoved(robot.n()), torque(robot.n());
  return rows_by_sample(all, columns, [&](int sequence, int sample, RowMatrix& of_sample) {
    const signals::Motion& motion = recordings[static_cast<std::size_t>(sequence)].narrow;
    const auto row = [&](const RowMatrix& of) {
      return std::span<const double>(of.row(sample).data(), n);
    };
    const auto torque_of = [&](std::size_t k, Eigen::RowVectorXd& out) {
      dynamics::rnea<double>(moved[k], workspaces[k],
                             {pi.data(), static_cast<std::size_t>(pi.size())}, row(motion.q),
                             row(motion.v), row(motion.a), {out.data(), n});
    };
    torque_of(0, unmoved);
    for (Eigen::Index k = 0; k < columns; ++k) {
      torque_of(static_cast<std::size_t>(k) + 1, torque);
      of_sample.row(k) = (torque - unmoved) / kDifference;
    }
  });
}

/// Standard errors of the twists (6 per joint, as rows of a root of their covariance) by the
/// jackknife. @param placements  of the same joints
Eigen::MatrixXd errors_of(const StackedByJoint& all, const Solution& plain,
                          const std::vector<Eigen::MatrixXd>& placements) {
  const StackedByJoint with = with_columns(all, placements);
  const Eigen::Index more = with.size - all.plain;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(with.size);
  x.head(all.plain) = plain.x;
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(with.size, with.size);
  for (Eigen::Index k = 0; k < more; ++k)
    prior(all.plain + k, all.plain + k) = std::pow(k % kDofs >= 3 ? kUsualTurn : kUsualShift, -2);
  return jackknife_root(with, x, plain.sigma, prior).bottomRows(more);
}

/// The regression under some placements, and what it leaves.
struct Regressed {
  dynamics::RobotModel robot;
  StackedByJoint all;
  Solution plain;
};

/// The twists (6 per joint) of some of the columns of placements, beside all plain columns.
struct Step {
  Eigen::VectorXd twist;
  double gain = 0;  ///< over the plain regression
};
Step step_of(const Regressed& at, const std::vector<Eigen::MatrixXd>& placements,
             const Columns& chosen) {
  const Eigen::Index plain = at.all.plain, more = std::ssize(chosen);
  std::vector<Eigen::MatrixXd> columns;
  for (const Eigen::MatrixXd& of_joint : placements)
    columns.push_back(of_joint(Eigen::all, chosen));
  StackedByJoint with = with_columns(at.all, columns);
  // the weak prior counts as what joint 0 knows
  const double noise = std::pow(at.plain.sigma[0], 2);
  for (Eigen::Index k = 0; k < more; ++k) {
    const bool turns = chosen[static_cast<std::size_t>(k)] % kDofs >= 3;
    with.joints[0].XX(plain + k, plain + k) +=
        noise / std::pow(turns ? kUsualTurn : kUsualShift, 2);
  }
  const Solution found = solve(with, with.plain);
  return {found.x.tail(more), gain_of(at.plain.sigma, found.sigma)};
}

Columns columns_of(std::size_t joint) {
  Columns columns(kDofs);
  std::iota(columns.begin(), columns.end(), static_cast<Eigen::Index>(joint) * kDofs);
  return columns;
}

/// A fit of placements.
class FrameFit {
 public:
  FrameFit(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
           std::span<const signals::Recording> recordings, const RigidBodyOptions& options)
      : recordings_(recordings), options_(&options) {
    now_ = regressed(robot, stacked);
    file_ = now_.plain.sigma;
  }

  const Regressed& now() const { return now_; }
  /// Over the placements of the file.
  double gain() const { return gain_of(file_, now_.plain.sigma); }

  /// What the placement of each joint behind the first, beside those of `joints`, gains to first
  /// order (n).
  Eigen::VectorXd gains_beside(const std::vector<int>& joints) const {
    std::vector<int> others;
    for (int j = 1; j < now_.robot.n(); ++j)
      if (std::ranges::count(joints, j) == 0) others.push_back(j);
    const std::vector<Eigen::MatrixXd> placements =
        torque_of_placements(now_.robot, now_.all, now_.plain.x, recordings_, others);
    Eigen::VectorXd gains = Eigen::VectorXd::Zero(now_.robot.n());
    for (std::size_t i = 0; i < others.size(); ++i)
      gains[others[i]] = step_of(now_, placements, columns_of(i)).gain;
    return gains;
  }

  /// Gauss-Newton on the zero of a joint alone. @return the zero [rad or m]
  double fit_zero(int joint) {
    const dynamics::Joint& of_file = now_.robot.joints[static_cast<std::size_t>(joint)];
    const Eigen::Vector3d axis = of_file.axis;
    Twist along = Twist::Zero();
    along.segment<3>(slides(of_file) ? 0 : 3) = slides(of_file) ? of_file.R0 * axis : axis;
    double zero = 0;
    for (int step = 0; step < kStepsOfFrames; ++step) {
      std::vector<Eigen::MatrixXd> column =
          torque_of_placements(now_.robot, now_.all, now_.plain.x, recordings_, {joint});
      for (Eigen::MatrixXd& of_joint : column) of_joint = (of_joint * along).eval();
      Eigen::VectorXd by = step_of(now_, column, {0}).twist;
      if (!by.allFinite()) break;
      by *= std::min(1.0, kLargestTurnOfFrame / std::max(std::abs(by[0]), 1e-12));
      const double before = gain();
      const double taken = try_along({joint}, along * by[0]).second;
      zero += taken * by[0];
      if (gain() - before < kSettled) break;
    }
    return zero;
  }

  /// Standard errors of the placements of these joints, rows of a root of their covariance.
  Eigen::MatrixXd errors(const std::vector<int>& joints) const {
    return errors_of(now_.all, now_.plain,
                     torque_of_placements(now_.robot, now_.all, now_.plain.x, recordings_, joints));
  }

  /// Gauss-Newton on the placements of these joints.
  void fit(const std::vector<int>& joints) {
    for (int step = 0; step < kStepsOfFrames; ++step) {
      const std::vector<Eigen::MatrixXd> placements =
          torque_of_placements(now_.robot, now_.all, now_.plain.x, recordings_, joints);
      Columns all(joints.size() * kDofs);
      std::iota(all.begin(), all.end(), 0);
      Eigen::VectorXd twist = step_of(now_, placements, all).twist;
      if (!twist.allFinite()) return;
      for (std::size_t i = 0; i < joints.size(); ++i) {
        auto turn = twist.segment<3>(static_cast<Eigen::Index>(i) * kDofs + 3);
        turn *= std::min(1.0, kLargestTurnOfFrame / std::max(turn.norm(), 1e-12));
      }
      if (try_along(joints, twist).first < kSettled) return;
    }
  }

 private:
  Regressed regressed(dynamics::RobotModel robot, const StackedByJoint& stacked) const {
    Regressed out{std::move(robot), thinned(with_curves(stacked)), {}};
    out.plain = solve(out.all, out.all.plain);
    return out;
  }

  /// Takes the step, or a part of it, where it gains. @return what it gains, and the part
  std::pair<double, double> try_along(const std::vector<int>& joints, Eigen::VectorXd twist) {
    double part = 1;
    for (int halving = 0; halving <= kHalvings; ++halving, twist /= 2, part /= 2) {
      dynamics::RobotModel moved = now_.robot;
      for (std::size_t i = 0; i < joints.size(); ++i)
        move(moved.joints[static_cast<std::size_t>(joints[i])],
             twist.segment<kDofs>(static_cast<Eigen::Index>(i) * kDofs));
      Regressed then = regressed(moved, stack_by_joint(moved, recordings_, *options_));
      const double gained = gain_of(now_.plain.sigma, then.plain.sigma);
      if (!(gained > 0)) continue;
      now_ = std::move(then);
      return {gained, part};
    }
    return {0, 0};
  }

  std::span<const signals::Recording> recordings_;
  const RigidBodyOptions* options_;
  Regressed now_;
  Eigen::VectorXd file_;  // sigma
};

}  // namespace

MovedFrames find_moved_frames(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
                              std::span<const signals::Recording> recordings,
                              const RigidBodyOptions& options) {
  MovedFrames found;
  if (robot.n() < 2 || stacked.rows < kRowsPerFramesUnknown * (stacked.plain + kDofs)) return found;
  FrameFit fit(robot, stacked, recordings, options);
  const StackedByJoint of_file = fit.now().all;
  std::vector<int> joints;
  while (static_cast<int>(joints.size()) < std::min(kMostJoints, robot.n() - 1)) {
    // far from the file the first order says little of which joint it is
    const Eigen::VectorXd gains = fit.gains_beside(joints);
    std::optional<FrameFit> best;
    int added = -1;
    for (int j = 1; j < robot.n(); ++j) {
      if (!(gains[j] > kWorthTrying * gains.maxCoeff()) || !(gains.maxCoeff() > kWorthAJoint))
        continue;
      std::vector<int> with = joints;
      with.push_back(j);
      FrameFit tried = fit;
      tried.fit(with);
      if (best && !(tried.gain() > best->gain())) continue;
      best = std::move(tried);
      added = j;
    }
    if (!best || !(best->gain() > fit.gain() + kWorthAJoint)) break;
    joints.push_back(added);
    fit = *std::move(best);
  }
  if (joints.empty() || !(fit.gain() > kBeliefInFrames)) return found;
  const auto held_out = [](const StackedByJoint& all) { return held_out_sigma(all, all.plain); };
  if (!(gain_of(held_out(of_file), held_out(fit.now().all)) > kBeliefInFrames)) return found;
  // another zero of one joint may pass for another place of its neighbour
  for (int j = 1; j < robot.n(); ++j) {
    FrameFit alone(robot, stacked, recordings, options);
    const double zero = alone.fit_zero(j);
    if (!(alone.gain() > fit.gain() - kWorthAJoint)) continue;
    const bool turns = !slides(robot.joints[static_cast<std::size_t>(j)]);
    if (!(std::abs(zero) > (turns ? kLeastTurn : kLeastShift))) return found;
    found.gain = alone.gain();
    found.joints = {{.joint = j, .zero = zero}};
    return found;
  }
  std::ranges::sort(joints);
  const Eigen::MatrixXd root = fit.errors(joints);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const int j = joints[i];
    const dynamics::Joint& was = robot.joints[static_cast<std::size_t>(j)];
    const dynamics::Joint& is = fit.now().robot.joints[static_cast<std::size_t>(j)];
    const Eigen::AngleAxisd turned(Eigen::Matrix3d(was.R0.transpose() * is.R0));
    const auto first = static_cast<Eigen::Index>(i) * kDofs;
    const auto certain = [&](const Eigen::Vector3d& moved, Eigen::Index row, double least) {
      const double error = (moved.transpose() * root.middleRows<3>(row)).norm() / moved.norm();
      return moved.norm() > std::max(least, kCertainMove * error);
    };
    MovedFrame moved{j, is.p0 - was.p0, turned.angle() * turned.axis()};
    if (moved.by.norm() > kMostShift) return {};
    if (!certain(moved.by, first, kLeastShift)) moved.by.setZero();
    if (!certain(moved.turn, first + 3, kLeastTurn)) moved.turn.setZero();
    if (!moved.by.isZero() || !moved.turn.isZero()) found.joints.push_back(moved);
  }
  if (!found.joints.empty()) found.gain = fit.gain();
  return found;
}

}  // namespace fricid::estimate
