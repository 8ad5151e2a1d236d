#include "fricid/dynamics/base_parameters.hpp"

#include <fmt/format.h>

#include <cmath>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/dynamics/algorithms.hpp"

namespace fricid::dynamics {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kIndependent = 1e-8;  // relative residual: rounding leaves 1e-14, geometry > 1e-4
constexpr double kZero = 1e-10;        // entries of K below are rounding
constexpr std::uint64_t kMotionSeed = 1991;

/// Regressors at random states, stacked; each row block is one state.
MatrixXd random_regressors(const RobotModel& model) {
  const int n = model.n(), p = model.parameter_count();
  const int states = 20 + 4 * p / n;
  Workspace<double> ws(model);
  Rng rng(kMotionSeed, 0);
  MatrixXd Y_all(states * n, p);
  std::vector<double> q(static_cast<size_t>(n)), v(q), a(q);
  for (int k = 0; k < states; ++k) {
    for (size_t i = 0; i < q.size(); ++i) {
      const Joint& joint = model.joints[i];
      const auto [lower, upper] = travel_of(joint);
      q[i] = lower + (upper - lower) * rng.uniform();
      v[i] = 2 * rng.normal();
      a[i] = 5 * rng.normal();
    }
    regressor(model, ws, q, v, a, Y_all.middleRows(k * n, n));
  }
  return Y_all;
}

/// "m2 cx + 0.315 m3": the row of K with the parameters' names.
std::string grouping(const Eigen::Ref<const VectorXd>& coefficients, int own,
                     const std::vector<std::string>& names) {
  std::string text = names[static_cast<size_t>(own)];
  for (int k = 0; k < coefficients.size(); ++k) {
    const double c = coefficients(k);
    if (k == own || c == 0) continue;
    text += c > 0 ? " + " : " - ";
    const std::string magnitude = fmt::format("{:.4g}", std::abs(c));
    if (magnitude != "1") text += magnitude + " ";
    text += names[static_cast<size_t>(k)];
  }
  return text;
}

}  // namespace

BaseParameters base_parameters(const RobotModel& model) {
  BaseParameters base;
  const int p = model.parameter_count();
  MatrixXd W = random_regressors(model);
  VectorXd scale = W.colwise().norm();
  const double largest = scale.maxCoeff();
  for (int k = 0; k < p; ++k) {
    if (scale(k) > kIndependent * largest) continue;
    base.unidentifiable.push_back(k);
    W.col(k).setZero();
    scale(k) = 1;
  }
  W *= scale.cwiseInverse().asDiagonal();

  // rank and the gap that decides it
  const Eigen::ColPivHouseholderQR<MatrixXd> pivoted(W);
  const VectorXd pivots = pivoted.matrixR().diagonal().cwiseAbs();
  const auto b = (pivots.array() > kIndependent * pivots(0)).count();
  base.gap = b < p ? pivots(b - 1) / std::max(pivots(b), 1e-300) : pivots(b - 1) / 1e-300;

  // in the order of pi, so that outer links are grouped onto inner ones: keep independent columns
  MatrixXd basis(W.rows(), b);
  for (int k = 0; k < p && std::ssize(base.columns) < b; ++k) {
    VectorXd residual = W.col(k);
    const auto known = basis.leftCols(std::ssize(base.columns));
    for (int pass = 0; pass < 2; ++pass) residual -= known * (known.transpose() * residual);
    const double norm = residual.norm();
    if (norm < kIndependent) continue;
    basis.col(std::ssize(base.columns)) = residual / norm;
    base.columns.push_back(k);
  }

  // the other columns in terms of the kept ones
  const MatrixXd W_b = W(Eigen::all, base.columns);
  base.K = W_b.householderQr().solve(W);
  for (int i = 0; i < base.K.rows(); ++i) {
    for (int k = 0; k < p; ++k) {
      double& c = base.K(i, k);
      c *= scale(k) / scale(base.columns[static_cast<size_t>(i)]);
      if (std::abs(c) < kZero) c = 0;
    }
  }
  for (size_t i = 0; i < base.columns.size(); ++i) {
    base.K.col(base.columns[i]).setZero();
    base.K(static_cast<int>(i), base.columns[i]) = 1;
  }

  const std::vector<std::string> names = model.parameter_names();
  for (size_t i = 0; i < base.columns.size(); ++i)
    base.names.push_back(
        grouping(base.K.row(static_cast<int>(i)).transpose(), base.columns[i], names));
  return base;
}

}  // namespace fricid::dynamics
