#include "fricid/smc/kalman.hpp"

#include <cmath>
#include <numbers>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/smc/streams.hpp"

namespace fricid::smc {
namespace {

constexpr double kLogTwoPi = 1.8378770664093453;

void symmetrise(Eigen::MatrixXd& P) {
  for (Eigen::Index j = 0; j < P.cols(); ++j) {
    for (Eigen::Index i = 0; i < j; ++i) P(i, j) = P(j, i) = 0.5 * (P(i, j) + P(j, i));
  }
}

/// (I - G A) P (I - G A)' + G Q G': what stays unknown of x_t once x_{t+1} is known.
Eigen::MatrixXd conditional_covariance(const Eigen::MatrixXd& gain, const Eigen::MatrixXd& A,
                                       const Eigen::MatrixXd& P, const Eigen::MatrixXd& Q) {
  const Eigen::MatrixXd I_GA = Eigen::MatrixXd::Identity(P.rows(), P.cols()) - gain * A;
  Eigen::MatrixXd covariance = I_GA * P * I_GA.transpose() + gain * Q * gain.transpose();
  symmetrise(covariance);
  return covariance;
}

}  // namespace

Eigen::MatrixXd square_root(const Eigen::MatrixXd& P) {
  const Eigen::LLT<Eigen::MatrixXd> llt(P);
  if (llt.info() == Eigen::Success) return llt.matrixL();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(P);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

void GaussianPath::resize(int steps, int state_size) {
  const auto size = static_cast<std::size_t>(steps);
  const Gaussian empty{Eigen::VectorXd::Zero(state_size),
                       Eigen::MatrixXd::Zero(state_size, state_size)};
  for (auto* list : {&predicted, &filtered, &smoothed}) list->resize(size, empty);
  for (auto* list : {&A, &gain, &lag_one}) list->resize(size - 1, empty.covariance);
  nis.resize(size);
  present.resize(size);
}

UpdateWorkspace::UpdateWorkspace(int n, int ny)
    : C(ny, n),
      R(ny, ny),
      S(ny, ny),
      K(n, ny),
      PCt(n, ny),
      I_KC(n, n),
      product(n, n),
      innovation(ny),
      whitened(ny) {}

double UpdateWorkspace::log_likelihood(Eigen::Index k) const {
  return -0.5 * (whitened[k] * whitened[k] + kLogTwoPi) - std::log(S(k, k));
}

Innovation kalman_update(std::span<const double> y, const Eigen::MatrixXd& C,
                         const Eigen::MatrixXd& R, Gaussian& x, UpdateWorkspace& ws) {
  // rows of the present channels
  Eigen::Index m = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (std::isnan(y[i])) continue;
    const auto row = static_cast<Eigen::Index>(i);
    ws.C.row(m) = C.row(row);
    ws.innovation(m) = y[i] - C.row(row).dot(x.mean);
    Eigen::Index k = 0;
    for (std::size_t j = 0; j < y.size(); ++j) {
      if (!std::isnan(y[j])) ws.R(m, k++) = R(row, static_cast<Eigen::Index>(j));
    }
    ++m;
  }
  if (m == 0) return {};

  const auto present_C = ws.C.topRows(m);
  auto PCt = ws.PCt.leftCols(m);
  auto S = ws.S.topLeftCorner(m, m);
  PCt.noalias() = x.covariance * present_C.transpose();
  S = ws.R.topLeftCorner(m, m);
  S.noalias() += present_C * PCt;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(S);
  const auto L = llt.matrixL();

  auto K = ws.K.leftCols(m);
  K = PCt;
  L.transpose().solveInPlace<Eigen::OnTheRight>(K);
  auto whitened = ws.whitened.head(m);
  whitened = ws.innovation.head(m);
  L.solveInPlace(whitened);
  x.mean.noalias() += K * whitened;
  L.solveInPlace<Eigen::OnTheRight>(K);

  ws.I_KC.setIdentity();
  ws.I_KC.noalias() -= K * present_C;
  ws.product.noalias() = ws.I_KC * x.covariance;
  x.covariance.noalias() = ws.product * ws.I_KC.transpose();
  PCt.noalias() = K * ws.R.topLeftCorner(m, m);
  x.covariance.noalias() += PCt * K.transpose();
  symmetrise(x.covariance);

  const double nis = whitened.squaredNorm();
  const double log_det = 2 * S.diagonal().array().log().sum();
  const auto count = static_cast<int>(m);
  return {-0.5 * (nis + log_det + count * kLogTwoPi), nis, count};
}

void kalman_predict(const Eigen::MatrixXd& A, const Eigen::MatrixXd& P, const Eigen::MatrixXd& Q,
                    Eigen::MatrixXd& next) {
  next = Q;
  next.noalias() += A * P * A.transpose();
  symmetrise(next);
}

void rts_smoother(const Eigen::MatrixXd& Q, GaussianPath& path) {
  const auto last = path.filtered.size() - 1;
  path.smoothed[last] = path.filtered[last];
  for (std::size_t t = last; t-- > 0;) {
    const Gaussian& filtered = path.filtered[t];
    const Gaussian& predicted = path.predicted[t + 1];
    const Gaussian& next = path.smoothed[t + 1];
    Eigen::MatrixXd& gain = path.gain[t];

    gain = predicted.covariance.llt().solve(path.A[t] * filtered.covariance).transpose();
    path.smoothed[t].mean = filtered.mean + gain * (next.mean - predicted.mean);
    path.lag_one[t].noalias() = next.covariance * gain.transpose();
    Eigen::MatrixXd& P = path.smoothed[t].covariance;
    P = conditional_covariance(gain, path.A[t], filtered.covariance, Q);
    P.noalias() += gain * path.lag_one[t];
    symmetrise(P);
  }
}

void sample_gaussian_paths(const Eigen::MatrixXd& Q, const GaussianPath& path, std::uint64_t seed,
                           std::uint32_t sequence, std::span<RowMatrix> paths) {
  const int steps = path.steps();
  const auto n = Q.rows();
  const auto draws = static_cast<std::uint64_t>(n * steps);
  for (RowMatrix& x : paths) x.resize(steps, n);
  Eigen::VectorXd noise(n);
  for (int t = steps - 1; t >= 0; --t) {
    const auto k = static_cast<std::size_t>(t);
    const Gaussian& filtered = path.filtered[k];
    const bool is_last = t == steps - 1;
    const Eigen::MatrixXd L = square_root(
        is_last ? filtered.covariance
                : conditional_covariance(path.gain[k], path.A[k], filtered.covariance, Q));
    for (std::size_t i = 0; i < paths.size(); ++i) {
      fill_normal(seed, stream_of(Purpose::kGaussianPath, sequence, static_cast<std::uint32_t>(i)),
                  draws - static_cast<std::uint64_t>(n * (t + 1)),
                  std::span(noise.data(), static_cast<std::size_t>(n)));
      paths[i].row(t) = filtered.mean + L * noise;
      if (is_last) continue;
      const Eigen::VectorXd surprise = paths[i].row(t + 1).transpose() - path.predicted[k + 1].mean;
      paths[i].row(t) += path.gain[k] * surprise;
    }
  }
}

}  // namespace fricid::smc
