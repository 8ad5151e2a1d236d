#include "fricid/dynamics/physical_inertia.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace fricid::dynamics {
namespace {

using Eigen::Matrix4d;

/// U of the pseudo-inertia U U', eq. (24) of Rucker & Wensing.
Matrix4d upper_factor(const Vector10& eta) {
  const double e1 = std::exp(eta(1)), e2 = std::exp(eta(2)), e3 = std::exp(eta(3));
  Matrix4d U;
  U << e1, eta(4), eta(6), eta(7),  //
      0, e2, eta(5), eta(8),        //
      0, 0, e3, eta(9),             //
      0, 0, 0, 1;
  return std::exp(eta(0)) * U;
}

/// U upper with J = U U'. A fit may end where J is singular to rounding: pivots are kept at a share
/// of the diagonal that changes J by no more than rounding does.
Matrix4d upper_factor_of(const Matrix4d& J) {
  constexpr double kLeastPivot = 1e-14;
  Matrix4d U = Matrix4d::Zero();
  for (int j = 3; j >= 0; --j) {
    const double pivot = J(j, j) - U.row(j).squaredNorm();
    U(j, j) = std::sqrt(std::max(pivot, kLeastPivot * std::max(J(j, j), J.trace())));
    for (int i = 0; i < j; ++i) U(i, j) = (J(i, j) - U.row(i).dot(U.row(j))) / U(j, j);
  }
  return U;
}

}  // namespace

Vector10 inertia_from_log_cholesky(const Vector10& eta, Eigen::Matrix<double, 10, 10>* jacobian) {
  const Matrix4d U = upper_factor(eta);
  if (jacobian) {
    const double scale = std::exp(eta(0));
    for (int k = 0; k < 10; ++k) {
      Matrix4d dU = Matrix4d::Zero();
      if (k == 0) dU = U;
      if (k >= 1 && k <= 3) dU(k - 1, k - 1) = U(k - 1, k - 1);
      if (k == 4) dU(0, 1) = scale;
      if (k == 5) dU(1, 2) = scale;
      if (k == 6) dU(0, 2) = scale;
      if (k >= 7) dU(k - 7, 3) = scale;
      jacobian->col(k) = inertia_from_pseudo(dU * U.transpose() + U * dU.transpose());
    }
  }
  return inertia_from_pseudo(U * U.transpose());
}

Vector10 log_cholesky_from_inertia(const Vector10& pi) {
  const Matrix4d U = upper_factor_of(pseudo_inertia(pi));
  const double scale = U(3, 3);
  return Vector10{{std::log(scale), std::log(U(0, 0) / scale), std::log(U(1, 1) / scale),
                   std::log(U(2, 2) / scale), U(0, 1) / scale, U(1, 2) / scale, U(0, 2) / scale,
                   U(0, 3) / scale, U(1, 3) / scale, U(2, 3) / scale}};
}

Matrix4d pseudo_inertia(const Vector10& pi) {
  const double half_trace = (pi(4) + pi(6) + pi(9)) / 2;
  Matrix4d J;
  J << half_trace - pi(4), -pi(5), -pi(7), pi(1),  //
      -pi(5), half_trace - pi(6), -pi(8), pi(2),   //
      -pi(7), -pi(8), half_trace - pi(9), pi(3),   //
      pi(1), pi(2), pi(3), pi(0);
  return J;
}

Vector10 inertia_from_pseudo(const Matrix4d& J) {
  return Vector10{{J(3, 3), J(0, 3), J(1, 3), J(2, 3), J(1, 1) + J(2, 2), -J(0, 1),
                   J(0, 0) + J(2, 2), -J(0, 2), -J(1, 2), J(0, 0) + J(1, 1)}};
}

Eigen::Matrix<double, 10, 10> inertia_in_frame(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) {
  Matrix4d into = Matrix4d::Identity();
  into.topLeftCorner<3, 3>() = R.transpose();
  into.topRightCorner<3, 1>() = -R.transpose() * p;
  Eigen::Matrix<double, 10, 10> T;
  for (int a = 0; a < 10; ++a)
    T.col(a) = inertia_from_pseudo(into * pseudo_inertia(Vector10::Unit(a)) * into.transpose());
  return T;
}

bool is_physical(const Vector10& pi, double tolerance) {
  const Eigen::SelfAdjointEigenSolver<Matrix4d> solver(pseudo_inertia(pi), Eigen::EigenvaluesOnly);
  return pi.allFinite() && solver.eigenvalues()(0) > tolerance * pi(0);
}

}  // namespace fricid::dynamics
