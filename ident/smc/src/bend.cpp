#include "fricid/smc/bend.hpp"

#include <cmath>
#include <limits>

#include "fricid/base/eigen_instances.hpp"

namespace fricid::smc {
namespace {

constexpr double kLeastVariance = 5e-5, kLeastGain = 1e-3;         // [nat^2] worth a bend, a kink
constexpr double kOuterWeight = 0.03;                              // of a draw from further out
constexpr double kReach = 4;                                       // of a kink [sd]
constexpr double kMostInflation = 0.8, kMostKinkInflation = 0.95;  // precision given up

/// Functions of one part's states, whitened: 1, w, w w', and |x_k| (1, w).
class Basis {
 public:
  Basis(const BendSample& sample, const Part& part, const Eigen::MatrixXd& P,
        const Eigen::VectorXd& s)
      : part_(&part), m_(std::ssize(part.states)), whiten_(m_, m_) {
    const Eigen::MatrixXd covariance = P(part.states, part.states);
    const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
    factor_ = llt.matrixL();
    whiten_.setIdentity();
    llt.matrixL().solveInPlace(whiten_);
    w_ = sample.d(Eigen::all, part.states) * whiten_.transpose();
    X_.resize(w_.rows(), quadratics() + 1 + m_);
    X_.col(0).setOnes();
    X_.middleCols(1, m_) = w_;
    Eigen::Index column = 1 + m_;
    for (Eigen::Index i = 0; i < m_; ++i)
      for (Eigen::Index j = i; j < m_; ++j) X_.col(column++) = w_.col(i).cwiseProduct(w_.col(j));
    if (part.kink < 0) return;
    const Eigen::VectorXd x = (sample.d.col(part.kink).array() + s(part.kink)).abs();
    X_.col(column++) = x;
    for (Eigen::Index i = 0; i < m_; ++i) X_.col(column++) = x.cwiseProduct(w_.col(i));
  }

  Eigen::Index quadratics() const { return 1 + m_ + m_ * (m_ + 1) / 2; }
  Eigen::Index all() const { return quadratics() + 1 + m_; }

  /// Weighted least squares on the first `columns` functions.
  Eigen::VectorXd fit(Eigen::Index columns, const Eigen::VectorXd& weights,
                      const Eigen::VectorXd& r) const {
    const auto X = X_.leftCols(columns);
    Eigen::MatrixXd normal = X.transpose() * weights.asDiagonal() * X;
    const Eigen::VectorXd scale =
        normal.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
    normal = scale.asDiagonal() * normal * scale.asDiagonal();
    normal.diagonal().array() += 1e-9;
    const Eigen::VectorXd right = X.transpose() * weights.cwiseProduct(r);
    return scale.cwiseProduct(normal.llt().solve(scale.cwiseProduct(right)));
  }
  double error(const Eigen::VectorXd& beta, const Eigen::VectorXd& weights,
               const Eigen::VectorXd& r) const {
    return (r - X_.leftCols(beta.size()) * beta).cwiseAbs2().dot(weights);
  }

  /// H of the quadratic in w.
  Eigen::MatrixXd curvature(const Eigen::VectorXd& beta) const {
    Eigen::MatrixXd H(m_, m_);
    Eigen::Index k = 1 + m_;
    for (Eigen::Index i = 0; i < m_; ++i)
      for (Eigen::Index j = i; j < m_; ++j) {
        const double value = -beta(k++);
        H(i, j) = H(j, i) = i == j ? 2 * value : value;
      }
    return H;
  }
  /// H of |x_k| g' w on the negative side.
  Eigen::MatrixXd kink_curvature(const Eigen::VectorXd& beta) const {
    Eigen::Index row = 0;
    while (part_->states[static_cast<std::size_t>(row)] != part_->kink) ++row;
    const Eigen::VectorXd g = beta.tail(m_), x = factor_.row(row).transpose();
    return x * g.transpose() + g * x.transpose();
  }

  Quadratic quadratic(const Eigen::VectorXd& beta, Eigen::Index n) const {
    Quadratic q = Quadratic::zero(n);
    q.H(part_->states, part_->states) = whiten_.transpose() * curvature(beta) * whiten_;
    q.g(part_->states) = whiten_.transpose() * beta.segment(1, m_);
    q.c = beta(0);
    return q;
  }
  Eigen::VectorXd kink_slope(const Eigen::VectorXd& beta, Eigen::Index n) const {
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    g(part_->states) = whiten_.transpose() * beta.tail(m_);
    return g;
  }

 private:
  const Part* part_;
  Eigen::Index m_;
  Eigen::MatrixXd factor_, whiten_, w_, X_;
};

bool keeps_precision(const Eigen::MatrixXd& H, double most) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly)
             .eigenvalues()(0) > -most;
}

/// The largest of 1, 0.8, 0.64, .. that `allowed` takes.
template <class Allowed>
double shorten(const Allowed& allowed) {
  double share = 1;
  while (share > 0.01 && !allowed(share)) share *= 0.8;
  return share;
}

/// Sum over the core of (r - mean)^2.
double core_squares(const BendSample& sample) {
  const double mean = sample.r.dot(sample.core) / sample.core.sum();
  return (sample.r.array() - mean).square().matrix().dot(sample.core);
}

}  // namespace

void Kink::add_side(int side, const Eigen::VectorXd& s, Eigen::MatrixXd& H, Eigen::VectorXd& slope,
                    double& constant) const {
  // side (s_state + d_state) (c + g' d) + rest
  H += rest.H;
  H.row(state) -= side * g.transpose();
  H.col(state) -= side * g;
  slope += rest.g + side * s(state) * g;
  slope(state) += side * c;
  constant += rest.c + side * s(state) * c;
}

bool worth_bending(const BendSample& sample) {
  return core_squares(sample) > kLeastVariance * sample.core.sum();
}

void fit_bend(const BendSample& sample, std::span<const Part> parts, const Eigen::MatrixXd& P,
              const Eigen::VectorXd& s, bool may_kink, Quadratic& bend, Kink& kink) {
  const Eigen::Index n = P.rows();
  bend = Quadratic::zero(n);
  kink.state = -1;
  const Eigen::VectorXd &r = sample.r, &core = sample.core;
  const double count = core.sum();
  double least = core_squares(sample);

  std::vector<Basis> bases;
  for (const Part& part : parts) bases.emplace_back(sample, part, P, s);
  std::size_t best = parts.size();
  Eigen::VectorXd smooth;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Eigen::VectorXd beta = bases[k].fit(bases[k].quadratics(), core, r);
    const double error = bases[k].error(beta, core, r);
    if (error >= least) continue;
    least = error;
    best = k;
    smooth = beta;
  }
  if (best == parts.size()) return;
  const Basis& basis = bases[best];
  const Eigen::MatrixXd H = basis.curvature(smooth);
  smooth *= shorten([&](double share) { return keeps_precision(share * H, kMostInflation); });
  bend = basis.quadratic(smooth, n);

  const int state = parts[best].kink;
  if (!may_kink || state < 0 || std::abs(s(state)) > kReach * std::sqrt(P(state, state))) return;
  const Eigen::VectorXd weights = kOuterWeight + (1 - kOuterWeight) * core.array();
  Eigen::VectorXd bent = basis.fit(basis.all(), weights, r);
  if (basis.error(smooth, weights, r) - basis.error(bent, weights, r) < kLeastGain * count) return;
  bent.head(smooth.size()) -= smooth;
  const Eigen::MatrixXd H0 = basis.curvature(smooth), dH = basis.curvature(bent),
                        kink_H = basis.kink_curvature(bent);
  bent *= shorten([&](double share) {
    return keeps_precision(H0 + share * (dH - kink_H), kMostKinkInflation) &&
           keeps_precision(H0 + share * (dH + kink_H), kMostKinkInflation);
  });
  kink.state = state;
  kink.g = basis.kink_slope(bent, n);
  kink.c = bent(basis.quadratics());
  kink.rest = basis.quadratic(bent, n);
}

}  // namespace fricid::smc
