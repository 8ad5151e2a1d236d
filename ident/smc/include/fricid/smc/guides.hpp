// How a particle filter proposes and weighs: the part in which the bootstrap, the fully adapted and
// the twisted filter differ. A guide knows the observations; the filter does not.
//
// All of them run the filter of a model twisted by positive functions psi_t (Guarniero, Johansen &
// Lee 2017):  x_{t+1} is proposed from  N(x'; f_t(x_t), Q) psi_{t+1}(x') / g_{t+1}(f_t(x_t))  with
//     g_{t+1}(F) = int N(x'; F, Q) psi_{t+1}(x') dx'                       the look-ahead
// and x_t gets the weight  p(y_t | x_t) g_{t+1}(f_t(x_t)) / psi_t(x_t).  Then
//     bootstrap        psi_t = 1
//     fully adapted    psi_t(x) = p(y_t | x)
//     twisted          psi_t(x) = p(y_t, .., y_{T-1} | x) of a linearised model (twist.hpp)
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <concepts>
#include <span>
#include <vector>

#include "fricid/smc/kalman.hpp"
#include "fricid/smc/lanes.hpp"
#include "fricid/smc/model.hpp"

namespace fricid::smc {

/// Log weight of the particles x_t of a block.
template <class S>
struct LogWeight {
  S total;  ///< what x_t gains at step t
  S past;   ///< the same without log g_{t+1}(f_t(x_t)), up to a constant; if asked for
};

/// Calls in the order of the filter: start for each block, then per step prepare(t), weight and
/// move for each block. None allocates. F is null at the last step.
///
///     steps()            number of observations T
///     log_start()        log of int N(x; m0, P0) psi_0(x) dx
///     start(e, x)        x_0 from standard normal e                       [lanes: n, n]
///     prepare(t)         computes what log_weight and move need at step t
///     log_weight(x, F, wants_past)    of x_t with image F = f_t(x_t)      [n, n]
///     move(F, e, x)      x_{t+1} from the image F and standard normal e   [n, n, n]
///
/// and the type `Lanes` that the guide works in: PackD, PackF or double.
template <class G, class S = typename G::Lanes>
concept Guide = requires(G guide, int t, const S* e, const S* F, S* x) {
  { guide.steps() } -> std::same_as<int>;
  { guide.log_start() } -> std::same_as<double>;
  guide.start(e, x);
  guide.prepare(t);
  { guide.log_weight(F, F, true) } -> std::same_as<LogWeight<S>>;
  guide.move(F, e, x);
};

/// x = mean + L e for lanes e.
template <class S>
class NormalSampler {
 public:
  NormalSampler() = default;
  NormalSampler(const Eigen::VectorXd& mean, const Eigen::MatrixXd& L) : L_(L.rows(), L.cols()) {
    assign(mean, L);
  }
  void assign(const Eigen::VectorXd& mean, const Eigen::MatrixXd& L) {
    L_.assign(L);
    mean_.assign(mean.data(), mean.data() + mean.size());
  }
  void draw(const S* e, S* x) const {
    for (int i = 0; i < L_.rows(); ++i) {
      x[i] = L_.add_row(i, e, S(static_cast<Real<S>>(mean_[static_cast<std::size_t>(i)])));
    }
  }

 private:
  LaneMatrix<S> L_;
  std::vector<double> mean_;
};

/// log N(y; C x, V) over the channels of y that are not NaN.
template <class S>
class ObservationDensity {
 public:
  /// @param C  (ny x n), @param V  positive definite (ny x ny)
  ObservationDensity(const Eigen::MatrixXd& C, const Eigen::MatrixXd& V)
      : V_(V),
        part_(V),
        minus_C_(C.rows(), C.cols()),
        whiten_(V.rows(), V.cols()),
        llt_(Eigen::MatrixXd::Identity(V.rows(), V.rows())),
        y_(static_cast<std::size_t>(C.rows())),
        residual_(y_.size(), S(0)) {
    minus_C_.assign(-C);
    channel_.reserve(y_.size());
    known_.assign(y_.size(), -1);
  }

  /// Takes an observation; true when its pattern of missing channels is not that of the last one.
  bool assign(std::span<const double> y) {
    bool changed = false;
    for (std::size_t i = 0; i < y.size(); ++i) {
      const int present = std::isnan(y[i]) ? 0 : 1;
      changed |= known_[i] != present;
      known_[i] = present;
    }
    if (changed) factorise();
    for (std::size_t k = 0; k < channel_.size(); ++k) {
      y_[k] = y[static_cast<std::size_t>(channel_[k])];
    }
    return changed;
  }

  int present() const { return static_cast<int>(channel_.size()); }
  double largest_log_density() const { return constant_; }  ///< of all x

  /// y - C x over the present channels, valid until the next call.
  const S* residual(const S* x) {
    for (std::size_t k = 0; k < channel_.size(); ++k) {
      residual_[k] = minus_C_.add_row(channel_[k], x, S(static_cast<Real<S>>(y_[k])));
    }
    return residual_.data();
  }

  S log_density(const S* x) {
    const S* r = residual(x);
    S sum(0);
    for (int k = 0; k < present(); ++k) {
      const S w = whiten_.add_row(k, r, S(0));
      sum = fma(w, w, sum);
    }
    return fma(S(Real<S>(-0.5)), sum, S(static_cast<Real<S>>(constant_)));
  }

 private:
  void factorise() {
    channel_.clear();
    for (std::size_t i = 0; i < known_.size(); ++i) {
      if (known_[i] == 1) channel_.push_back(static_cast<int>(i));
    }
    // Cholesky factor of the present rows and columns, padded by an identity
    const auto m = static_cast<Eigen::Index>(channel_.size());
    part_.setIdentity(V_.rows(), V_.cols());
    for (Eigen::Index i = 0; i < m; ++i) {
      for (Eigen::Index j = 0; j < m; ++j) {
        part_(i, j) =
            V_(channel_[static_cast<std::size_t>(i)], channel_[static_cast<std::size_t>(j)]);
      }
    }
    llt_.compute(part_);
    part_.setIdentity();
    llt_.matrixL().solveInPlace(part_);
    whiten_.assign(part_.topLeftCorner(m, m));
    constant_ = -0.9189385332046727 * static_cast<double>(m);  // log sqrt(2 pi)
    for (Eigen::Index i = 0; i < m; ++i) constant_ += std::log(part_(i, i));
  }

  Eigen::MatrixXd V_, part_;
  LaneMatrix<S> minus_C_, whiten_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  std::vector<int> known_, channel_;
  std::vector<double> y_;
  std::vector<S> residual_;
  double constant_ = 0;
};

/// One row of the observations.
inline std::span<const double> row_of(const RowMatrix& y, int t) {
  return {y.data() + t * y.cols(), static_cast<std::size_t>(y.cols())};
}

/// log p(y_t | x) = log N(y_t; C x, R), what the bootstrap filter takes when given no other
/// density.
template <class S>
class GaussianObservation {
 public:
  template <StateSpaceModel M>
  GaussianObservation(const M& model, const RowMatrix& y)
      : y_(&y), density_(model.C(), model.R()) {}

  int steps() const { return static_cast<int>(y_->rows()); }
  void prepare(int t) { density_.assign(row_of(*y_, t)); }
  S operator()(const S* x) { return density_.log_density(x); }

 private:
  const RowMatrix* y_;
  ObservationDensity<S> density_;
};

/// Bootstrap filter (Gordon, Salmond & Smith 1993): proposes from the transition density and weighs
/// by any density of the observation.
/// @tparam Density  steps(); prepare(t); log density of y_t at the lanes x: S operator()(const S*
/// x)
template <class S, class Density = GaussianObservation<S>>
class BootstrapGuide {
 public:
  using Lanes = S;

  template <StateSpaceModel M>
  BootstrapGuide(const M& model, Density density)
      : density_(std::move(density)),
        start_(model.initial().mean, square_root(model.initial().covariance)),
        noise_(square_root(model.Q())) {}
  template <StateSpaceModel M>
  BootstrapGuide(const M& model,
                 const RowMatrix& y) requires std::same_as<Density, GaussianObservation<S>>
      : BootstrapGuide(model, Density(model, y)) {}

  int steps() const { return density_.steps(); }
  double log_start() const { return 0; }
  void start(const S* e, S* x) const { start_.draw(e, x); }
  void prepare(int t) { density_.prepare(t); }
  LogWeight<S> log_weight(const S* x, const S*, bool) {
    const S lw = density_(x);
    return {lw, lw};
  }
  void move(const S* F, const S* e, S* x) const {
    for (int i = 0; i < noise_.rows(); ++i) x[i] = noise_.add_row(i, e, F[i]);
  }

 private:
  Density density_;
  NormalSampler<S> start_;
  LaneMatrix<S> noise_;
};

/// Fully adapted filter (Pitt & Shephard 1999), possible because y is linear in x:
///     S = C Q C' + R,  K = Q C' S^-1,  V = (I - K C) Q
///     g_{t+1}(F) = N(y_{t+1}; C F, S),   x_{t+1} ~ N(F + K (y_{t+1} - C F), V)
/// The weights of x_t then are those given y_0 .. y_{t+1}.
template <class S>
class AdaptedGuide {
 public:
  using Lanes = S;

  /// Keeps a reference to y.
  template <StateSpaceModel M>
  AdaptedGuide(const M& model, const RowMatrix& y)
      : AdaptedGuide(model, y, static_cast<int>(y.rows())) {}
  /// For observations that come one by one: y is a ring whose row t % y.rows() holds y_t when
  /// prepare(t - 1) is called, and y_0 now.
  template <StateSpaceModel M>
  AdaptedGuide(const M& model, const RowMatrix& y, int steps)
      : y_(&y),
        C_(model.C()),
        Q_(model.Q()),
        R_(model.R()),
        density_(C_, Eigen::MatrixXd(C_ * Q_ * C_.transpose() + R_)),
        ws_(model.state_size(), model.observation_size()),
        posterior_{Eigen::VectorXd::Zero(Q_.rows()), Q_},
        llt_(Q_),
        gain_(Q_.rows(), C_.rows()),
        noise_(Q_.rows(), Q_.rows()),
        steps_(steps) {
    Gaussian x = model.initial();
    log_start_ = kalman_update(row_of(y, 0), C_, R_, x, ws_).log_likelihood;
    start_ = NormalSampler<S>(x.mean, square_root(x.covariance));
  }

  int steps() const { return steps_; }
  double log_start() const { return log_start_; }
  /// Of the observation last prepared for: its channels that are there, and the log weight of a
  /// particle that foretells it exactly.
  int present() const { return density_.present(); }
  double largest_log_weight() const { return density_.largest_log_density(); }
  void start(const S* e, S* x) const { start_.draw(e, x); }

  void prepare(int t) {
    if (t + 1 == steps()) return;
    const auto y = row_of(*y_, (t + 1) % static_cast<int>(y_->rows()));
    if (!density_.assign(y)) return;
    posterior_.mean.setZero(Q_.rows());
    posterior_.covariance = Q_;
    kalman_update(y, C_, R_, posterior_, ws_);
    llt_.compute(posterior_.covariance);
    posterior_.covariance = llt_.matrixL();
    noise_.assign(posterior_.covariance);
    gain_.assign(ws_.K.leftCols(density_.present()));
  }

  LogWeight<S> log_weight(const S*, const S* F, bool) {
    return {F ? density_.log_density(F) : S(0), S(0)};
  }
  void move(const S* F, const S* e, S* x) {
    const S* r = density_.residual(F);
    for (int i = 0; i < gain_.rows(); ++i) x[i] = noise_.add_row(i, e, gain_.add_row(i, r, F[i]));
  }

 private:
  const RowMatrix* y_;
  Eigen::MatrixXd C_, Q_, R_;
  ObservationDensity<S> density_;
  UpdateWorkspace ws_;
  Gaussian posterior_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  LaneMatrix<S> gain_, noise_;
  NormalSampler<S> start_;
  double log_start_;
  int steps_;
};

}  // namespace fricid::smc
