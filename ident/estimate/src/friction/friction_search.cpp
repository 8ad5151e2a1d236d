#include "friction/friction_search.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/friction/tangent.hpp"
#include "fricid/optimise/damped_step.hpp"
#include "fricid/optimise/nelder_mead.hpp"

namespace fricid::estimate {
namespace {

constexpr double kFirstStep = 0.4;    // of the simplex, in scaled coordinates
constexpr double kDifference = 1e-5;  // of the Jacobian, in scaled coordinates
constexpr double kBlock = 1;          // [s] beyond which residuals count as independent
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

// Of friction whose sensitivities are known.
UsedRows known_rows(const JointFrictionData& data, const friction::RobotFriction& friction,
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

// for_each_row of friction whose sensitivities are known.
template <class F>
void for_each_known_row(const JointFrictionData& data, const friction::RobotFriction& friction,
                        const SearchCoordinates& coordinates, std::span<const double> x,
                        std::span<const std::size_t> wanted, F&& f) {
  const UsedRows rows = known_rows(data, friction, coordinates, x, wanted);
  Eigen::VectorXd columns(std::ssize(wanted));
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(columns.size());
  Eigen::Index r = 0;
  for (int s = 0; s < data.sequences(); ++s) {
    const std::vector<int>& used = rows.row[static_cast<std::size_t>(s)];
    auto next = used.begin();
    for (int k = 0; k < data.length(s); ++k) {
      if (next == used.end() || *next != k) {
        f(s, k, none, 0.0);
        continue;
      }
      columns = rows.J.row(r);
      f(s, k, columns, rows.e[r]);
      ++next;
      ++r;
    }
  }
}

// Calls f(sequence, row, row of the Jacobian, residual) for every row of the residuals at x; the
// Jacobian's columns are the coordinates `wanted`. Unused rows are zero.
template <class F>
void for_each_row(const JointFrictionData& data, const friction::RobotFriction& friction,
                  const SearchCoordinates& coordinates, std::span<const double> x,
                  std::span<const std::size_t> wanted, F&& f) {
  if (friction::Tangent::is_known(friction))
    return for_each_known_row(data, friction, coordinates, x, wanted, f);
  const auto p = static_cast<Eigen::Index>(wanted.size());
  // Lane 0 of every pass holds x itself, the others one shifted coordinate each.
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

  std::vector<std::vector<PackD>> e(static_cast<std::size_t>(passes));
  std::vector<PackD> work;
  Eigen::VectorXd columns(p);
  for (int s = 0; s < data.sequences(); ++s) {
    for (std::size_t pass = 0; pass < e.size(); ++pass)
      data.residual(friction, lanes[pass], s, e[pass], work);
    for (std::size_t k = 0; k < e[0].size(); ++k) {
      const double base = e[0][k][0];
      for (Eigen::Index i = 0; i < p; ++i) {
        const auto pass = static_cast<std::size_t>(i / kColumns);
        const int lane = static_cast<int>(i % kColumns) + 1;
        columns[i] = (e[pass][k][lane] - base) / step[static_cast<std::size_t>(i)];
      }
      f(s, static_cast<int>(k), columns, base);
    }
  }
}

// J'J and J'e of the residuals beside the best constant at x, over the number of rows, of the free
// coordinates.
optimise::Quadratic linearise(const JointFrictionData& data,
                              const friction::RobotFriction& friction,
                              const SearchCoordinates& coordinates, std::span<const double> x,
                              double value) {
  const auto p = static_cast<Eigen::Index>(coordinates.free().size());
  optimise::Quadratic out{value, Eigen::VectorXd::Zero(p), Eigen::MatrixXd::Zero(p, p)};
  Eigen::VectorXd columns = Eigen::VectorXd::Zero(p);
  double sum = 0;
  if (friction::Tangent::is_known(friction)) {
    const UsedRows rows = known_rows(data, friction, coordinates, x, coordinates.free());
    out.H.selfadjointView<Eigen::Lower>().rankUpdate(rows.J.transpose());
    out.g = rows.J.transpose() * rows.e;
    columns = rows.J.colwise().sum();
    sum = rows.e.sum();
  } else {
    for_each_row(data, friction, coordinates, x, coordinates.free(),
                 [&](int, int, const Eigen::VectorXd& column, double residual) {
                   if (residual == 0) return;
                   out.H.selfadjointView<Eigen::Lower>().rankUpdate(column);
                   out.g += residual * column;
                   columns += column;
                   sum += residual;
                 });
  }
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
  Eigen::VectorXd unit(p);
  for (Eigen::Index i = 0; i < p; ++i) unit[i] = H(i, i) > 0 ? 1 / std::sqrt(H(i, i)) : 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> directions(
      Eigen::MatrixXd(unit.asDiagonal() * H * unit.asDiagonal()));
  Eigen::VectorXd inverse = directions.eigenvalues(), unknown = Eigen::VectorXd::Zero(p);
  for (Eigen::Index d = 0; d < p; ++d) {
    const bool known = inverse[d] > kUnknown;
    if (!known) unknown += directions.eigenvectors().col(d).cwiseAbs2();
    inverse[d] = known ? 1 / inverse[d] : 0;
  }
  const Eigen::MatrixXd half = directions.eigenvectors() * inverse.asDiagonal() *
                               directions.eigenvectors().transpose() * unit.asDiagonal();
  Eigen::MatrixXd covariance = unit.asDiagonal() * half * B * half.transpose() * unit.asDiagonal();
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index i = 0; i < p; ++i)
    if (unknown[i] > kPart) {
      covariance.row(i).setConstant(kNone);
      covariance.col(i).setConstant(kNone);
    }
  return covariance;
}

// One value per used row, 0 at the others and everywhere where there are none.
PerSample at_used_rows(const JointFrictionData& data, const Eigen::VectorXd& values) {
  PerSample out;
  Eigen::Index r = 0;
  for (const std::vector<int>& used : data.used_rows()) {
    out.emplace_back(static_cast<std::size_t>(data.length(static_cast<int>(out.size()))), 0.0);
    if (values.size() == 0) continue;
    for (const int k : used) out.back()[static_cast<std::size_t>(k)] = values[r++];
  }
  return out;
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
  struct Block {
    Eigen::VectorXd score, columns;
    Eigen::MatrixXd H;
    double residuals = 0, rows = 0;
  };
  const auto p = static_cast<Eigen::Index>(free.size());
  const int length = std::max(1, static_cast<int>(std::lround(kBlock / data.dt())));
  const PerSample motion = at_used_rows(data, motion_error);
  std::vector<Block> blocks;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(p, p);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(p), of_motion = mean;
  double mean_residual = 0, mean_of_motion = 0;
  for_each_row(data, friction, coordinates, x, free,
               [&](int s, int k, const Eigen::VectorXd& column, double residual) {
                 if (k % length == 0)
                   blocks.push_back({Eigen::VectorXd::Zero(p), Eigen::VectorXd::Zero(p),
                                     Eigen::MatrixXd::Zero(p, p)});
                 if (residual == 0) return;
                 Block& block = blocks.back();
                 block.score += residual * column;
                 block.columns += column;
                 block.residuals += residual;
                 block.rows += 1;
                 block.H += column * column.transpose();
                 mean += column / data.rows();
                 mean_residual += residual / data.rows();
                 const double m = motion[static_cast<std::size_t>(s)][static_cast<std::size_t>(k)];
                 of_motion += m * column;
                 mean_of_motion += m / data.rows();
               });
  for (const Block& block : blocks) H += block.H;
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
  for (const Block& block : blocks) {
    Eigen::VectorXd score = block.score - mean_residual * block.columns - block.residuals * mean +
                            block.rows * mean_residual * mean;
    const Eigen::MatrixXd others =
        Eigen::MatrixXd::Identity(p, p) - inverse.solve(block.H).transpose();
    const Eigen::VectorXd left_out = others.partialPivLu().solve(score);
    if (left_out.allFinite()) score = left_out;
    B += score * score.transpose();
  }
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
