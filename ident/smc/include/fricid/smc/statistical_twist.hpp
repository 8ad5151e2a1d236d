// The functions psi of the twisted filter by statistical linearisation.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/smc/bend.hpp"
#include "fricid/smc/twisted_guide.hpp"

namespace fricid::smc {

/// Draws around s_t, which come in pairs +d, -d, and their images under f_t.
class PairedDraws {
 public:
  /// @param pairs  a multiple of PackD::kLanes
  /// @param outer  share of the pairs drawn from further out, N(0, 4 P)
  PairedDraws(int n, int pairs, double outer);

  /// False, and nothing drawn, where the covariance is not positive definite.
  template <StateSpaceModel M>
  [[nodiscard]] bool draw(M& model, int t, const Gaussian& x);

  /// By least squares over the draws of N(0, P):
  ///     A = argmin sum |f(s + d) - mean f - A d|^2,     c = mean (f(s + d) - A d) - s_{t+1}.
  void linearise(const Eigen::VectorXd& s_next, Eigen::MatrixXd& A, Eigen::VectorXd& c);

  int blocks() const { return static_cast<int>(x_.size()) / n_; }
  const PackD* x(int block) const { return x_.data() + block * n_; }
  const PackD* image(int block) const { return image_.data() + block * n_; }
  const Eigen::MatrixXd& d() const { return d_; }        ///< (2 pairs x n), +d first
  const Eigen::VectorXd& core() const { return core_; }  ///< (2 pairs) 1 for a draw of N(0, P)

 private:
  bool place(int t, const Gaussian& x);

  int n_, pairs_, core_pairs_;
  std::vector<double> normals_;
  Eigen::MatrixXd white_, d_, f_;
  Eigen::VectorXd core_;
  Eigen::LLT<Eigen::MatrixXd> root_;
  std::vector<PackD> x_, image_;
};

template <StateSpaceModel M>
bool PairedDraws::draw(M& model, int t, const Gaussian& x) {
  if (!place(t, x)) return false;
  image_ = x_;
  const auto size = static_cast<std::size_t>(n_);
  for (std::size_t b = 0; b < image_.size() / size; ++b)
    model.transition(t, std::span<PackD>(image_).subspan(b * size, size));
  return true;
}

/// psi along the means s_t of `smoothed` (T), with the slope and offset that f_t has on average
/// over N(s_t, P_t), P_t its covariances, instead of its Jacobian at s_t; on top of that, for the
/// parts given, the quadratic and the kink that explain best what the linearisation leaves of the
/// weights (bend.hpp). Exact for a linear model. False, and psi unfinished, where a covariance is
/// not positive definite.
/// @see Garcia-Fernandez, Svensson & Sarkka, IEEE TSP 63, 2015; Guarniero, Johansen & Lee 2017
template <StateSpaceModel M>
[[nodiscard]] bool make_statistical_twist(M& model, const RowMatrix& y,
                                          std::span<const Gaussian> smoothed, Twist& twist,
                                          std::span<const Part> parts = {}, bool kinks = true) {
  constexpr int kFewestPairs = 32, kBendPairs = 256;
  constexpr double kOuterShare = 0.25;
  const int n = model.state_size();
  const bool bends = !parts.empty();
  PairedDraws few(n, padded(std::max(kFewestPairs, 2 * n)), 0);
  PairedDraws many(n, bends ? kBendPairs : PackD::kLanes, kOuterShare);
  const std::size_t T = smoothed.size();
  twist.s.resize(T);
  twist.c.resize(T - 1);
  twist.A.resize(T - 1);
  twist.bend.assign(bends ? T - 1 : 0, Quadratic::zero(n));
  twist.kink.assign(bends ? T - 1 : 0, {});
  for (std::size_t t = 0; t < T; ++t) twist.s[t] = smoothed[t].mean;
  TwistRecursion recursion(model.Q(), model.C(), model.R(), y, Foresight::kWhole, twist);
  TwistedGuide<PackD> guide(model, twist);
  BendSample sample;
  const auto linearise = [&](PairedDraws& draws, std::size_t t) {
    const int step = static_cast<int>(t);
    if (!draws.draw(model, step, smoothed[t])) return false;
    draws.linearise(twist.s[t + 1], twist.A[t], twist.c[t]);
    if (!bends) return true;
    guide.prepare(step);
    sample.d = draws.d();
    sample.core = draws.core();
    sample.r.resize(sample.d.rows());
    for (int b = 0; b < draws.blocks(); ++b)
      store(guide.log_weight(draws.x(b), draws.image(b), false).total,
            sample.r.data() + b * PackD::kLanes);
    return true;
  };
  for (std::size_t t = T - 1; t-- > 0;) {
    if (!linearise(few, t)) return false;
    if (bends && worth_bending(sample)) {
      if (!linearise(many, t)) return false;
      fit_bend(sample, parts, smoothed[t].covariance, twist.s[t], kinks && t > 0, twist.bend[t],
               twist.kink[t]);
    }
    recursion.add(static_cast<int>(t));
  }
  return true;
}

/// The best psi: around the smoothed moments, then without kinks around its own, then with them.
/// @param smoothed  of the Gaussian smoother (T); on return those of the second round
/// @return as make_statistical_twist
template <StateSpaceModel M>
[[nodiscard]] bool make_bent_twist(M& model, const RowMatrix& y, std::span<const Part> parts,
                                   std::span<Gaussian> smoothed, Twist& twist) {
  if (!make_statistical_twist(model, y, smoothed, twist, parts, false)) return false;
  twisted_moments(model.initial(), model.Q(), twist, smoothed);
  return make_statistical_twist(model, y, smoothed, twist, parts);
}

}  // namespace fricid::smc
