#include "linear_gaussian.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fricid/smc/kalman.hpp"

namespace fricid::smc::test {

Eigen::MatrixXd random_matrix(Rng& rng, int rows, int columns) {
  Eigen::MatrixXd X(rows, columns);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) X(i, j) = rng.normal();
  }
  return X;
}

Eigen::MatrixXd random_covariance(Rng& rng, int n, double scale) {
  const Eigen::MatrixXd X = random_matrix(rng, n, n);
  return scale * (X * X.transpose() / n + 0.2 * Eigen::MatrixXd::Identity(n, n));
}

LinearModel random_model(int n, std::uint64_t seed) {
  Rng rng(seed, 0);
  LinearModel model;
  const int ny = std::max(1, n / 3);
  model.A = random_matrix(rng, n, n);
  model.A *= 0.95 / model.A.norm();  // the Frobenius norm bounds every eigenvalue
  model.b = random_matrix(rng, n, 1);
  model.start = {random_matrix(rng, n, 1), random_covariance(rng, n, 1.0)};
  model.noise = random_covariance(rng, n, 0.1);
  model.observe = random_matrix(rng, ny, n);
  model.error = random_covariance(rng, ny, 0.2);
  return model;
}

LinearModel tracking_model() {
  LinearModel model;
  model.A = Eigen::MatrixXd{{1, 0.1}, {-0.2, 0.9}};
  model.b = Eigen::VectorXd{{0.05, 0.1}};
  model.start = {Eigen::VectorXd{{0.3, -0.2}}, Eigen::MatrixXd{{0.5, 0.1}, {0.1, 0.4}}};
  model.noise = Eigen::MatrixXd{{0.02, 0.005}, {0.005, 0.05}};
  model.observe = Eigen::MatrixXd{{1, 0}};
  model.error = Eigen::MatrixXd{{0.15}};
  return model;
}

Simulated simulate(const LinearModel& model, int T, std::uint64_t seed) {
  const int n = model.state_size(), ny = model.observation_size();
  Rng rng(seed, 1);
  const auto draw = [&](const Eigen::MatrixXd& P) {
    return Eigen::VectorXd(square_root(P) * random_matrix(rng, static_cast<int>(P.rows()), 1));
  };
  Simulated s{RowMatrix(T, n), RowMatrix(T, ny)};
  Eigen::VectorXd x = model.start.mean + draw(model.start.covariance);
  for (int t = 0; t < T; ++t) {
    if (t > 0) x = (model.A * x + model.b + draw(model.noise)).eval();
    s.x.row(t) = x;
    s.y.row(t) = model.observe * x + draw(model.error);
  }
  return s;
}

void punch_holes(RowMatrix& y) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index t = 0; t < y.rows(); t += 4) {
    for (Eigen::Index i = 0; i < y.cols(); i += 3) y(t, i) = nan;
  }
  y.row(y.rows() / 2).setConstant(nan);
}

DenseSolution dense_solution(const LinearModel& model, const RowMatrix& y) {
  const Eigen::Index T = y.rows(), n = model.A.rows();
  // prior by its precision: D'W D with x_0 and x_{t+1} - A x_t as rows of D x
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(T * n, T * n);
  Eigen::VectorXd information = Eigen::VectorXd::Zero(T * n);
  const Eigen::MatrixXd P0 = model.start.covariance.inverse(), W = model.noise.inverse();
  precision.topLeftCorner(n, n) += P0;
  information.head(n) += P0 * model.start.mean;
  double log_det_prior = std::log(model.start.covariance.determinant());
  double constant = model.start.mean.dot(P0 * model.start.mean);
  for (Eigen::Index t = 0; t + 1 < T; ++t) {
    const Eigen::Index a = t * n, b = a + n;
    precision.block(a, a, n, n) += model.A.transpose() * W * model.A;
    precision.block(b, b, n, n) += W;
    precision.block(a, b, n, n) -= model.A.transpose() * W;
    precision.block(b, a, n, n) -= W * model.A;
    information.segment(b, n) += W * model.b;
    information.segment(a, n) -= model.A.transpose() * W * model.b;
    log_det_prior += std::log(model.noise.determinant());
    constant += model.b.dot(W * model.b);
  }
  // observations, channel by channel that is present
  double log_det_error = 0, count = 0;
  for (Eigen::Index t = 0; t < T; ++t) {
    std::vector<int> present;
    for (int i = 0; i < y.cols(); ++i) {
      if (!std::isnan(y(t, i))) present.push_back(i);
    }
    if (present.empty()) continue;
    const Eigen::MatrixXd C = model.observe(present, Eigen::all);
    const Eigen::MatrixXd R = model.error(present, present);
    const Eigen::VectorXd r = y(t, present).transpose();
    const Eigen::MatrixXd CtRi = C.transpose() * R.inverse();
    precision.block(t * n, t * n, n, n) += CtRi * C;
    information.segment(t * n, n) += CtRi * r;
    log_det_error += std::log(R.determinant());
    constant += r.dot(R.inverse() * r);
    count += static_cast<double>(present.size());
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(precision);
  DenseSolution solution;
  solution.mean = llt.solve(information);
  solution.covariance = llt.solve(Eigen::MatrixXd::Identity(T * n, T * n));
  const double log_det_posterior =
      -2 * Eigen::MatrixXd(llt.matrixL()).diagonal().array().log().sum();
  solution.log_likelihood = -0.5 * (count * std::log(2 * M_PI) + log_det_prior + log_det_error -
                                    log_det_posterior + constant - information.dot(solution.mean));
  return solution;
}

}  // namespace fricid::smc::test
