// Gaussian filtering and smoothing: exact for linear models, by linearisation (EKF) for others.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "fricid/smc/model.hpp"

namespace fricid::smc {

/// Results of the Gaussian filter and smoother for x_0 .. x_{T-1}; made once, filled many times.
///
///     predicted  N(m_t, P_t)  of x_t given y_0 .. y_{t-1}
///     filtered                of x_t given y_0 .. y_t
///     smoothed                of x_t given y_0 .. y_{T-1}
struct GaussianPath {
  std::vector<Gaussian> predicted, filtered, smoothed;  ///< (T)
  std::vector<Eigen::MatrixXd> A;        ///< (T - 1) df_t/dx where f_t was linearised
  std::vector<Eigen::MatrixXd> gain;     ///< (T - 1) of the smoother
  std::vector<Eigen::MatrixXd> lag_one;  ///< (T - 1) Cov(x_{t+1}, x_t | all y)

  double log_likelihood = 0;  ///< log p(y_0 .. y_{T-1}) of the linearised model [nat]
  std::vector<double> nis;    ///< (T) normalised innovation squared, chi^2 with present[t] degrees
  std::vector<int> present;   ///< (T) channels observed at t
  bool failed = true;         ///< something became infinite; the rest is then meaningless

  void resize(int steps, int state_size);
  int steps() const { return static_cast<int>(predicted.size()); }
};

/// Scratch of one measurement update; made from the sizes, does not allocate after. Afterwards the
/// first `present` rows of C, and of the Cholesky factor of S in the lower triangle of S, are those
/// of the present channels, `whitened` is L^-1 (y - C m) and I_KC is I - K C.
struct UpdateWorkspace {
  UpdateWorkspace(int state_size, int observation_size);
  Eigen::MatrixXd C, R, S, K, PCt, I_KC, product;
  Eigen::VectorXd innovation, whitened;

  /// log p of the k-th present channel given those before it [nat].
  double log_likelihood(Eigen::Index k) const;
};

/// Outcome of one measurement update.
struct Innovation {
  double log_likelihood = 0;  ///< log N(y; C m, S) over the present channels, 0 without any
  double nis = 0;             ///< (y - C m)' S^-1 (y - C m)
  int present = 0;            ///< channels that were not NaN
};

/// Turns the predicted x into the filtered one by the present channels of y, in Joseph's form
///     S = C P C' + R,  K = P C' S^-1,  P <- (I - K C) P (I - K C)' + K R K'.
Innovation kalman_update(std::span<const double> y, const Eigen::MatrixXd& C,
                         const Eigen::MatrixXd& R, Gaussian& x, UpdateWorkspace& ws);

/// Covariance step  P_{t+1} = A P A' + Q.
void kalman_predict(const Eigen::MatrixXd& A, const Eigen::MatrixXd& P, const Eigen::MatrixXd& Q,
                    Eigen::MatrixXd& next);

/// Rauch, Tung & Striebel (1965) on a filtered path, the covariance as a sum of positive terms:
///     G = P_t A' P_{t+1|t}^-1,   m_t^s = m_t + G (m_{t+1}^s - m_{t+1|t})
///     P_t^s = (I - G A) P_t (I - G A)' + G (Q + P_{t+1}^s) G',   lag-one = P_{t+1}^s G'
void rts_smoother(const Eigen::MatrixXd& Q, GaussianPath& path);

/// L (n x n) with P = L L' of a positive semidefinite P: the Cholesky factor where there is one.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& P);

/// Draws whole paths x_0 .. x_{T-1} (T x n each) from the smoothed distribution.
/// @param path   smoothed
/// @param paths  matrices to fill; path k uses the random stream (seed, sequence, k)
void sample_gaussian_paths(const Eigen::MatrixXd& Q, const GaussianPath& path, std::uint64_t seed,
                           std::uint32_t sequence, std::span<RowMatrix> paths);

/// Kalman filter on f_t linearised at the filtered mean (EKF); exact when the model is linear.
/// @param around  when given (T means), linearise there instead: one Gauss-Newton step towards the
///                most probable path when these are smoothed means (iterated smoother, Bell 1994)
template <StateSpaceModel M>
void gaussian_filter(M& model, const RowMatrix& y, GaussianPath& path,
                     std::span<const Gaussian> around = {}) {
  const int steps = static_cast<int>(y.rows()), n = model.state_size();
  path.resize(steps, n);
  UpdateWorkspace ws(n, model.observation_size());
  Eigen::VectorXd f(n);
  path.log_likelihood = 0;
  path.predicted[0] = model.initial();
  for (int t = 0; t < steps; ++t) {
    const auto k = static_cast<std::size_t>(t);
    Gaussian& x = path.filtered[k];
    x = path.predicted[k];
    const auto row = std::span(y.data() + t * y.cols(), static_cast<std::size_t>(y.cols()));
    const Innovation innovation = kalman_update(row, model.C(), model.R(), x, ws);
    path.log_likelihood += innovation.log_likelihood;
    path.nis[k] = innovation.nis;
    path.present[k] = innovation.present;
    if (t + 1 == steps) break;

    const Eigen::VectorXd& at = around.empty() ? x.mean : around[k].mean;
    model.linearise(t, at, f, path.A[k]);
    path.predicted[k + 1].mean = f;
    if (!around.empty()) path.predicted[k + 1].mean.noalias() += path.A[k] * (x.mean - at);
    kalman_predict(path.A[k], x.covariance, model.Q(), path.predicted[k + 1].covariance);
  }
  path.failed = !std::isfinite(path.log_likelihood);
}

/// Filter and RTS smoother; `iterations` times more around the smoothed means of the round before.
template <StateSpaceModel M>
void gaussian_smoother(M& model, const RowMatrix& y, GaussianPath& path, int iterations = 0) {
  gaussian_filter(model, y, path);
  if (!path.failed) rts_smoother(model.Q(), path);
  std::vector<Gaussian> around;
  for (int i = 0; i < iterations && !path.failed; ++i) {
    around = path.smoothed;
    gaussian_filter(model, y, path, around);
    if (!path.failed) rts_smoother(model.Q(), path);
  }
}

}  // namespace fricid::smc
