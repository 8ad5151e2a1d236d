#include "rigid_body/zeros.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/dynamics/algorithms.hpp"

namespace fricid::estimate {
namespace {

constexpr double kLeastGain = 0.1;    // log of the variance of a joint
constexpr double kLeastShift = 5e-3;  // [rad or m]: what a mastering may err
constexpr double kCertainShift = 6;   // standard errors
constexpr int kStepsOfZeros = 3;
constexpr Eigen::Index kRowsPerOwnUnknown = 5;  // of the log

/// The logs as one regression on what they share, and one of them on what is its own besides.
struct WithOwn {
  StackedByJoint all;  ///< normal equations of the shared columns, then those of the log's own
  std::vector<Columns> rows;  ///< of each joint: of the log, among those of the joint
  Columns own;                ///< shared columns that the log has once more for itself, then shifts
};

WithOwn with_own(const StackedByJoint& shared, const std::vector<Eigen::MatrixXd>& shifts,
                 const Columns& friction, int sequence) {
  const Eigen::Index n = shared.n(), size = shared.plain;
  WithOwn out;
  out.own = friction;
  for (Eigen::Index j = 0; j < n; ++j) out.own.push_back(size + j);
  const Eigen::Index more = std::ssize(out.own);
  out.all.rows = shared.rows;
  out.all.size = out.all.plain = size + more;
  for (std::size_t j = 0; j < shared.joints.size(); ++j) {
    const JointRows& joint = shared.joints[j];
    Columns chosen;
    for (std::size_t i = 0; i < joint.at.size(); ++i)
      if (shared.sequence[static_cast<std::size_t>(joint.at[i])] == sequence)
        chosen.push_back(static_cast<Eigen::Index>(i));
    Eigen::MatrixXd X(std::ssize(chosen), size + n);
    X << joint.X(chosen, Eigen::seqN(0, size)), shifts[j](chosen, Eigen::all);
    const Eigen::MatrixXd own = X(Eigen::all, out.own);
    JointRows rows = joint;
    rows.XX = Eigen::MatrixXd::Zero(size + more, size + more);
    rows.XX.topLeftCorner(size, size) = joint.XX.topLeftCorner(size, size);
    rows.XX.topRightCorner(size, more) = X.leftCols(size).transpose() * own;
    rows.XX.bottomLeftCorner(more, size) = rows.XX.topRightCorner(size, more).transpose();
    rows.XX.bottomRightCorner(more, more) = own.transpose() * own;
    rows.Xy.resize(size + more);
    rows.Xy << joint.Xy.head(size), own.transpose() * joint.y(chosen);
    out.all.joints.push_back(std::move(rows));
    out.rows.push_back(std::move(chosen));
  }
  return out;
}

/// Standard errors of the shifts by the jackknife. @param found  the solution with them
Eigen::VectorXd errors_of(const StackedByJoint& shared, const std::vector<Eigen::MatrixXd>& shifts,
                          const WithOwn& log, const Solution& found) {
  const Eigen::Index n = shared.n(), size = shared.plain, all = found.x.size();
  const auto rows = [&](int j) {
    const auto at = static_cast<std::size_t>(j);
    const JointRows& joint = shared.joints[at];
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(std::ssize(joint.at), all);
    X.leftCols(size) = joint.X.leftCols(size);
    Eigen::MatrixXd own(X.rows(), size + n);
    own << joint.X.leftCols(size), shifts[at];
    X(log.rows[at], Eigen::lastN(all - size)) = own(log.rows[at], log.own);
    return std::pair(X, joint.y);
  };
  return jackknife_root(shared, found.x, found.sigma, Eigen::MatrixXd::Zero(all, all), rows)
      .bottomRows(n)
      .rowwise()
      .norm();
}

/// Torque of the shifts of all joints in the rows of each (N_j x n).
std::vector<Eigen::MatrixXd> shifts_of_joints(const dynamics::RobotModel& robot,
                                              const StackedByJoint& all, const Solution& plain,
                                              std::span<const signals::Recording> recordings) {
  const Eigen::MatrixXd of_rows =
      torque_of_shifts(robot, all.standard(plain.x, robot.parameter_count()), all.joint_of_rows(),
                       all.sequence, all.sample, recordings);
  return of_joints(all, of_rows);
}

/// Joints that a log surely shows elsewhere than the others do.
std::set<int> joints_moved_in(const StackedByJoint& shared,
                              const std::vector<Eigen::MatrixXd>& shifts, int sequence) {
  Columns friction;
  for (const Columns* of_kind : {&shared.Fc, &shared.Fv})
    for (const Eigen::Index k : *of_kind)
      if (k >= 0) friction.push_back(k);
  const WithOwn log = with_own(shared, shifts, friction, sequence);
  Eigen::Index rows = 0;
  for (const Columns& of_joint : log.rows) rows += std::ssize(of_joint);
  if (rows < kRowsPerOwnUnknown * std::ssize(log.own)) return {};
  const Eigen::Index n = shared.n();
  const Eigen::VectorXd before = solve(log.all, log.all.plain - n).sigma;
  const Solution found = solve(log.all, log.all.plain);
  const double gain = 2 * (before.array() / found.sigma.array()).log().maxCoeff();
  if (!(gain > kLeastGain)) return {};
  const Eigen::VectorXd error = errors_of(shared, shifts, log, found), x = found.x.tail(n);
  std::set<int> joints;
  for (int j = 0; j < shared.n(); ++j)
    if (std::abs(x[j]) > std::max(kCertainShift * error[j], kLeastShift)) joints.insert(j);
  return joints;
}

/// Logs (rows) that know the zeros of joints (columns): a shift of kLeastShift is more than the
/// noise of all rows. In one in which a joint and all that it carries stand, it may be anything.
Eigen::MatrixXd information_on_zeros(const StackedByJoint& all,
                                     const std::vector<Eigen::MatrixXd>& shifts,
                                     const Eigen::VectorXd& sigma, int logs) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(logs, all.n());
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const double weight = std::pow(kLeastShift / sigma[static_cast<Eigen::Index>(i)], 2);
    const Columns& at = all.joints[i].at;
    for (std::size_t r = 0; r < at.size(); ++r)
      information.row(all.sequence[static_cast<std::size_t>(at[r])]) +=
          weight * shifts[i].row(static_cast<Eigen::Index>(r)).cwiseAbs2();
  }
  return information;
}

/// Zeros (logs x moved) [rad or m] by least squares in what all logs share and the zero of each
/// moved joint in each log that knows it, but for the log that knows it best, in which it is 0.
/// @param sigma  of the joints' residuals in a fit without zeros
Eigen::MatrixXd fit_zeros(const StackedByJoint& shared, const std::vector<Eigen::MatrixXd>& shifts,
                          const Eigen::VectorXd& sigma, const std::vector<int>& moved, int logs) {
  const Eigen::MatrixXd information = information_on_zeros(shared, shifts, sigma, logs);
  StackedByJoint all;
  all.rows = shared.rows;
  all.size = all.plain = shared.plain + std::ssize(moved) * logs;
  for (std::size_t i = 0; i < shared.joints.size(); ++i) {
    const JointRows& rows = shared.joints[i];
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(std::ssize(rows.at), all.plain);
    X.leftCols(shared.plain) = rows.X.leftCols(shared.plain);
    for (std::size_t m = 0; m < moved.size(); ++m) {
      int reference = 0;
      information.col(moved[m]).maxCoeff(&reference);
      const Eigen::Index first = shared.plain + static_cast<Eigen::Index>(m) * logs;
      for (std::size_t r = 0; r < rows.at.size(); ++r) {
        const int s = shared.sequence[static_cast<std::size_t>(rows.at[r])];
        if (s == reference || !(information(s, moved[m]) > 1)) continue;
        const auto row = static_cast<Eigen::Index>(r);
        X(row, first + s) = shifts[i](row, moved[m]);
      }
    }
    all.joints.push_back(normal_equations(X, rows.y));
  }
  return solve(all, all.plain).x.tail(std::ssize(moved) * logs).reshaped(logs, std::ssize(moved));
}

/// Zeros over that of the middle one of the logs; of two in the middle, the lower.
Eigen::MatrixXd about_middle(Eigen::MatrixXd zeros) {
  for (auto zero : zeros.colwise()) {
    std::vector<double> sorted(zero.begin(), zero.end());
    std::ranges::sort(sorted);
    zero.array() -= sorted[(sorted.size() - 1) / 2];
  }
  return zeros;
}

Fault name_zeros(const dynamics::Joint& joint, const Eigen::VectorXd& zero,
                 std::span<const signals::Recording> recordings) {
  std::vector<std::string> logs;
  for (std::size_t s = 0; s < recordings.size(); ++s)
    if (const double by = zero[static_cast<Eigen::Index>(s)]; std::abs(by) > kLeastShift)
      logs.push_back(fmt::format("{} by {:.3g} {}", recordings[s].log.name, by,
                                 unit_of_joint("rad", slides(joint))));
  return {
      joint.name,
      fmt::format("its zero is another one in some logs, which show it further than the others "
                  "do: {}",
                  fmt::join(logs, ", ")),
      "log all with one zero, mend offset_rad of [position] in their contract, or fit them apart"};
}

}  // namespace

Eigen::MatrixXd torque_of_shifts(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                                 std::span<const int> joint, std::span<const int> sequence,
                                 std::span<const int> sample,
                                 std::span<const signals::Recording> recordings) {
  const auto n = static_cast<std::size_t>(robot.n());
  const std::span<const double> parameters(pi.data(), static_cast<std::size_t>(pi.size()));
  const Eigen::MatrixXd motors_of_joints = robot.motors_of_joints();  // motions are those of motors
  dynamics::Workspace<double> ws(robot);
  std::vector<double> one(n);
  RowMatrix of_shifts(robot.n(), robot.n());  // of each joint (row) by the shift of each
  return rows_by_sample(
      joint, sequence, sample, robot.n(), robot.n(), [&](int s, int k, RowMatrix& of_sample) {
        const signals::Motion& motion = recordings[static_cast<std::size_t>(s)].narrow;
        const auto row = [&](const RowMatrix& x) {
          return std::span<const double>(x.row(k).data(), n);
        };
        of_shifts.setZero();
        for (std::size_t i = 0; i < n; ++i) {
          std::ranges::fill(one, 0.0);
          one[i] = -1;
          dynamics::rnea_pullback<double>(
              robot, ws, parameters, row(motion.q), row(motion.v), row(motion.a), one,
              {of_shifts.row(static_cast<Eigen::Index>(i)).data(), n}, {}, {}, {});
        }
        of_sample = (of_shifts * motors_of_joints).transpose();
      });
}

OtherZeros find_other_zeros(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
                            std::span<const signals::Recording> recordings,
                            const RigidBodyOptions& options) {
  OtherZeros out;
  if (recordings.size() < 2) return out;
  const auto logs = static_cast<int>(recordings.size());
  StackedByJoint shared = with_curves(stacked);
  Solution plain = solve(shared, shared.plain);
  std::vector<Eigen::MatrixXd> shifts = shifts_of_joints(robot, shared, plain, recordings);
  std::set<int> all_moved;
  for (int s = 0; s < logs; ++s) all_moved.merge(joints_moved_in(shared, shifts, s));
  if (all_moved.empty()) return out;
  const std::vector<int> moved(all_moved.begin(), all_moved.end());

  // Gauss-Newton: the torque bends within tenths of a radian
  Eigen::MatrixXd zeros = Eigen::MatrixXd::Zero(logs, std::ssize(moved));
  out.mended = stacked;
  const Eigen::MatrixXd motors_of_joints = robot.motors_of_joints();
  for (int step = 0; step < kStepsOfZeros; ++step) {
    if (step > 0) shared = with_curves(out.mended);
    zeros = about_middle(zeros + fit_zeros(shared, shifts, plain.sigma, moved, logs));
    std::vector<signals::Recording> mended(recordings.begin(), recordings.end());
    for (int s = 0; s < logs; ++s)
      for (std::size_t m = 0; m < moved.size(); ++m)
        for (signals::Motion* motion : {&mended[static_cast<std::size_t>(s)].narrow,
                                        &mended[static_cast<std::size_t>(s)].wide})
          motion->q.rowwise() -=
              zeros(s, static_cast<Eigen::Index>(m)) * motors_of_joints.col(moved[m]).transpose();
    out.mended = stack_by_joint(robot, mended, options);
    plain = solve(out.mended, out.mended.plain);
    shifts = shifts_of_joints(robot, out.mended, plain, mended);
  }
  for (std::size_t m = 0; m < moved.size(); ++m) {
    const Eigen::VectorXd zero = zeros.col(static_cast<Eigen::Index>(m));
    if (zero.cwiseAbs().maxCoeff() > kLeastShift)
      out.faults.push_back(
          name_zeros(robot.joints[static_cast<std::size_t>(moved[m])], zero, recordings));
  }
  return out;
}

}  // namespace fricid::estimate
