// The twisted (psi-auxiliary) filter: every particle is drawn knowing all observations to come.
//
// Along a path s_0 .. s_{T-1}, the smoothed means of a linearisation, the future is summarised by
//     psi_t(s_t + d) = exp(kappa_t - d' Lambda_t d / 2 + lambda_t' d)  ~  p(y_t .. y_{T-1} | x_t),
// everything in deviations from s, for the absolute numbers would cancel. With c = f_t(s_t) -
// s_{t+1}, A = df_t/dx at s_t and F the deviation of f_t(x) from s_{t+1},
//
//     log g(F) = kappa - log det(I + Q Lambda) / 2 + lambda' Sigma lambda / 2 - F' G F / 2 + h' F
//     J = (I + Q Lambda)^-1,  Sigma = J Q,  G = J' Lambda,  h = J' lambda      [all at t + 1]
//     Lambda_t = C' R^-1 C + A' G A,   lambda_t = C' R^-1 (y_t - C s_t) + A' (h - G c)
//     x_{t+1} - s_{t+1} ~ N(J F + Sigma lambda, Sigma)
//
// The weight log g(F) - log g(c + A d) measures how far f_t departs from its linearisation, so it
// is zero for all particles of a linear model, whose likelihood estimate is then exact.
// @see Guarniero, Johansen & Lee, JASA 112, 2017
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/smc/bend.hpp"
#include "fricid/smc/kalman.hpp"
#include "fricid/smc/model.hpp"

namespace fricid::smc {

/// Number of observations that psi_t takes into account.
enum class Foresight {
  kWhole,  ///< y_t .. y_{T-1}
  kOne,    ///< y_t alone: the fully adapted filter
};

/// The functions psi_t; made once, filled many times.
struct Twist {
  std::vector<Eigen::VectorXd> s;       ///< (T) reference path
  std::vector<Eigen::VectorXd> c;       ///< (T - 1) f_t(s_t) - s_{t+1}
  std::vector<Eigen::MatrixXd> A;       ///< (T - 1) df_t/dx at s_t
  std::vector<Eigen::MatrixXd> Lambda;  ///< (T)
  std::vector<Eigen::VectorXd> lambda;  ///< (T)
  std::vector<double> kappa;            ///< (T)
  /// Corrections of log psi_t beyond the linearisation of f_t (bend.hpp), (T - 1) or empty. Lambda,
  /// lambda and kappa contain `bend`, but not `kink`. No kink at t = 0.
  std::vector<Quadratic> bend;
  std::vector<Kink> kink;
  Foresight foresight = Foresight::kWhole;

  int steps() const { return static_cast<int>(s.size()); }
};

/// What one step under psi needs, from Lambda and lambda; does not allocate.
class TwistStep {
 public:
  /// @param Q  noise covariance, positive definite
  explicit TwistStep(const Eigen::MatrixXd& Q);
  void compute(const Eigen::MatrixXd& Lambda, const Eigen::VectorXd& lambda);

  Eigen::MatrixXd J, G, factor;  ///< factor: lower Cholesky factor of Sigma
  Eigen::VectorXd h, shift;      ///< shift = Sigma lambda
  double log_constant = 0;       ///< log g(0) - kappa

 private:
  Eigen::MatrixXd Q_, L_, inverse_L_, M_, W_, product_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

/// The backward recursion on a reference path s: for t = T - 2, .., 0 set A, c, bend and kink of t,
/// then add(t).
class TwistRecursion {
 public:
  /// psi_{T-1}; keeps references to all.
  TwistRecursion(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& C, const Eigen::MatrixXd& R,
                 const RowMatrix& y, Foresight foresight, Twist& twist);
  /// psi_t.
  void add(int t);

 private:
  void observe(int t);

  const Eigen::MatrixXd &C_, &R_;
  const RowMatrix& y_;
  Twist& twist_;
  TwistStep step_;
  Eigen::VectorXd G_c_;
  Eigen::MatrixXd G_A_;
};

/// The whole recursion on a reference path whose s, c and A are set.
void twist_backward(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& C, const Eigen::MatrixXd& R,
                    const RowMatrix& y, Foresight foresight, Twist& twist);

/// psi along the smoothed means of `path`, the model linearised there once more.
template <StateSpaceModel M>
void make_twist(M& model, const RowMatrix& y, const GaussianPath& path, Twist& twist,
                Foresight foresight = Foresight::kWhole) {
  const auto T = static_cast<std::size_t>(path.steps());
  twist.s.resize(T);
  twist.c.resize(T - 1);
  twist.A.resize(T - 1);
  for (std::size_t t = 0; t < T; ++t) twist.s[t] = path.smoothed[t].mean;
  Eigen::VectorXd f(model.state_size());
  for (std::size_t t = 0; t + 1 < T; ++t) {
    twist.A[t].resize(model.state_size(), model.state_size());
    model.linearise(static_cast<int>(t), twist.s[t], f, twist.A[t]);
    twist.c[t] = f - twist.s[t + 1];
  }
  twist_backward(model.Q(), model.C(), model.R(), y, foresight, twist);
}

/// The start under psi_0: x_0 ~ N(mean, factor factor') and log of int N(x; m0, P0) psi_0(x) dx.
struct TwistedStart {
  Eigen::VectorXd mean;
  Eigen::MatrixXd factor;
  double log_normaliser;
};
TwistedStart twisted_start(const Gaussian& initial, const Twist& twist);

/// Mean and covariance of x_t (T) under p(x_0) psi_0 and the steps under psi, f_t linearised and
/// without kinks: an approximation of the smoothed moments.
void twisted_moments(const Gaussian& initial, const Eigen::MatrixXd& Q, const Twist& twist,
                     std::span<Gaussian> moments);

}  // namespace fricid::smc
