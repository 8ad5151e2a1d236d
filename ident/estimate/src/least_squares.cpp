#include "fricid/estimate/least_squares.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"

namespace fricid::estimate {
namespace {

constexpr int kReweightings = 12;
constexpr double kHuber = 2.5;           // residuals beyond this many sigma weigh less
constexpr double kSmallestSigma = 1e-9;  // share of the torque's rms: noise-free data stay solvable
constexpr double kWorstCondition = 1e4;  // above it the base parameters are called ill conditioned

// The stacked linear model  tau = [Y | friction columns] x + e.
struct Regression {
  Eigen::MatrixXd rows;    // (N x (p + 3 n))
  Eigen::VectorXd tau;     // (N)
  std::vector<int> joint;  // (N)
};

int friction_column(int p, int n, int kind, int j) { return p + kind * n + j; }

// Filtered sign of the velocity of joint j: what Coulomb friction of 1 N m looks like after the
// filter.
Eigen::VectorXd filtered_sign(const Filtered& sequence, int j, double cutoff_hz) {
  Eigen::VectorXd s = sequence.v_wide.col(j).array().sign();
  std::vector<double> work;
  ZeroPhaseButterworth(cutoff_hz, 1 / sequence.dt)
      .apply(std::span<double>(s.data(), static_cast<std::size_t>(s.size())), work);
  return s;
}

Regression stack(const dynamics::RobotModel& robot, std::span<const Filtered> sequences,
                 const RigidBodyOptions& options, const FrictionTorques* shape, RigidBodyFit& fit) {
  const int n = robot.n(), p = robot.parameter_count();
  fit.rows.assign(static_cast<std::size_t>(n), 0);
  fit.rows_total = fit.equations = fit.rows;

  const auto used = [&](const Filtered& s, int k, int j) {
    return s.use(k, j) && std::abs(s.v(k, j)) > options.min_speed;
  };
  // Count, then fill.
  Eigen::Index count = 0;
  for (const Filtered& s : sequences) {
    const int every = decimation(s.dt, options.cutoff_hz);
    for (int k = 0; k < s.length(); ++k)
      for (int j = 0; j < n; ++j) {
        ++fit.rows_total[static_cast<std::size_t>(j)];
        if (!used(s, k, j)) continue;
        ++fit.rows[static_cast<std::size_t>(j)];
        if (k % every == 0) ++fit.equations[static_cast<std::size_t>(j)], ++count;
      }
  }

  Regression out;
  out.rows.setZero(count, p + 3 * n);
  out.tau.resize(count);
  out.joint.reserve(static_cast<std::size_t>(count));
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd Y(n, p);
  for (std::size_t i = 0; i < sequences.size(); ++i) {
    const Filtered& s = sequences[i];
    const int every = decimation(s.dt, options.cutoff_hz);
    Eigen::MatrixXd coulomb(s.length(), n);
    for (int j = 0; j < n; ++j) coulomb.col(j) = filtered_sign(s, j, options.cutoff_hz);
    for (int k = 0; k < s.length(); k += every) {
      const auto row = [&](const data::RowMatrix& x) {
        return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(n));
      };
      dynamics::regressor(robot, ws, row(s.q), row(s.v), row(s.a), Y);
      for (int j = 0; j < n; ++j) {
        if (!used(s, k, j)) continue;
        const auto r = static_cast<Eigen::Index>(out.joint.size());
        out.rows.row(r).head(p) = Y.row(j);
        out.tau[r] = s.tau(k, j);
        out.rows(r, friction_column(p, n, 0, j)) = shape ? (*shape)[i](k, j) : coulomb(k, j);
        out.rows(r, friction_column(p, n, 1, j)) = s.v(k, j);
        if (options.offset) out.rows(r, friction_column(p, n, 2, j)) = 1;
        out.joint.push_back(j);
      }
    }
  }
  return out;
}

// Columns of `full` listed in `columns`.
Eigen::MatrixXd pick(const Eigen::MatrixXd& full, const std::vector<int>& columns) {
  Eigen::MatrixXd out(full.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i)
    out.col(static_cast<Eigen::Index>(i)) = full.col(columns[i]);
  return out;
}

struct Weighted {
  Eigen::VectorXd x;       // solution
  Eigen::MatrixXd H;       // information X' W X (+ prior)
  Eigen::VectorXd g;       // X' W y (+ prior)
  Eigen::MatrixXd H_data;  // information of the data alone
  Eigen::VectorXd sigma;   // per joint
};

// Iteratively reweighted least squares with one sigma per joint and optional Huber weights.
Weighted reweight(const Eigen::MatrixXd& X, const Regression& data, int n, bool robust,
                  const Eigen::MatrixXd& prior_information, const Eigen::VectorXd& prior_mean) {
  const Eigen::Index N = X.rows(), p = X.cols();
  const double floor =
      kSmallestSigma * std::max(1e-300, std::sqrt(data.tau.squaredNorm() / static_cast<double>(N)));
  Weighted out;
  out.sigma = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(n);
  for (Eigen::Index r = 0; r < N; ++r) {
    const int j = data.joint[static_cast<std::size_t>(r)];
    count[j] += 1;
    out.sigma[j] += data.tau[r] * data.tau[r];
  }
  out.sigma = (out.sigma.array() / count.array().max(1)).sqrt().max(floor);

  Eigen::VectorXd robust_weight = Eigen::VectorXd::Ones(N);
  for (int iteration = 0; iteration < kReweightings; ++iteration) {
    Eigen::VectorXd w(N);
    for (Eigen::Index r = 0; r < N; ++r) {
      const double s = out.sigma[data.joint[static_cast<std::size_t>(r)]];
      w[r] = robust_weight[r] / (s * s);
    }
    out.H_data = X.transpose() * w.asDiagonal() * X;
    out.H = out.H_data + prior_information;
    out.g = X.transpose() * w.cwiseProduct(data.tau) + prior_information * prior_mean;
    const Eigen::VectorXd scale = out.H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    out.x = scale.asDiagonal() * (scale.asDiagonal() * out.H * scale.asDiagonal())
                                     .eval()
                                     .ldlt()
                                     .solve(Eigen::VectorXd(scale.asDiagonal() * out.g));

    // Residual spread per joint, corrected for the parameters spent.
    const Eigen::VectorXd e = data.tau - X * out.x;
    const double spent = std::min(0.9, static_cast<double>(p) / static_cast<double>(N));
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n), share = Eigen::VectorXd::Zero(n);
    for (Eigen::Index r = 0; r < N; ++r) {
      const int j = data.joint[static_cast<std::size_t>(r)];
      sum[j] += robust_weight[r] * e[r] * e[r];
      share[j] += robust_weight[r];
    }
    out.sigma = (sum.array() / (share.array().max(1e-9) * (1 - spent))).sqrt().max(floor).matrix();
    if (robust)
      for (Eigen::Index r = 0; r < N; ++r) {
        const double size = std::abs(e[r]) / out.sigma[data.joint[static_cast<std::size_t>(r)]];
        robust_weight[r] = size <= kHuber ? 1 : kHuber / size;
      }
  }
  return out;
}

// Covariance and condition number from the information, through a unit diagonal.
Eigen::MatrixXd invert(const Eigen::MatrixXd& H, double* condition) {
  const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * H * scale.asDiagonal()));
  const double largest = eigen.eigenvalues().maxCoeff();
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(1e-16 * largest);
  if (condition) *condition = std::sqrt(largest / values.minCoeff());
  return scale.asDiagonal() * eigen.eigenvectors() * values.cwiseInverse().asDiagonal() *
         eigen.eigenvectors().transpose() * scale.asDiagonal();
}

// W with W' W = inverse of a covariance, through a unit diagonal.
Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * covariance * scale.asDiagonal()));
  const Eigen::VectorXd values =
      eigen.eigenvalues().cwiseMax(1e-16 * eigen.eigenvalues().maxCoeff());
  return values.cwiseSqrt().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose() *
         scale.asDiagonal();
}

// Precision of what is known before the data: CAD values and coefficients of linear torques.
Eigen::MatrixXd prior_precision(const dynamics::RobotModel& robot,
                                const RigidBodyOptions& options) {
  const int p = robot.parameter_count(), body = robot.linear_begin();
  Eigen::MatrixXd P = prior_covariance(robot, options.prior);
  P.diagonal() *= 1 + 1e-9;
  P.diagonal().array() += 1e-18;
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(p, p);
  precision.topLeftCorner(body, body) = invert(P, nullptr);
  for (std::size_t i = 0; i < options.linear_prior_sd.size(); ++i)
    if (const double sd = options.linear_prior_sd[i]; std::isfinite(sd)) {
      const int k = body + static_cast<int>(i);
      precision(k, k) = 1 / (sd * sd);
    }
  return precision;
}

// Square root of a precision so wide that it only decides what the data leave open.
Eigen::MatrixXd weak_pull(const dynamics::RobotModel& robot) {
  data::PriorConfig wide;
  wide.mass = 1, wide.com_m = 0.2, wide.inertia = 1, wide.armature = 10;
  const int body = robot.linear_begin();
  Eigen::MatrixXd P = prior_covariance(robot, wide);
  P.diagonal().array() += 1e-9 * P.diagonal().array() + 1e-12;
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(robot.parameter_count(), robot.parameter_count());
  root.topLeftCorner(body, body) = inverse_root(P);
  return root;
}

}  // namespace

Eigen::MatrixXd prior_covariance(const dynamics::RobotModel& robot,
                                 const data::PriorConfig& prior) {
  const int n = robot.n(), p = robot.linear_begin();
  // Entry e of (Ixx, Ixy, Iyy, Ixz, Iyz, Izz) is at row[e], column[e].
  const std::array<int, 6> row{0, 0, 1, 0, 1, 2}, column{0, 1, 1, 2, 2, 2}, diagonal{0, 2, 5};
  // Entry e of the symmetric bilinear form of x'x 1 - x x'.
  const auto steiner = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& y, std::size_t e) {
    const double trace = row[e] == column[e] ? x.dot(y) : 0;
    return trace - 0.5 * (x[row[e]] * y[column[e]] + y[row[e]] * x[column[e]]);
  };
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(p, p);
  for (int i = 0; i < n; ++i) {
    // pi of the link from (m, c, Ic): mc = m c, I = Ic + m (c'c 1 - c c').
    const Eigen::VectorXd pi = robot.pi.segment<10>(10 * i);
    const double m = pi[0];
    const Eigen::Vector3d c = pi.segment<3>(1) / m;
    Eigen::MatrixXd J = Eigen::MatrixXd::Identity(10, 10);
    J.block<3, 1>(1, 0) = c;
    J.block<3, 3>(1, 1) = m * Eigen::Matrix3d::Identity();
    std::array<double, 6> central{};
    for (std::size_t e = 0; e < 6; ++e) {
      const auto at = static_cast<Eigen::Index>(4 + e);
      J(at, 0) = steiner(c, c, e);
      for (int k = 0; k < 3; ++k) J(at, 1 + k) = 2 * m * steiner(c, Eigen::Vector3d::Unit(k), e);
      central[e] = pi[at] - m * steiner(c, c, e);
    }
    Eigen::VectorXd sd(10);
    sd[0] = prior.mass * m;
    sd.segment<3>(1).setConstant(prior.com_m);
    for (std::size_t e = 0; e < 6; ++e) {
      const double first =
          central[static_cast<std::size_t>(diagonal[static_cast<std::size_t>(row[e])])];
      const double second =
          central[static_cast<std::size_t>(diagonal[static_cast<std::size_t>(column[e])])];
      sd[static_cast<Eigen::Index>(4 + e)] =
          prior.inertia * std::sqrt(std::max(0.0, first) * std::max(0.0, second));
    }
    P.block<10, 10>(10 * i, 10 * i) = J * sd.cwiseAbs2().asDiagonal() * J.transpose();
    const int k = robot.armature_begin() + i;
    P(k, k) = std::pow(prior.armature * robot.pi[k], 2);
  }
  return P;
}

data::RowMatrix rigid_body_torque(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                                  const Filtered& sequence) {
  const auto n = static_cast<std::size_t>(robot.n());
  dynamics::Workspace<double> ws(robot);
  data::RowMatrix tau(sequence.length(), sequence.n());
  for (int k = 0; k < sequence.length(); ++k) {
    const auto row = [&](const data::RowMatrix& x) {
      return std::span<const double>(x.row(k).data(), n);
    };
    dynamics::rnea<double>(robot, ws, {pi.data(), static_cast<std::size_t>(pi.size())},
                           row(sequence.q), row(sequence.v), row(sequence.a),
                           {tau.row(k).data(), n});
  }
  return tau;
}

RigidBodyFit rigid_body_least_squares(const dynamics::RobotModel& robot,
                                      std::span<const Filtered> sequences,
                                      const RigidBodyOptions& options,
                                      const FrictionTorques* shape) {
  const auto begin = std::chrono::steady_clock::now();
  const int n = robot.n(), p = robot.parameter_count();
  RigidBodyFit fit;
  const dynamics::BaseParameters base = dynamics::base_parameters(robot);
  const auto b = static_cast<Eigen::Index>(base.columns.size());
  const Regression data = stack(robot, sequences, options, shape, fit);

  // Friction columns that any row excites.
  std::vector<int> friction;
  for (int k = p; k < p + 3 * n; ++k)
    if (data.rows.col(k).squaredNorm() > 0) friction.push_back(k);
  const auto f = static_cast<Eigen::Index>(friction.size());

  // Unknowns: base parameters, or all standard parameters under a prior; then friction.
  std::vector<int> columns;
  if (options.prior.use)
    for (int k = 0; k < p; ++k) columns.push_back(k);
  else
    columns = base.columns;
  const auto head = static_cast<Eigen::Index>(columns.size());
  columns.insert(columns.end(), friction.begin(), friction.end());
  if (data.rows.rows() <= b + f) {
    fit.message = fmt::format("{} rows above {} rad/s for {} unknowns", data.rows.rows(),
                              options.min_speed, b + f);
    fit.pi = robot.pi;
    return fit;
  }

  Eigen::MatrixXd prior_information = Eigen::MatrixXd::Zero(head + f, head + f);
  Eigen::VectorXd prior_mean = Eigen::VectorXd::Zero(head + f);
  if (options.prior.use) {
    prior_information.topLeftCorner(p, p) = prior_precision(robot, options);
    prior_mean.head(p) = robot.pi;
  }

  const Weighted solved =
      reweight(pick(data.rows, columns), data, n, options.robust, prior_information, prior_mean);
  const Eigen::MatrixXd covariance = invert(solved.H, &fit.condition);
  fit.sigma = solved.sigma;

  // Base parameters and their uncertainty.
  const Eigen::MatrixXd to_base =
      options.prior.use ? base.K : Eigen::MatrixXd(Eigen::MatrixXd::Identity(b, b));
  fit.base_names = base.names;
  fit.base = to_base * solved.x.head(head);
  fit.base_se = (to_base * covariance.topLeftCorner(head, head) * to_base.transpose())
                    .diagonal()
                    .cwiseMax(0)
                    .cwiseSqrt();

  // Linear friction.
  for (auto* vector : {&fit.Fc, &fit.Fv, &fit.offset, &fit.Fc_se, &fit.Fv_se, &fit.offset_se})
    vector->setZero(n);
  for (Eigen::Index i = 0; i < f; ++i) {
    const int kind = (friction[static_cast<std::size_t>(i)] - p) / n;
    const int j = (friction[static_cast<std::size_t>(i)] - p) % n;
    auto& value = kind == 0 ? fit.Fc : kind == 1 ? fit.Fv : fit.offset;
    auto& se = kind == 0 ? fit.Fc_se : kind == 1 ? fit.Fv_se : fit.offset_se;
    value[j] = solved.x[head + i];
    se[j] = std::sqrt(std::max(0.0, covariance(head + i, head + i)));
  }

  // The physical parameters nearest to the estimate, friction marginalised.
  const Eigen::MatrixXd root = inverse_root(covariance.topLeftCorner(head, head));
  Eigen::MatrixXd G = root;
  Eigen::VectorXd d = root * solved.x.head(head);
  if (!options.prior.use) {
    const Eigen::MatrixXd pull = weak_pull(robot);
    G.resize(head + p, p);
    G << root * base.K, pull;
    d.resize(head + p);
    d << root * solved.x.head(head), pull * robot.pi;
  }
  fit.pi = fit_physical_inertia(robot, G, d, robot.pi);
  fit.base_physical = base.K * fit.pi;

  const bool finite = fit.pi.allFinite() && fit.base.allFinite();
  fit.outcome = !finite                           ? Outcome::kFailed
                : fit.condition > kWorstCondition ? Outcome::kIllConditioned
                                                  : Outcome::kConverged;
  fit.message =
      !finite ? "no finite solution"
              : fmt::format("condition {:.3g}, {} equations", fit.condition, data.rows.rows());
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return fit;
}

}  // namespace fricid::estimate
