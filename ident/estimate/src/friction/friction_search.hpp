// Search over the parameters of one joint's friction law, within the bounds of the law table.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "fricid/estimate/friction/friction_fit.hpp"

namespace fricid::estimate {

/// Scaled search coordinates, all of order one: log(theta) where the table says so, else theta over
/// the size of its reference.
class SearchCoordinates {
 public:
  /// @param held  indices of parameters whose bounds close on their reference
  SearchCoordinates(const friction::RobotFriction& friction, std::span<const double> reference,
                    std::span<const std::size_t> held);

  std::vector<double> to_scaled(std::span<const double> theta) const;  ///< within the bounds
  void to_theta(std::span<const double> x, std::span<double> theta) const;

  double slope(std::size_t i, double theta) const;  ///< d theta_i / d x_i

  bool is_log(std::size_t i) const { return log_[i]; }
  bool is_held(std::size_t i) const { return held_[i]; }
  const std::vector<std::size_t>& free() const { return free_; }  ///< those not held
  const std::vector<double>& lower() const { return lower_; }
  const std::vector<double>& upper() const { return upper_; }

 private:
  double to_scaled(std::size_t i, double theta) const;

  std::vector<bool> log_, held_;
  std::vector<std::size_t> free_;
  std::vector<double> unit_, lower_, upper_;
};

/// Objective of a prediction that is not finite: finite for the optimiser.
inline constexpr double kBadValue = 1e30;

/// How far the coordinates of a minimum may err.
struct SearchErrors {
  Eigen::MatrixXd covariance;
  Eigen::VectorXd of_motion;  ///< standard deviation, part of it
};

/// Errors of the coordinates `free` at a minimum, the others held. With J the Jacobian of the
/// residuals e, both beside the best constant, and blocks b of one second, the prior of the
/// constant being one more block,
///
///     sum_b d_b d_b',   d_b = (J'J - J_b'J_b)^-1 sum_{k in b} J_k e_k,
///
/// the jackknife over blocks, linear about the minimum. It holds for correlated residuals (those of
/// filtered signals, or of a law that does not fit) and where few blocks hold what is known of a
/// parameter, as breakaways do of Fs. The error m that the motion makes adds (J'J)^-1 J'm.
/// @see Bell & McCaffrey, Survey Methodology 28(2), 2002
/// @param motion_error  of F[f] at the used rows [N m]; empty: none
SearchErrors search_errors(const JointFrictionData& data, const friction::RobotFriction& friction,
                           const SearchCoordinates& coordinates, std::span<const double> x,
                           std::span<const std::size_t> free, const Eigen::VectorXd& motion_error);

/// Where a search ended.
struct SearchMinimum {
  std::vector<double> x;
  double value;  ///< mean square [N^2 m^2]
  bool converged;
  int evaluations;
};

/// Nelder-Mead within the bounds from x, then `refine`.
/// @throws Stopped on Ctrl-C
SearchMinimum search(const JointFrictionData& data, const friction::RobotFriction& friction,
                     const SearchCoordinates& coordinates, const std::vector<double>& x,
                     const FrictionFitOptions& options);

/// Levenberg-Marquardt from `at` inside the bounds: coordinates that press against a bound are held
/// there.
/// @throws Stopped on Ctrl-C
void refine(const JointFrictionData& data, const friction::RobotFriction& friction,
            const SearchCoordinates& coordinates, SearchMinimum& at, int iterations);

}  // namespace fricid::estimate
