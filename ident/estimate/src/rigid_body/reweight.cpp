#include "rigid_body/reweight.hpp"

#include <algorithm>
#include <cmath>

#include "blocks.hpp"
#include "fricid/base/eigen_instances.hpp"
#include "rigid_body/information.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr int kReweightings = 12;
constexpr double kSingular = 1e-13;  // reciprocal condition
constexpr double kHuber = 2.5;       // residuals beyond this many sigma weigh less

}  // namespace

Weighted reweight(const Eigen::MatrixXd& X, const Eigen::VectorXd& tau,
                  const std::vector<int>& group, int groups, bool robust,
                  const Eigen::MatrixXd& prior_information, const Eigen::VectorXd& prior_mean,
                  const Eigen::VectorXd& first_sigma) {
  const Eigen::Index N = X.rows();
  const double floor =
      kSmallestSigma * std::max(1e-300, std::sqrt(tau.squaredNorm() / static_cast<double>(N)));
  Weighted out;
  out.sigma = Eigen::VectorXd::Zero(groups);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(groups);
  for (Eigen::Index r = 0; r < N; ++r) {
    const int j = group[static_cast<std::size_t>(r)];
    count[j] += 1;
    out.sigma[j] += tau[r] * tau[r];
  }
  out.sigma = (out.sigma.array() / count.array().max(1)).sqrt().max(floor);
  if (first_sigma.size() > 0) out.sigma = first_sigma.cwiseMax(floor);

  Eigen::VectorXd robust_weight = Eigen::VectorXd::Ones(N);
  for (int iteration = 0; iteration < kReweightings; ++iteration) {
    Eigen::VectorXd w(N);
    for (Eigen::Index r = 0; r < N; ++r) {
      const double s = out.sigma[group[static_cast<std::size_t>(r)]];
      w[r] = robust_weight[r] / (s * s);
    }
    out.weight = w;
    const Eigen::MatrixXd H_data = X.transpose() * w.asDiagonal() * X;
    out.H = H_data + prior_information;
    const Eigen::VectorXd g = X.transpose() * w.cwiseProduct(tau) + prior_information * prior_mean;
    const Eigen::VectorXd scale = out.H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<Eigen::MatrixXd> factor(
        Eigen::MatrixXd(scale.asDiagonal() * out.H * scale.asDiagonal()));
    out.x = scale.asDiagonal() * factor.solve(Eigen::VectorXd(scale.asDiagonal() * g));

    // Residual spread per joint, corrected for the parameters that the data determine.
    const Eigen::VectorXd e = tau - X * out.x;
    const double determined =
        factor.solve(Eigen::MatrixXd(scale.asDiagonal() * H_data * scale.asDiagonal())).trace();
    const double spent = std::clamp(determined / static_cast<double>(N), 0.0, 0.9);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(groups), share = Eigen::VectorXd::Zero(groups);
    for (Eigen::Index r = 0; r < N; ++r) {
      const int j = group[static_cast<std::size_t>(r)];
      sum[j] += robust_weight[r] * e[r] * e[r];
      share[j] += robust_weight[r];
    }
    out.sigma = (sum.array() / (share.array().max(1e-9) * (1 - spent))).sqrt().max(floor).matrix();
    if (robust)
      for (Eigen::Index r = 0; r < N; ++r) {
        const double size = std::abs(e[r]) / out.sigma[group[static_cast<std::size_t>(r)]];
        robust_weight[r] = size <= kHuber ? 1 : kHuber / size;
      }
  }
  return out;
}

Eigen::MatrixXd jackknife_root(const Eigen::MatrixXd& X, const Eigen::VectorXd& tau,
                               const Weighted& solved, std::span<const int> passage,
                               const Eigen::MatrixXd& prior_information) {
  const std::vector<std::vector<Eigen::Index>> passages = rows_by_passage(passage);
  const Eigen::VectorXd pull = solved.weight.cwiseProduct(tau - X * solved.x);
  const Eigen::VectorXd scale = solved.H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(X.cols(), std::ssize(passages));
  for (Eigen::Index b = 0; b < root.cols(); ++b) {
    const std::vector<Eigen::Index>& rows = passages[static_cast<std::size_t>(b)];
    const Eigen::MatrixXd Xb = X(rows, Eigen::all);
    const Eigen::MatrixXd without =
        solved.H - Xb.transpose() * solved.weight(rows).asDiagonal() * Xb;
    const Eigen::LDLT<Eigen::MatrixXd> factor(
        Eigen::MatrixXd(scale.asDiagonal() * without * scale.asDiagonal()));
    const Eigen::VectorXd score = Xb.transpose() * pull(rows);
    root.col(b) = scale.asDiagonal() * factor.solve(Eigen::VectorXd(scale.asDiagonal() * -score));
    if (factor.rcond() < kSingular || !root.col(b).allFinite())
      root.col(b) = -(invert(without, nullptr) * score);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> prior(prior_information);
  Eigen::MatrixXd out(X.cols(), root.cols() + X.cols());
  out << jackknife(root), invert(solved.H, nullptr) * prior.eigenvectors() *
                              prior.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  return out;
}

Eigen::VectorXd moved_by(const Eigen::VectorXd& error, const Eigen::MatrixXd& X,
                         const Weighted& solved, const Eigen::MatrixXd& inverse) {
  return inverse * (X.transpose() * solved.weight.cwiseProduct(error));
}

}  // namespace fricid::estimate
