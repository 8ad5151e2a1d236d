// The torque of an arm by joint, for regressions on any of the columns that may explain it.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

using Columns = std::vector<Eigen::Index>;

/// The rows of one joint, y = X x + e, and their normal equations, of which alone regressions are
/// made.
struct JointRows {
  Columns at;  ///< in the stacked regression
  Eigen::MatrixXd X;
  Eigen::VectorXd y;
  Eigen::MatrixXd XX;  ///< X' X
  Eigen::VectorXd Xy;  ///< X' y
  double yy = 0;       ///< |y|^2
  double count = 0;    ///< of rows

  void set_column(Eigen::Index k, const Eigen::VectorXd& x);
  /// ||y - X x||^2
  double squares(const Eigen::VectorXd& x) const;
  /// The normal equations of its rows and those of `other`.
  void add(const JointRows& other);
};

/// Rows and their normal equations.
JointRows with_rows(Columns at, Eigen::MatrixXd X, const Eigen::VectorXd& y);
/// Normal equations alone: without rows.
JointRows normal_equations(const Eigen::MatrixXd& X, const Eigen::VectorXd& y);
/// The same of some rows of a joint on its first `columns`. @param chosen  among the rows of X
JointRows normal_equations(const JointRows& joint, const Columns& chosen, Eigen::Index columns);

/// The torque of a robot in all columns that may explain it, by joint. Each joint's noise is its
/// own, so that every regression on some of the columns follows from the normal equations.
struct StackedByJoint {
  std::vector<JointRows> joints;
  std::vector<Eigen::VectorXd> coulomb;        ///< of each joint: F[sign v_j]
  std::vector<int> passage, sequence, sample;  ///< of each row; see `Regression`
  Eigen::Index rows = 0;
  /// First the base parameters of the robot as it is given, then friction that any row excites,
  /// friction that grows with the load (n), springs.
  Eigen::Index base = 0, plain = 0, with_growth = 0, size = 0;
  Eigen::Index curves = 0;       ///< columns of each joint's friction curve, behind the plain ones
  std::vector<int> parameters;   ///< (base) of the robot: columns of Y
  std::vector<Columns> springs;  ///< of each joint
  Eigen::MatrixXd K;             ///< (base, parameters of the robot), see `BaseParameters`
  Columns Fc, Fv, offset;        ///< (n) column of each joint; -1: no row excites it
  std::vector<std::string> names;  ///< of the plain columns

  int n() const { return static_cast<int>(joints.size()); }
  std::vector<int> joint_of_rows() const;  ///< (rows)
  /// Standard parameters of the robot (count) of which these base parameters are: others are zero.
  Eigen::VectorXd standard(const Eigen::VectorXd& x, int count) const;
};

/// A spring of joint j is c0 q + c1 sin q + c2 cos q, less what gravity explains anyway.
StackedByJoint stack_by_joint(const dynamics::RobotModel& robot,
                              std::span<const signals::Recording> recordings,
                              const RigidBodyOptions& options);

/// Beside Coulomb and viscous friction, F sqrt(|v|) and F exp(-|v| / slow) of each joint, F being
/// F[sign v], as plain columns behind the others: a motion whose speed changes from stretch to
/// stretch would show a Stribeck curve, or viscous friction that is none, as a change.
/// @param loads  (n) of the rows of each joint: F |load| too, friction that grows with the load;
///               empty: without
StackedByJoint with_curves(const StackedByJoint& all, std::span<const Eigen::VectorXd> loads = {});
/// The same under the load that the plain regression predicts.
StackedByJoint with_curves_under_load(const StackedByJoint& all);

/// The plain regression with further columns of each joint (N_j x ..) behind it.
StackedByJoint with_columns(const StackedByJoint& all, const std::vector<Eigen::MatrixXd>& more);

/// What depends on the sample, a row for each of a regression (N x columns).
/// @param joint, sequence, sample  (N) of each row; rows of one sample follow each other
/// @param write  (sequence, sample, of_sample): fills of_sample (columns x n)
Eigen::MatrixXd rows_by_sample(
    std::span<const int> joint, std::span<const int> sequence, std::span<const int> sample, int n,
    Eigen::Index columns,
    const std::function<void(int sequence, int sample, RowMatrix& of_sample)>& write);
/// The same in the rows of each joint (N_j x columns).
std::vector<Eigen::MatrixXd> rows_by_sample(
    const StackedByJoint& all, Eigen::Index columns,
    const std::function<void(int sequence, int sample, RowMatrix& of_sample)>& write);
/// The rows of a regression (N x ..) as those of each joint.
std::vector<Eigen::MatrixXd> of_joints(const StackedByJoint& all, const Eigen::MatrixXd& rows);

/// Writes friction that grows with the load, F[sign v_j] |Y_j pi|, to its columns.
void set_growth(const Eigen::VectorXd& pi, StackedByJoint& all);

struct Solution {
  Eigen::VectorXd x;      ///< 0 in columns left out, and in those of zeros
  Eigen::VectorXd error;  ///< of x, residuals counting as independent
  Eigen::VectorXd sigma;  ///< of the residuals of each joint
  Eigen::Index unknowns = 0;
};

/// Least squares on some columns, weighed by the noise that it leaves to each joint.
Solution solve(const StackedByJoint& all, const Columns& asked);
/// The same on the first columns.
Solution solve(const StackedByJoint& all, Eigen::Index first);

/// Standard deviation of residuals of one joint.
double sigma_of(double squares, const JointRows& rows);

/// Standard deviation of what each fifth of the rows leaves under the regression of the others.
Eigen::VectorXd held_out_sigma(const StackedByJoint& all, const Columns& columns);
/// The same on the first columns.
Eigen::VectorXd held_out_sigma(const StackedByJoint& all, Eigen::Index first);

/// Root of the covariance of x by the jackknife over passages, see `jackknife_root`.
/// @param sigma  of the residuals of each joint
/// @param prior  information on x
/// @param rows   of joint j: X in all columns of x, and y
Eigen::MatrixXd jackknife_root(
    const StackedByJoint& all, const Eigen::VectorXd& x, const Eigen::VectorXd& sigma,
    const Eigen::MatrixXd& prior,
    const std::function<std::pair<Eigen::MatrixXd, Eigen::VectorXd>(int j)>& rows);
/// The same with the rows as they are.
Eigen::MatrixXd jackknife_root(const StackedByJoint& all, const Eigen::VectorXd& x,
                               const Eigen::VectorXd& sigma, const Eigen::MatrixXd& prior);

/// Log of the factor by which the unexplained variance falls, in sum over the joints.
double gain_of(const Eigen::VectorXd& sigma, const Eigen::VectorXd& less);

}  // namespace fricid::estimate
