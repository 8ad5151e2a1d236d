// The guide of the twisted filter: how particles are drawn and weighted under psi (twist.hpp).
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/smc/bend.hpp"
#include "fricid/smc/guides.hpp"
#include "fricid/smc/lanes.hpp"
#include "fricid/smc/normal_distribution.hpp"
#include "fricid/smc/twist.hpp"

namespace fricid::smc {

/// One step under psi_{t+1} on one side of its kink, relative to the step without the kink.
template <class S>
class TwistSide {
 public:
  TwistSide(const Eigen::MatrixXd& Q, int side);
  /// @param smooth  the step without the kink
  void prepare(const Twist& twist, std::size_t next, const TwistStep& smooth);

  /// log of the side's share of g(v), relative to the smooth g(v) and but for log Phi(standard(v)).
  S log_gain(const S* v) const;
  /// Mean over sd of x_state given v, positive towards this side.
  S standard(const S* v) const;
  /// x = s + J v + Sigma lambda + factor e; the factor's column `state` is Sigma e_state / sd, so
  /// that e_state alone moves x_state.
  void move(const S* v, const S* e, S* x) const;

 private:
  int side_, state_ = 0;
  TwistStep step_;
  Eigen::MatrixXd Lambda_;
  Eigen::VectorXd lambda_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  Eigen::MatrixXd difference_;
  LaneMatrix<S> G_, J_, L_;
  std::vector<Real<S>> h_, mean_;
  double log_constant_ = 0, sd_ = 1;
};

template <class S>
TwistSide<S>::TwistSide(const Eigen::MatrixXd& Q, int side)
    : side_(side),
      step_(Q),
      Lambda_(Q),
      lambda_(Q.rows()),
      llt_(Q),
      difference_(Q),
      G_(Q.rows(), Q.rows()),
      J_(Q.rows(), Q.rows()),
      L_(Q.rows(), Q.rows()),
      h_(static_cast<std::size_t>(Q.rows())),
      mean_(h_) {}

template <class S>
void TwistSide<S>::prepare(const Twist& twist, std::size_t next, const TwistStep& smooth) {
  const Kink& kink = twist.kink[next];
  state_ = kink.state;
  Lambda_ = twist.Lambda[next];
  lambda_ = twist.lambda[next];
  double constant = 0;
  kink.add_side(side_, twist.s[next], Lambda_, lambda_, constant);
  step_.compute(Lambda_, lambda_);
  log_constant_ = constant + step_.log_constant - smooth.log_constant;
  difference_ = step_.G - smooth.G;
  G_.assign(difference_);
  J_.assign(step_.J);
  // Cholesky factor of Sigma with x_state first, its other rows and columns in their places
  Lambda_.noalias() = step_.factor * step_.factor.transpose();
  sd_ = std::sqrt(Lambda_(state_, state_));
  lambda_ = Lambda_.col(state_) / sd_;
  Lambda_.noalias() -= lambda_ * lambda_.transpose();
  Lambda_.col(state_).setZero();
  Lambda_.row(state_).setZero();
  Lambda_(state_, state_) = 1;
  llt_.compute(Lambda_);
  Lambda_ = llt_.matrixL();
  Lambda_.col(state_) = lambda_;
  L_.assign(Lambda_);
  for (std::size_t i = 0; i < h_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    h_[i] = static_cast<Real<S>>(step_.h(row) - smooth.h(row));
    mean_[i] = static_cast<Real<S>>(twist.s[next](row) + step_.shift(row));
  }
}

template <class S>
S TwistSide<S>::log_gain(const S* v) const {
  S sum(static_cast<Real<S>>(log_constant_));
  for (int i = 0; i < G_.rows(); ++i) {
    const S slope =
        fma(S(Real<S>(-0.5)), G_.add_row(i, v, S(0)), S(h_[static_cast<std::size_t>(i)]));
    sum = fma(slope, v[i], sum);
  }
  return sum;
}

template <class S>
S TwistSide<S>::standard(const S* v) const {
  const S mean = J_.add_row(state_, v, S(mean_[static_cast<std::size_t>(state_)]));
  return mean * S(static_cast<Real<S>>(side_ / sd_));
}

template <class S>
void TwistSide<S>::move(const S* v, const S* e, S* x) const {
  for (int i = 0; i < L_.rows(); ++i)
    x[i] = L_.add_row(i, e, J_.add_row(i, v, S(mean_[static_cast<std::size_t>(i)])));
}

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
        H_(n_, n_),
        noise_(Eigen::VectorXd::Zero(n_), model.Q()),
        below_(model.Q(), -1),
        above_(model.Q(), 1),
        bend_(Quadratic::zero(n_)),
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
    if (!twist_->bend.empty()) prepare_bends(k);
    // common to all particles, so it cancels where weights are only compared
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
    S total(0);
    if (next_kink_ >= 0) {
      total = sides(v).log_gain;
      look_ahead += total;
    }

    // log g(v) - log g(p), p = c + A d: (v - p)'(h - G (v + p) / 2)
    for (int i = 0; i < n_; ++i) d[i] = x[i] - here[i];
    for (int i = 0; i < n_; ++i) {
      const S p = A_.add_row(i, d, defect[i]);
      u[i] = v[i] + p;
      v[i] -= p;
    }
    for (int i = 0; i < n_; ++i) {
      const S slope = fma(S(Real<S>(-0.5)), G_.add_row(i, u, S(0)), h[i]);
      total = fma(slope, v[i], total);
    }
    if (!twist_->bend.empty()) total -= bend(d);
    if (kink_state_ >= 0) total -= kink(x, d);
    return {total, total - look_ahead};
  }

  void move(const S* F, const S* e, S* x) {
    S* v = row(0);
    const S* next = constant(kNext);
    for (int i = 0; i < n_; ++i) v[i] = F[i] - next[i];
    if (next_kink_ >= 0) return move_on_sides(v, e, x);
    noise_.draw(e, x);
    for (int i = 0; i < n_; ++i) x[i] = J_.add_row(i, v, x[i]) + next[i];
  }

 private:
  enum Constant { kHere, kNext, kDefect, kSlope, kBend, kKink, kConstants };
  static constexpr int kRows = 3;

  /// Where x_{t+1} falls beside its kink, given v.
  struct Sides {
    S log_gain;                    ///< of g(v) over the smooth g(v)
    S share_below;                 ///< P(x_state < 0)
    S within_below, within_above;  ///< Phi of x_state's mean over sd, towards the side
  };
  Sides sides(const S* v) const {
    const S below = below_.log_gain(v), above = above_.log_gain(v), top = max(below, above);
    Sides out;
    out.within_below = normal_cdf(below_.standard(v));
    out.within_above = normal_cdf(above_.standard(v));
    const S w_below = exp(below - top) * out.within_below;
    const S sum = w_below + exp(above - top) * out.within_above;
    out.log_gain = top + log(sum);
    out.share_below = w_below / sum;
    return out;
  }
  /// x_state by the inverse of its distribution function, the others given it.
  void move_on_sides(const S* v, const S* e, S* x) {
    const Sides at = sides(v);
    S *turned = row(1), *other = row(2);
    std::copy_n(e, n_, turned);
    S is_below(0);
    const S e_state = e[next_kink_];
    const S u = normal_cdf(e_state), rest = normal_cdf(-e_state);
    for (int k = 0; k < kLaneCount<S>; ++k) {
      const double share = static_cast<double>(lane(at.share_below, k));
      const double below = static_cast<double>(lane(u, k));
      const bool falls_below = below < share;
      const double p = falls_below
                           ? below / share * static_cast<double>(lane(at.within_below, k))
                           : std::min(1.0, static_cast<double>(lane(rest, k)) / (1 - share)) *
                                 static_cast<double>(lane(at.within_above, k));
      const double z = normal_quantile(std::clamp(p, kLeast, 1 - 1e-16));
      set_lane(turned[next_kink_], k, static_cast<Real<S>>(falls_below ? z : -z));
      set_lane(is_below, k, static_cast<Real<S>>(falls_below ? 1 : 0));
    }
    below_.move(v, turned, other);
    above_.move(v, turned, x);
    for (int i = 0; i < n_; ++i) x[i] = select(is_below > S(0), other[i], x[i]);
  }
  S kink(const S* x, const S* d) const {
    const S* g = constant(kKink);
    S slope(static_cast<Real<S>>(kink_constant_));
    for (int i = 0; i < n_; ++i) slope = fma(g[i], d[i], slope);
    return abs(x[kink_state_]) * slope;
  }
  static constexpr double kLeast = 1e-300;

  void prepare_bends(std::size_t t) {
    const Kink& kink = twist_->kink[t];
    bend_ = twist_->bend[t];
    kink_state_ = kink.state;
    if (kink_state_ >= 0) {
      bend_.H += kink.rest.H;
      bend_.g += kink.rest.g;
      bend_.c += kink.rest.c;
      set(kKink, kink.g);
      kink_constant_ = kink.c;
    }
    H_.assign(bend_.H);
    set(kBend, bend_.g);
    next_kink_ = t + 2 < twist_->s.size() ? twist_->kink[t + 1].state : -1;
    if (next_kink_ < 0) return;
    below_.prepare(*twist_, t + 1, step_);
    above_.prepare(*twist_, t + 1, step_);
  }
  S bend(const S* d) const {
    const S* g = constant(kBend);
    S sum(static_cast<Real<S>>(bend_.c));
    for (int i = 0; i < n_; ++i)
      sum = fma(fma(S(Real<S>(-0.5)), H_.add_row(i, d, S(0)), g[i]), d[i], sum);
    return sum;
  }
  void set(Constant which, const Eigen::VectorXd& values) {
    S* to = constants_.data() + which * n_;
    for (int i = 0; i < n_; ++i) to[i] = S(static_cast<Real<S>>(values(i)));
  }
  const S* constant(Constant which) const { return constants_.data() + which * n_; }
  S* row(int i) { return lanes_.data() + i * n_; }

  const Twist* twist_;
  TwistStep step_;
  int n_;
  LaneMatrix<S> A_, G_, J_, H_;
  NormalSampler<S> start_, noise_;
  TwistSide<S> below_, above_;
  Quadratic bend_;  // with the rest of the kink
  std::vector<S> lanes_, constants_;
  double log_start_ = 0, constant_ = 0, kink_constant_ = 0;
  int kink_state_ = -1, next_kink_ = -1;
};

}  // namespace fricid::smc
