#include "fricid/estimate/em/innovations.hpp"

#include <cmath>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/smc/kalman.hpp"

namespace fricid::estimate {

InnovationScore innovation_score(LatentFrictionModel& model, const smc::RowMatrix& y) {
  const int nx = model.state_size(), np = model.parameter_count();
  InnovationScore out{0, Eigen::VectorXd::Zero(np), Eigen::MatrixXd::Zero(np, np), false};
  smc::UpdateWorkspace ws(nx, model.observation_size());
  smc::Gaussian x = model.initial();
  Eigen::VectorXd f(nx);
  Eigen::MatrixXd A(nx, nx), B(nx, np), P(nx, nx), E, moved(nx, np);
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(nx, np);
  for (Eigen::Index t = 0; t < y.rows(); ++t) {
    const auto row = std::span(y.data() + t * y.cols(), static_cast<std::size_t>(y.cols()));
    const smc::Innovation seen = smc::kalman_update(row, model.C(), model.R(), x, ws);
    out.log_likelihood += seen.log_likelihood;
    if (seen.present > 0) {
      E.noalias() = ws.C.topRows(seen.present) * D;
      ws.S.topLeftCorner(seen.present, seen.present).triangularView<Eigen::Lower>().solveInPlace(E);
      out.score.noalias() += E.transpose() * ws.whitened.head(seen.present);
      out.information.selfadjointView<Eigen::Lower>().rankUpdate(E.transpose());
      moved.noalias() = ws.I_KC * D;
      D.swap(moved);
    }
    if (t + 1 == y.rows()) break;
    model.linearise(static_cast<int>(t), x.mean, f, A, B);
    x.mean = f;
    smc::kalman_predict(A, x.covariance, model.Q(), P);
    x.covariance.swap(P);
    B.noalias() += A * D;
    D.swap(B);
  }
  out.failed = !std::isfinite(out.log_likelihood) || !out.score.allFinite();
  return out;
}

Eigen::VectorXd innovation_likelihood(LatentFrictionModel& model, const smc::RowMatrix& y) {
  const int nx = model.state_size();
  smc::UpdateWorkspace ws(nx, model.observation_size());
  smc::Gaussian x = model.initial();
  Eigen::VectorXd f(nx);
  Eigen::MatrixXd A(nx, nx), P(nx, nx);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(model.observation_size());
  for (Eigen::Index t = 0; t < y.rows(); ++t) {
    const auto row = std::span(y.data() + t * y.cols(), static_cast<std::size_t>(y.cols()));
    smc::kalman_update(row, model.C(), model.R(), x, ws);
    Eigen::Index k = 0;
    for (Eigen::Index i = 0; i < sum.size(); ++i)
      if (!std::isnan(y(t, i))) sum[i] += ws.log_likelihood(k++);
    if (t + 1 == y.rows()) break;
    model.linearise(static_cast<int>(t), x.mean, f, A);
    x.mean = f;
    smc::kalman_predict(A, x.covariance, model.Q(), P);
    x.covariance.swap(P);
  }
  return sum;
}

}  // namespace fricid::estimate
