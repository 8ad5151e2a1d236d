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
#include <cmath>
#include <span>
#include <vector>

#include "fricid/smc/guides.hpp"
#include "fricid/smc/kalman.hpp"
#include "fricid/smc/lanes.hpp"
#include "fricid/smc/model.hpp"

namespace fricid::smc {

/// How far psi_t looks.
enum class Foresight {
  kWhole,  ///< to the last observation
  kOne,    ///< psi_t(x) = p(y_t | x): the fully adapted filter by other algebra
};

/// The functions psi_t; made once, filled many times.
struct Twist {
  std::vector<Eigen::VectorXd> s;       ///< (T) reference path
  std::vector<Eigen::VectorXd> c;       ///< (T - 1) f_t(s_t) - s_{t+1}
  std::vector<Eigen::MatrixXd> A;       ///< (T - 1) df_t/dx at s_t
  std::vector<Eigen::MatrixXd> Lambda;  ///< (T)
  std::vector<Eigen::VectorXd> lambda;  ///< (T)
  std::vector<double> kappa;            ///< (T)
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

/// The backward recursion on a reference path whose s, c and A are set.
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

/// Guide of the twisted filter (guides.hpp).
template <class S>
class TwistedGuide {
 public:
  using Lanes = S;

  /// Keeps a reference to `twist`.
  template <StateSpaceModel M>
  TwistedGuide(const M& model, const Twist& twist)
      : twist_(&twist),
        step_(model.Q()),
        n_(model.state_size()),
        A_(n_, n_),
        G_(n_, n_),
        J_(n_, n_),
        noise_(Eigen::VectorXd::Zero(n_), model.Q()),
        lanes_(static_cast<std::size_t>(kRows * n_), S(0)),
        constants_(static_cast<std::size_t>(kConstants * n_), S(0)) {
    const TwistedStart start = twisted_start(model.initial(), twist);
    log_start_ = start.log_normaliser;
    start_ = NormalSampler<S>(start.mean, start.factor);
  }

  int steps() const { return twist_->steps(); }
  double log_start() const { return log_start_; }
  void start(const S* e, S* x) const { start_.draw(e, x); }

  void prepare(int t) {
    if (t + 1 == steps()) return;
    const auto k = static_cast<std::size_t>(t);
    step_.compute(twist_->Lambda[k + 1], twist_->lambda[k + 1]);
    A_.assign(twist_->A[k]);
    G_.assign(step_.G);
    J_.assign(step_.J);
    noise_.assign(step_.shift, step_.factor);
    set(kHere, twist_->s[k]);
    set(kNext, twist_->s[k + 1]);
    set(kDefect, twist_->c[k]);
    set(kSlope, step_.h);
    // common to all particles, so of no account where weights are only compared
    const bool whole = twist_->foresight == Foresight::kWhole;
    constant_ = whole ? 0 : step_.log_constant + twist_->kappa[k + 1];
  }

  LogWeight<S> log_weight(const S* x, const S* F, bool wants_past) {
    if (F == nullptr) return {S(0), S(0)};
    S *d = row(0), *u = row(1), *v = row(2);
    const S *here = constant(kHere), *next = constant(kNext), *defect = constant(kDefect),
            *h = constant(kSlope);
    for (int i = 0; i < n_; ++i) v[i] = F[i] - next[i];
    S look_ahead(0);
    const bool whole = twist_->foresight == Foresight::kWhole;
    if (!whole || wants_past) {
      look_ahead = S(static_cast<Real<S>>(constant_));
      for (int i = 0; i < n_; ++i) {
        const S slope = fma(S(Real<S>(-0.5)), G_.add_row(i, v, S(0)), h[i]);
        look_ahead = fma(slope, v[i], look_ahead);
      }
    }
    if (!whole) return {look_ahead, S(0)};

    // log g(v) - log g(p), p = c + A d: (v - p)'(h - G (v + p) / 2)
    for (int i = 0; i < n_; ++i) d[i] = x[i] - here[i];
    for (int i = 0; i < n_; ++i) {
      const S p = A_.add_row(i, d, defect[i]);
      u[i] = v[i] + p;
      v[i] -= p;
    }
    S total(0);
    for (int i = 0; i < n_; ++i) {
      const S slope = fma(S(Real<S>(-0.5)), G_.add_row(i, u, S(0)), h[i]);
      total = fma(slope, v[i], total);
    }
    return {total, total - look_ahead};
  }

  void move(const S* F, const S* e, S* x) {
    S* v = row(0);
    const S* next = constant(kNext);
    for (int i = 0; i < n_; ++i) v[i] = F[i] - next[i];
    noise_.draw(e, x);
    for (int i = 0; i < n_; ++i) x[i] = J_.add_row(i, v, x[i]) + next[i];
  }

 private:
  enum Constant { kHere, kNext, kDefect, kSlope, kConstants };
  static constexpr int kRows = 3;

  void set(Constant which, const Eigen::VectorXd& values) {
    S* to = constants_.data() + which * n_;
    for (int i = 0; i < n_; ++i) to[i] = S(static_cast<Real<S>>(values(i)));
  }
  const S* constant(Constant which) const { return constants_.data() + which * n_; }
  S* row(int i) { return lanes_.data() + i * n_; }

  const Twist* twist_;
  TwistStep step_;
  int n_;
  LaneMatrix<S> A_, G_, J_;
  NormalSampler<S> start_, noise_;
  std::vector<S> lanes_, constants_;
  double log_start_ = 0, constant_ = 0;
};

}  // namespace fricid::smc
