// Information of an excitation trajectory, and its margins to the limits.
#pragma once

#include <span>
#include <vector>

#include "fricid/dynamics/algorithms.hpp"
#include "fricid/sim/clearance.hpp"
#include "fricid/sim/excitation.hpp"

namespace fricid::sim {

/// Tolerated excess of a limit between the points of the final check, as a share and in metres.
inline constexpr double kShareGuard = 2e-3, kClearanceGuard = 1e-3;

/// Limits of one joint.
struct Bounds {
  double centre, half, velocity, acceleration, jerk, effort;
};

/// Data shared by all trajectories of a scene.
struct ExcitationProblem {
  const ExcitationOptions& config;
  const MujocoArm& arm;
  const dynamics::RobotModel& robot;
  std::vector<Bounds> bounds;
  std::vector<int> columns;  ///< of the base parameters
  TimeGrid design, check;
  Eigen::MatrixXd known;  ///< information of earlier data / this period; empty: none

  /// @throws UserError where the box of a joint is outside its limits
  ExcitationProblem(const ExcitationOptions& c, const MujocoArm& m, const dynamics::RobotModel& r);
};

/// Workspace of one thread to judge trajectories.
class ExcitationJudge {
 public:
  explicit ExcitationJudge(const ExcitationProblem& problem);

  /// Information matrix  mean_t Y_b' W Y_b + known,  W = diag(1 / effort^2).
  Eigen::MatrixXd information(const Motion& motion);
  /// Largest share of the effort limit that rigid body and friction allowance take, per motor.
  Eigen::VectorXd torque_shares(const Motion& motion);
  /// Closest approach on the whole motion.
  Clearance::Pair closest(const Motion& motion, int stride = 1);
  const Clearance& clearance() const { return clearance_; }

 private:
  Motion at_motors(const Motion& motion) const;

  const ExcitationProblem& problem_;
  Eigen::MatrixXd C_;  ///< motors of joints; empty without couplings
  dynamics::Workspace<double> ws_;
  Clearance clearance_;
  Eigen::MatrixXd Y_, Y_base_;
};

/// Condition number of the weighted regressor, from its information.
double condition(const Eigen::MatrixXd& H);

/// Violation of torque and clearance limits, as shares.
double violation(const ExcitationProblem& problem, ExcitationJudge& judge, const Motion& motion,
                 int stride = 1);

/// Margins of a trajectory on a grid, and its information.
TrajectoryReport examine_on(const ExcitationProblem& problem, ExcitationJudge& judge,
                            const Fourier& series, const TimeGrid& grid);

}  // namespace fricid::sim
