// Friction of all joints and the rigid body, fitted together to the measured torque.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/windows/window_refinement.hpp"
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

/// What is known of the friction of an arm of the same type.
struct FrictionPrior {
  std::vector<double> theta;
  double sd;  ///< of each parameter, share of its size; waves over the joint angle are free
};

struct ArmTorqueOptions {
  int iterations = 20;          ///< of Levenberg-Marquardt, before and after ripples are looked for
  double smallest_gain = 2e-4;  ///< a step that lowers the objective by a smaller share is the
                                ///< last; before ripples are looked for, 1 %
  bool find_ripples = true;     ///< false: one pass from the ripples that the start has
  RigidBodyOptions rigid_body;
  Eigen::VectorXd nominal;  ///< pi about which the prior of the rigid body is
  std::optional<FrictionPrior> friction_prior;
  CoordinateOptions coordinates;
};

struct ArmTorqueFit {
  Outcome outcome = Outcome::kFailed;
  std::string message = "fit_arm_torque was not called";
  Arm arm;
  Eigen::VectorXd sigma;          ///< (n) rms of the residual [N m]
  std::vector<double> objective;  ///< of each pass, residuals in units of their sigma before it
  double seconds = 0;
};

/// Minimises over all free parameters of friction and rigid body at once, by Levenberg-Marquardt on
/// coordinates (`ArmCoordinates`: physical inertia, friction within its bounds),
///
///     sum_j |Y_j pi + F[f_j(theta_j)] - tau_j|^2 / sigma_j^2  +  |pi - pi_CAD|^2_P
///
/// with F[f_j] as in `JointFrictionData`, P the prior of the rigid body or, without one, a pull
/// that decides what the data leave open; with a friction prior, |theta - theta_A|^2 in units of
/// its standard deviations beside them. Alternating between friction and rigid body would stop
/// where one explains what belongs to the other: load against gravity, above all. Ripples are
/// looked for after a first pass, in what the whole law leaves; sigma is that before each pass.
/// Deterministic; the result does not depend on `jobs`.
/// @throws Stopped on Ctrl-C
ArmTorqueFit fit_arm_torque(const ArmTorqueData& data, const Arm& start,
                            const ArmTorqueOptions& options, int jobs);

/// What the torque says of a fitted arm.
TorquePull torque_pull(const ArmTorqueData& data, const Arm& fitted,
                       const ArmTorqueOptions& options, int jobs);

}  // namespace fricid::estimate
