// Physically consistent inertial parameters by construction: log-Cholesky parameters of the
// pseudo-inertia (Rucker & Wensing, RA-L 2022).
#pragma once

#include <Eigen/Core>

namespace fricid::dynamics {

using Vector10 = Eigen::Matrix<double, 10, 1>;

/// pi (m, mc, I as in RobotModel) from eta (alpha, d1, d2, d3, s12, s23, s13, t1, t2, t3); any eta
/// in R^10 gives positive mass and a positive-definite pseudo-inertia. Optionally also the Jacobian
/// d pi / d eta.
Vector10 inertia_from_log_cholesky(const Vector10& eta,
                                   Eigen::Matrix<double, 10, 10>* jacobian = nullptr);

/// Inverse map. @pre pseudo_inertia(pi) is positive definite
Vector10 log_cholesky_from_inertia(const Vector10& pi);

/// 4 x 4 pseudo-inertia [Sigma, h; h', m] with Sigma = tr(I)/2 1 - I.
Eigen::Matrix4d pseudo_inertia(const Vector10& pi);

/// The linear map back from a pseudo-inertia.
Vector10 inertia_from_pseudo(const Eigen::Matrix4d& J);

/// T with  pi_F = T pi: the same body in the axes and about the origin of a frame F whose pose in
/// the axes of pi is (R, p).
Eigen::Matrix<double, 10, 10> inertia_in_frame(const Eigen::Matrix3d& R, const Eigen::Vector3d& p);

/// True when a body with density >= 0 can have these parameters (smallest eigenvalue > tolerance *
/// m).
bool is_physical(const Vector10& pi, double tolerance = 0);

}  // namespace fricid::dynamics
