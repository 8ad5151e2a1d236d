// Rows of torque of all joints, with the regressor of the rigid body.
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// The torque of an arm as rows of all joints at the rate of the filter, with the regressor of the
/// rigid body.
class ArmTorqueData {
 public:
  /// @param begin, end  per recording, samples that count; empty: all of them
  ArmTorqueData(const dynamics::RobotModel& robot, std::span<const signals::Recording> recordings,
                double cutoff_hz, std::span<const int> begin = {}, std::span<const int> end = {});

  /// Friction under the load that the recordings have now.
  void take_load();
  /// Where single springs are at first, which nothing says, and how long it matters.
  struct Springs {
    Eigen::MatrixXd deflection;  ///< (recordings, n) [rad or m]
    Eigen::MatrixXi until;       ///< (recordings, n) sample from which they have forgotten it
  };
  /// From now on residuals count from their mean over the rows of a recording before `until`: an
  /// error of the deflection is a constant torque there.
  void take_springs(const Springs& springs);
  /// The same deflections alone, rows as they are.
  void begin_springs_at(const Eigen::MatrixXd& deflection);
  /// (recordings) squares of the residual of joint j [N^2 m^2].
  Eigen::VectorXd squares(const Arm& arm, int j) const;

  struct Joint {
    JointFrictionData friction;         ///< its target is the whole torque of the joint
    std::vector<std::vector<int>> row;  ///< per recording, samples that count
    Eigen::MatrixXd Y;                  ///< (rows x p) regressor
    Eigen::VectorXd tau;                ///< (rows) [N m]
    Eigen::MatrixXd YY;                 ///< Y'Y (p x p)
    /// First row and number of rows of the ranges over which a constant torque is unknown; Y, tau
    /// and F[f] are less their means there.
    std::vector<std::pair<Eigen::Index, Eigen::Index>> open;

    /// (rows) F[f] of friction of one joint [N m].
    Eigen::VectorXd predict(const friction::RobotFriction& one,
                            std::span<const double> theta) const;
    /// x (rows x m) less the means of its columns over each range of `open`.
    void centre(Eigen::Ref<Eigen::MatrixXd> x) const;
  };
  const Joint& joint(int j) const { return joints_[static_cast<std::size_t>(j)]; }
  int n() const { return static_cast<int>(joints_.size()); }
  double cutoff_hz() const { return cutoff_hz_; }
  std::span<const signals::Recording> recordings() const { return recordings_; }

  /// (rows) Y pi + F[f_j(theta)] - tau of joint j [N m].
  Eigen::VectorXd residual(const Arm& arm, int j) const;
  /// `JointFrictionData::load_gain` of joint j.
  double load_gain(const Arm& arm, int j) const;

 private:
  JointFrictionData friction_of(std::span<const RowMatrix> torque, int j,
                                std::span<const std::vector<int>> row) const;

  struct Whole {
    Eigen::MatrixXd Y;
    Eigen::VectorXd tau;
  };

  std::vector<Joint> joints_;
  std::vector<Whole> whole_;    // of each joint before it was centred; empty: none was
  Eigen::MatrixXd deflection_;  // of springs (recordings, n); empty: 0
  std::span<const signals::Recording> recordings_;
  double cutoff_hz_;
};

}  // namespace fricid::estimate
