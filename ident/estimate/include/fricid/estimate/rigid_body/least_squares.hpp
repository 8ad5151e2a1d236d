// Rigid-body parameters by weighted linear least squares on the inverse-dynamics model.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "fricid/dynamics/physical_inertia.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/signals/speed_range.hpp"

namespace fricid::estimate {

/// Inertia that the torque alone gives a joint, the other joints at rest: the largest over the
/// poses of the log, and its standard error [kg m^2 or kg].
struct JointInertia {
  int joint = 0;
  double value = 0, error = 0;
};

/// What the rigid-body fit found: standard parameters that are physical, base parameters with their
/// uncertainty, and the linear friction that was estimated beside them.
struct RigidBodyFit {
  Outcome outcome = Outcome::kFailed;
  std::string message = "rigid_body_least_squares was not called";
  std::string prior;  ///< why the nominal values entered as a prior; empty: they did not
  /// Speeds above which rows of joints entered that are too slow for the one asked for; empty: none
  std::string slower;
  /// Joints that the torque gives no inertia, within a standard error, and less than nominal:
  /// friction that lags behind the speed, or a delay, looks like a negative one. The armature of
  /// each is held in `pi`, since a link without inertia cannot be simulated: at its nominal value,
  /// or at the lower end of what is usual, a third of a guess.
  std::vector<JointInertia> without_inertia;

  Eigen::VectorXd pi;                   ///< (11 n + n_c) standard parameters, physically consistent
  std::vector<std::string> base_names;  ///< (b)
  Eigen::VectorXd base;                 ///< (b) least-squares base parameters
  Eigen::VectorXd base_se;              ///< (b) their standard errors
  Eigen::VectorXd base_physical;        ///< (b) base parameters of `pi`
  Eigen::MatrixXd base_of_pi;           ///< (b, 11 n + n_c) base parameters of a body
  /// (b) reference of an error: the value, or the one that would make 2 % of a joint's torque, at
  /// most ten times what the nominal links have
  Eigen::VectorXd base_size;
  Eigen::VectorXd friction_size;  ///< (3 n) Fc, Fv, offset that would make 2 % of the torque
  double condition = 0;           ///< of the weighted observation matrix, columns of unit length

  std::vector<int> rows,
      rows_total;                   ///< (n) samples used and available per joint at the log's rate
  std::vector<int> equations;       ///< (n) rows of the regression after decimation
  std::vector<double> least_speed;  ///< (n) above which rows entered [rad/s]
  std::vector<signals::SpeedRange> speeds;  ///< (n) of the rows
  Eigen::VectorXd sigma;                    ///< (n) standard deviation of the residual [N m]
  Eigen::VectorXd sigma_alone;              ///< (n) the same without the prior; empty: it has none
  Eigen::VectorXd Fc, Fv, offset;           ///< (n) linear friction [N m], [N m s/rad], [N m]
  Eigen::VectorXd Fc_se, Fv_se, offset_se;
  /// (n) friction over the torque on a side of the gear [1], as `rigid_body_under_load` found it;
  /// empty: the data do not show any
  Eigen::VectorXd growth, growth_se;
  GearSide growth_of = GearSide::kMotor;
  /// Whether this regression has no such growth although the data show it: growth with the torque
  /// of the motor scales the bodies, and the standard errors contain that.
  bool lacks_growth = false;
  /// (n) Coulomb and viscous friction of the same regression beside `pi`, which moves them where
  /// the unconstrained estimate is no body
  Eigen::VectorXd Fc_beside, Fv_beside;
  /// (n) factor of a fitted law's torque beside which `pi` was found, about 1; empty: linear
  /// friction
  Eigen::VectorXd law_factor;
  /// (n) of the prior about zero of the robot's constant torque at each joint; infinite: none [N m]
  Eigen::VectorXd offset_prior_sd;
  double seconds = 0;

  /// Whether its friction grows with the load, by four standard errors.
  bool shows_growth(int joint) const;
  /// Whether Coulomb and viscous friction of a joint cannot be told apart.
  bool moves_at_one_speed(int joint) const;
};

/// Friction torque of a model, per sequence (T, n), filtered as the measured torque.
using FrictionTorques = std::vector<RowMatrix>;

/// Solves, over the rows with |v_j| > min_speed_rad_s now and no reversal near,
///
///     tau_j = Y_j(q, v, a) pi + Fc_j F[sign v_j] + Fv_j v_j + offset_j + e_j
///     e_j ~ N(0, sigma_j^2)
///
/// F[.] being the filter that the torque went through. Slow rows are left out because hysteretic
/// friction there looks like negative inertia. Rows are decimated until residuals are about white;
/// sigma_j is estimated by iteration and weights joint j; `robust` adds Huber weights. Without a
/// prior the base parameters are free; with one, pi ~ N(CAD, P) with P from `prior_covariance`.
/// `pi` is then the physical parameter set closest to the estimate in the metric of its covariance,
/// pulled weakly to the CAD values where the data do not determine it (`fit_physical_inertia`).
/// @param shape  friction torque of a fitted law that replaces F[sign v_j], its factor (about 1) in
///               the place of Fc_j; with hysteresis in the shape, slow rows may enter: set
///               min_speed_rad_s = 0
RigidBodyFit rigid_body_least_squares(const dynamics::RobotModel& robot,
                                      std::span<const signals::Recording> sequences,
                                      const RigidBodyOptions& options,
                                      const FrictionTorques* shape = nullptr);

/// The same regression with Coulomb friction that grows with a load l,
///
///     tau_j = Y_j(q, v, a) pi + (Fc_j + g_j |l_j|) F[sign v_j] + Fv_j v_j + offset_j + e_j,
///
/// l being the torque of the motor or that which reaches the link, Y pi, whichever leaves less,
/// where the data show it: g_j above 0.01 and six standard errors, and a residual variance of that
/// joint that falls by a factor of three. Else nothing. Without g_j friction that grows with the
/// torque of the motor scales what this moves: where it drives, tau = (Y pi + Fc)/(1 - g). Growth
/// with that of the link scales nothing, since it is the same up and down.
/// l is what the regression itself predicts, by repetition: measured, the torque would explain
/// itself. g ~ N(0, 0.1^2) beforehand; joints of negative g have none. Standard errors are
/// conditional on that load.
/// @param without  the fit by `rigid_body_least_squares`
std::optional<RigidBodyFit> rigid_body_under_load(const dynamics::RobotModel& robot,
                                                  std::span<const signals::Recording> sequences,
                                                  const RigidBodyOptions& options,
                                                  const RigidBodyFit& without);

/// Adds the distance to the regression under load to the standard errors, in quadrature, and takes
/// over its growth: a fit that has it otherwise, or lacks it, is off by about as much.
void widen_errors(const RigidBodyFit& under_load, RigidBodyFit& fit);

/// The options with the prior and the held armatures that a fit was found to need, for further fits
/// of the same log.
RigidBodyOptions as_needed(RigidBodyOptions options, const RigidBodyFit& fit);

/// Covariance (11 n square) of the CAD values: mass, armature and central inertia with relative
/// standard deviations, centre of mass with an absolute one, propagated to (m, m c, I) of each
/// link. What is a guess has a standard deviation of at least three times itself.
/// @param held  joints whose armature is known
Eigen::MatrixXd prior_covariance(const dynamics::RobotModel& robot, const PriorOptions& prior,
                                 const dynamics::Guesses& guesses = {},
                                 const std::vector<int>& held = {});

/// Minimises 1/2 |G pi - d|^2 over physical parameters: every link's pseudo-inertia positive
/// definite, every armature positive, linear torques free. The cone is convex, so the barrier
/// method (- mu log det of the pseudo-inertias, mu -> 0) finds the global minimum; its iterates are
/// strictly inside, so the result has log-Cholesky coordinates (Wensing, Kim & Slotine, RA-L 2018;
/// Rucker & Wensing 2022).
/// @param G      (m x p) of full column rank
/// @param d      (m)
/// @param start  physical parameters (p), e.g. the CAD values; a zero armature is raised
Eigen::VectorXd fit_physical_inertia(const dynamics::RobotModel& robot, const Eigen::MatrixXd& G,
                                     const Eigen::VectorXd& d, const Eigen::VectorXd& start);

/// The same for one body. @param G  (m x 10)
dynamics::Vector10 fit_physical_body(const Eigen::MatrixXd& G, const Eigen::VectorXd& d,
                                     const dynamics::Vector10& start);

/// Inverse-dynamics torque  Y(q, v, a) pi  of every sample (T, n).
RowMatrix rigid_body_torque(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                            const signals::Recording& sequence);

}  // namespace fricid::estimate
