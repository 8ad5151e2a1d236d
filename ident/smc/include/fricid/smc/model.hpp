// Concept of a state-space model for the filters and smoothers.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cassert>
#include <concepts>
#include <span>
#include <type_traits>

#include "fricid/base/pack.hpp"

namespace fricid::smc {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A normal distribution N(mean, covariance).
struct Gaussian {
  Eigen::VectorXd mean;        ///< (n)
  Eigen::MatrixXd covariance;  ///< (n x n), symmetric, positive semidefinite
};

/// A state-space model with additive Gaussian noise and a linear observation:
///
///     x_0 ~ N(m0, P0)
///     x_{t+1} = f_t(x_t) + w_t,   w_t ~ N(0, Q)      transition t leads from t to t + 1
///     y_t = C x_t + e_t,          e_t ~ N(0, R)
///
/// Observations are a matrix y (T x ny), one row per step, NaN where a channel is missing.
/// Q and R are positive definite. One object per thread: it owns its workspace.
///
///     transition(t, x)         x <- f_t(x), one particle per lane, for S = double, PackD and
///                              PackF; does not allocate
///     linearise(t, x, f, A)    f = f_t(x) (n) and A = df_t/dx (n x n)
template <class M>
concept StateSpaceModel = requires(M model, const M& constant, int t, std::span<double> x,
                                   std::span<PackD> xd, std::span<PackF> xf,
                                   const Eigen::VectorXd& mean, Eigen::VectorXd& f,
                                   Eigen::MatrixXd& A) {
  { constant.state_size() } -> std::same_as<int>;
  { constant.observation_size() } -> std::same_as<int>;
  { constant.initial() } -> std::same_as<const Gaussian&>;
  { constant.Q() } -> std::same_as<const Eigen::MatrixXd&>;
  { constant.C() } -> std::same_as<const Eigen::MatrixXd&>;
  { constant.R() } -> std::same_as<const Eigen::MatrixXd&>;
  model.transition(t, x);
  model.transition(t, xd);
  model.transition(t, xf);
  model.linearise(t, mean, f, A);
};

/// The linear model  f_t(x) = A x + b: the one whose answers are known in closed form.
class LinearModel {
 public:
  Eigen::MatrixXd A;        ///< (n x n)
  Eigen::VectorXd b;        ///< (n)
  Gaussian start;           ///< of x_0
  Eigen::MatrixXd noise;    ///< Q (n x n)
  Eigen::MatrixXd observe;  ///< C (ny x n)
  Eigen::MatrixXd error;    ///< R (ny x ny)

  int state_size() const { return static_cast<int>(A.rows()); }
  int observation_size() const { return static_cast<int>(observe.rows()); }
  const Gaussian& initial() const { return start; }
  const Eigen::MatrixXd& Q() const { return noise; }
  const Eigen::MatrixXd& C() const { return observe; }
  const Eigen::MatrixXd& R() const { return error; }

  template <class S>
  void transition(int, std::span<S> x) {
    std::array<S, kMostStates> y;
    const auto n = A.rows();
    assert(n <= kMostStates);
    for (Eigen::Index i = 0; i < n; ++i) {
      S sum(b(i));
      for (Eigen::Index j = 0; j < n; ++j) {
        sum = fma(S(A(i, j)), x[static_cast<std::size_t>(j)], sum);
      }
      y[static_cast<std::size_t>(i)] = sum;
    }
    std::copy_n(y.begin(), n, x.begin());
  }

  void linearise(int, const Eigen::VectorXd& x, Eigen::VectorXd& f, Eigen::MatrixXd& jacobian) {
    f.noalias() = A * x;
    f += b;
    jacobian = A;
  }

  static constexpr int kMostStates = 64;
};
static_assert(StateSpaceModel<LinearModel>);

}  // namespace fricid::smc
