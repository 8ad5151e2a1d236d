#include "friction/friction_search.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "blocks.hpp"
#include "fricid/base/eigen_instances.hpp"
#include "fricid/friction/tangent.hpp"
#include "fricid/optimise/damped_step.hpp"
#include "fricid/optimise/nelder_mead.hpp"
#include "rigid_body/information.hpp"

namespace fricid::estimate {
namespace {

constexpr double kFirstStep = 0.4;    // of the simplex, in scaled coordinates
constexpr double kDifference = 1e-5;  // of the Jacobian, in scaled coordinates
constexpr double kLargestStep = 1.5;  // of one iteration in any scaled coordinate
constexpr double kSmallestGain =
    1e-7;                         // relative decrease of the objective that counts as converged
constexpr int kEvaluations = 16;  // of Nelder-Mead, at most, per free parameter
constexpr int kUnlimited = std::numeric_limits<int>::max();

Eigen::VectorXd copied(const std::vector<double>& x) {
  return Eigen::VectorXd::Map(x.data(), std::ssize(x));
}

double safe_mean_square(const JointFrictionData& data, const friction::RobotFriction& friction,
                        std::span<const double> theta) {
  const double value = data.mean_square(friction, theta);
  return std::isfinite(value) ? value : kBadValue;
}

// Residuals and their derivatives at the used rows.
struct UsedRows {
  std::vector<std::vector<int>> row;
  Eigen::VectorXd e;
  Eigen::MatrixXd J;
};

// By sensitivities that are carried forward with the state.
// @pre friction::Tangent::is_known(friction)
UsedRows rows_by_tangent(const JointFrictionData& data, const friction::RobotFriction& friction,
                         const SearchCoordinates& coordinates, std::span<const double> x,
                         std::span<const std::size_t> wanted) {
  std::vector<double> theta(x.size());
  coordinates.to_theta(x, theta);
  UsedRows out{data.used_rows(), {}, {}};
  JointFrictionData::Linear at = data.linearise(friction, theta, wanted, out.row);
  out.e = std::move(at.f);
  out.J = std::move(at.J);
  for (std::size_t i = 0; i < wanted.size(); ++i)
    out.J.col(static_cast<Eigen::Index>(i)) *= coordinates.slope(wanted[i], theta[wanted[i]]);
  Eigen::Index r = 0;
  for (int s = 0; s < data.sequences(); ++s)
    for (const int k : out.row[static_cast<std::size_t>(s)]) out.e[r++] -= data.target(s, k);
  return out;
}

// By differences: lane 0 of every pass holds x itself, the others one shifted coordinate each.
UsedRows rows_by_differences(const JointFrictionData& data, const friction::RobotFriction& friction,
                             const SearchCoordinates& coordinates, std::span<const double> x,
                             std::span<const std::size_t> wanted) {
  const auto p = static_cast<Eigen::Index>(wanted.size());
  constexpr Eigen::Index kColumns = PackD::kLanes - 1;
  const Eigen::Index passes = std::max<Eigen::Index>(1, (p + kColumns - 1) / kColumns);
  std::vector<double> step(wanted.size()), shifted(x.begin(), x.end()), theta(x.size());
  std::vector<std::vector<PackD>> lanes(static_cast<std::size_t>(passes),
                                        std::vector<PackD>(x.size()));
  for (Eigen::Index pass = 0; pass < passes; ++pass)
    for (int lane = 0; lane < PackD::kLanes; ++lane) {
      const auto column = static_cast<std::size_t>(pass * kColumns + lane - 1);
      const bool moves = lane > 0 && column < wanted.size();
      const std::size_t i = moves ? wanted[column] : 0;
      if (moves) {
        step[column] = x[i] + kDifference < coordinates.upper()[i] ? kDifference : -kDifference;
        shifted[i] += step[column];
      }
      coordinates.to_theta(shifted, theta);
      for (std::size_t k = 0; k < x.size(); ++k)
        lanes[static_cast<std::size_t>(pass)][k].set(lane, theta[k]);
      if (moves) shifted[i] = x[i];
    }

  UsedRows out{data.used_rows(), Eigen::VectorXd(data.rows()), Eigen::MatrixXd(data.rows(), p)};
  std::vector<std::vector<PackD>> e(static_cast<std::size_t>(passes));
  std::vector<PackD> work;
  Eigen::Index r = 0;
  for (int s = 0; s < data.sequences(); ++s) {
    for (std::size_t pass = 0; pass < e.size(); ++pass)
      data.residual(friction, lanes[pass], s, e[pass], work);
    for (const int sample : out.row[static_cast<std::size_t>(s)]) {
      const auto k = static_cast<std::size_t>(sample);
      out.e[r] = e[0][k][0];
      for (Eigen::Index i = 0; i < p; ++i) {
        const auto pass = static_cast<std::size_t>(i / kColumns);
        const int lane = static_cast<int>(i % kColumns) + 1;
        out.J(r, i) = (e[pass][k][lane] - out.e[r]) / step[static_cast<std::size_t>(i)];
      }
      ++r;
    }
  }
  return out;
}

// The columns of J are the coordinates `wanted`.
UsedRows used_rows(const JointFrictionData& data, const friction::RobotFriction& friction,
                   const SearchCoordinates& coordinates, std::span<const double> x,
                   std::span<const std::size_t> wanted) {
  return friction::Tangent::is_known(friction)
             ? rows_by_tangent(data, friction, coordinates, x, wanted)
             : rows_by_differences(data, friction, coordinates, x, wanted);
}

// J'J and J'e of the residuals beside the best constant at x, over the number of rows, of the free
// coordinates.
optimise::Quadratic linearise(const JointFrictionData& data,
                              const friction::RobotFriction& friction,
                              const SearchCoordinates& coordinates, std::span<const double> x,
                              double value) {
  const auto p = static_cast<Eigen::Index>(coordinates.free().size());
  const UsedRows rows = used_rows(data, friction, coordinates, x, coordinates.free());
  optimise::Quadratic out{value, rows.J.transpose() * rows.e, Eigen::MatrixXd::Zero(p, p)};
  out.H.selfadjointView<Eigen::Lower>().rankUpdate(rows.J.transpose());
  Eigen::VectorXd columns = rows.J.colwise().sum();
  const double sum = rows.e.sum();
  out.H.triangularView<Eigen::StrictlyUpper>() = out.H.transpose();
  out.H /= data.rows();
  out.g /= data.rows();
  columns /= data.rows();
  out.H -= data.share_of_mean() * columns * columns.transpose();
  out.g -= data.share_of_mean() * sum / data.rows() * columns;
  out.H *= 2;  // of the squares, not of half of them
  out.g *= 2;
  return out;
}

constexpr double kUnknown = 1e-9;  // share of the diagonal of what the data leave open

// H^+ B H^+ over the directions that H knows, in units in which its diagonal is one. A parameter
// that has part in an unknown direction (only ratios of GMS's alpha count) has no variance of its
// own: NaN.
Eigen::MatrixXd sandwich(const Eigen::MatrixXd& H, const Eigen::MatrixXd& B) {
  constexpr double kPart = 1e-3;  // squared share in a unit direction
  const Eigen::Index p = H.rows();
  if (p == 0) return H;
  ScaledEigen directions = scaled_eigen(H, H.diagonal());
  directions.scale = (H.diagonal().array() > 0).select(directions.scale, 0).eval();
  Eigen::VectorXd inverse = directions.values, unknown = Eigen::VectorXd::Zero(p);
  for (Eigen::Index d = 0; d < p; ++d) {
    const bool known = inverse[d] > kUnknown;
    if (!known) unknown += directions.V.col(d).cwiseAbs2();
    inverse[d] = known ? 1 / inverse[d] : 0;
  }
  const Eigen::MatrixXd of_H = directions.with_values(inverse);
  Eigen::MatrixXd covariance = of_H * B * of_H;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index i = 0; i < p; ++i)
    if (unknown[i] > kPart) {
      covariance.row(i).setConstant(kNone);
      covariance.col(i).setConstant(kNone);
    }
  return covariance;
}

}  // namespace

SearchCoordinates::SearchCoordinates(const friction::RobotFriction& friction,
                                     std::span<const double> reference,
                                     std::span<const std::size_t> held) {
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const friction::ParameterInfo& info = friction.parameters()[i].info;
    log_.push_back(info.scale == friction::Scale::kLog);
    unit_.push_back(std::max(std::abs(reference[i]), 0.1 * std::abs(info.typical)));
    if (unit_.back() == 0) unit_.back() = info.upper - info.lower;
    held_.push_back(std::ranges::count(held, i) > 0);
    if (!held_.back()) free_.push_back(i);
    lower_.push_back(to_scaled(i, held_[i] ? reference[i] : info.lower));
    upper_.push_back(to_scaled(i, held_[i] ? reference[i] : info.upper));
  }
}

double SearchCoordinates::to_scaled(std::size_t i, double theta) const {
  return log_[i] ? std::log(std::max(theta, std::numeric_limits<double>::min())) : theta / unit_[i];
}

std::vector<double> SearchCoordinates::to_scaled(std::span<const double> theta) const {
  std::vector<double> x(theta.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = std::clamp(to_scaled(i, theta[i]), lower_[i], upper_[i]);
  return x;
}

void SearchCoordinates::to_theta(std::span<const double> x, std::span<double> theta) const {
  for (std::size_t i = 0; i < x.size(); ++i) theta[i] = log_[i] ? std::exp(x[i]) : x[i] * unit_[i];
}

double SearchCoordinates::slope(std::size_t i, double theta) const {
  return log_[i] ? theta : unit_[i];
}

SearchErrors search_errors(const JointFrictionData& data, const friction::RobotFriction& friction,
                           const SearchCoordinates& coordinates, std::span<const double> x,
                           std::span<const std::size_t> free, const Eigen::VectorXd& motion_error) {
  const auto p = static_cast<Eigen::Index>(free.size());
  const UsedRows rows = used_rows(data, friction, coordinates, x, free);
  const Eigen::MatrixXd& J = rows.J;
  Eigen::MatrixXd H = J.transpose() * J;
  Eigen::VectorXd mean = J.colwise().sum() / data.rows(), of_motion = Eigen::VectorXd::Zero(p);
  double mean_residual = rows.e.sum() / data.rows(), mean_of_motion = 0;
  if (motion_error.size() > 0) {
    of_motion = J.transpose() * motion_error;
    mean_of_motion = motion_error.sum() / data.rows();
  }
  of_motion -= data.rows() * data.share_of_mean() * mean_of_motion * mean;
  // the constant beside the law is whatever fits best: rows count as what they are beside it
  H -= data.rows() * data.share_of_mean() * mean * mean.transpose();
  mean *= data.share_of_mean();
  mean_residual *= data.share_of_mean();
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(p, p);
  if (const OffsetPrior& prior = data.offset_prior(); prior.weight > 0) {
    const Eigen::VectorXd score = data.rows() * prior.weight * prior.sd * mean;
    B += score * score.transpose();
  }
  // (H - H_b)^-1 s_b = H^-1 (I - H_b H^-1)^-1 s_b
  Eigen::MatrixXd known = H;
  known.diagonal() *= 1 + kUnknown;
  known.diagonal().array() += std::numeric_limits<double>::min();
  const Eigen::LDLT<Eigen::MatrixXd> inverse = known.ldlt();
  std::vector<int> passage;
  for (std::size_t i = 0; i < rows.row.size(); ++i)
    for (const int k : rows.row[i]) passage.push_back(data.blocks().passage_of(i, k));
  const std::vector<std::vector<Eigen::Index>> passages = rows_by_passage(passage);
  Eigen::MatrixXd scores(p, std::ssize(passages));
  for (std::size_t b = 0; b < passages.size(); ++b) {
    const Eigen::MatrixXd Jb = J(passages[b], Eigen::all);
    const Eigen::VectorXd eb = rows.e(passages[b]);
    Eigen::VectorXd score = Jb.transpose() * eb - mean_residual * Jb.colwise().sum().transpose() -
                            (eb.sum() - static_cast<double>(eb.size()) * mean_residual) * mean;
    const Eigen::MatrixXd others =
        Eigen::MatrixXd::Identity(p, p) - inverse.solve(Jb.transpose() * Jb).transpose();
    const Eigen::VectorXd left_out = others.partialPivLu().solve(score);
    if (left_out.allFinite()) score = left_out;
    scores.col(static_cast<Eigen::Index>(b)) = score;
  }
  const Eigen::MatrixXd root = jackknife(std::move(scores));
  B += root * root.transpose();
  const Eigen::MatrixXd of_motion_alone = sandwich(H, of_motion * of_motion.transpose());
  return {sandwich(H, B + of_motion * of_motion.transpose()),
          of_motion_alone.diagonal().cwiseSqrt()};
}

SearchMinimum search(const JointFrictionData& data, const friction::RobotFriction& friction,
                     const SearchCoordinates& coordinates, const std::vector<double>& x,
                     const FrictionFitOptions& options) {
  std::vector<double> theta(x.size());
  const int evaluations =
      std::min(options.evaluations, kEvaluations * static_cast<int>(coordinates.free().size()));
  const optimise::Minimum found = optimise::nelder_mead(
      [&](const Eigen::VectorXd& c) {
        coordinates.to_theta({c.data(), theta.size()}, theta);
        return safe_mean_square(data, friction, theta);
      },
      {copied(coordinates.lower()), copied(coordinates.upper())}, copied(x),
      {kFirstStep, options.tolerance, evaluations});
  SearchMinimum at{{found.c.begin(), found.c.end()},
                   std::min(found.value, kBadValue),
                   found.converged,
                   found.values};
  refine(data, friction, coordinates, at, options.iterations);
  return at;
}

void refine(const JointFrictionData& data, const friction::RobotFriction& friction,
            const SearchCoordinates& coordinates, SearchMinimum& at, int iterations) {
  at.converged = false;
  if (at.value >= kBadValue) return;
  const std::vector<std::size_t>& free = coordinates.free();
  const auto p = static_cast<Eigen::Index>(free.size());
  const auto of_free = [&](const std::vector<double>& all) {
    Eigen::VectorXd out(p);
    for (Eigen::Index i = 0; i < p; ++i) out[i] = all[free[static_cast<std::size_t>(i)]];
    return out;
  };
  std::vector<double> x = at.x, theta(x.size());
  const auto set_free = [&](const Eigen::VectorXd& c) {
    for (Eigen::Index i = 0; i < p; ++i) x[free[static_cast<std::size_t>(i)]] = c[i];
  };
  int linearised = 0;
  const int passes = (static_cast<int>(p) + PackD::kLanes - 2) / (PackD::kLanes - 1);
  const int of_one = friction::Tangent::is_known(friction) ? 1 : passes * data.sequences();
  const optimise::Minimum found = optimise::damped_least_squares(
      [&](const Eigen::VectorXd& c, double value) {
        set_free(c);
        linearised += of_one;
        return linearise(data, friction, coordinates, x, value);
      },
      [&](const Eigen::VectorXd& c) {
        set_free(c);
        coordinates.to_theta(x, theta);
        return safe_mean_square(data, friction, theta);
      },
      {of_free(coordinates.lower()), of_free(coordinates.upper())}, {of_free(at.x), at.value},
      {.damping = {.longest = kLargestStep,
                   .attempts = kUnlimited,
                   .lessen = 10,
                   .least = 1e-12,
                   .most = 1e8,
                   .hold_at_bounds = true},
       .iterations = iterations,
       .smallest_gain = kSmallestGain});
  set_free(found.c);
  at = {x, found.value, found.converged, at.evaluations + linearised + found.values};
}

}  // namespace fricid::estimate
