#include "fricid/estimate/couplings.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "rigid_body/information.hpp"

namespace fricid::estimate {
namespace {

constexpr double kApart = 0.02;      // [s] between samples that are looked at
constexpr double kCoupled = 0.4;     // share of a joint's residual
constexpr double kExplained = 0.97;  // R2 above which a coupling does not matter

/// Residual sum of squares of y regressed on the columns of X.
double left_by(const Eigen::MatrixXd& X, const Eigen::VectorXd& y) {
  Eigen::MatrixXd H = X.transpose() * X;
  H.diagonal() *= 1 + 1e-9;
  const Eigen::VectorXd x = invert(H, nullptr) * (X.transpose() * y);
  return (y - X * x).squaredNorm();
}

}  // namespace

std::vector<Coupling> find_couplings(std::span<const signals::Recording> recordings,
                                     const FrictionTorques& target) {
  const int n = recordings.front().n();
  std::vector<Coupling> found(static_cast<std::size_t>(n));
  for (int j = 0; j < n; ++j) {
    std::vector<Eigen::RowVectorXd> speeds;
    std::vector<double> torques;
    double sum = 0, square = 0;  // of the whole torque
    for (std::size_t s = 0; s < recordings.size(); ++s) {
      const signals::Recording& r = recordings[s];
      const int every = std::max(1, static_cast<int>(std::lround(kApart / r.dt)));
      for (int k = 0; k < r.length(); k += every)
        if (r.use(k, j)) {
          speeds.push_back(r.wide.v.row(k));
          torques.push_back(target[s](k, j));
          sum += r.filtered_tau(k, j), square += std::pow(r.filtered_tau(k, j), 2);
        }
    }
    const auto rows = static_cast<Eigen::Index>(torques.size());
    if (rows < 10) continue;
    const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(torques.data(), rows);
    Eigen::MatrixXd v(rows, n), X(rows, 5);
    for (Eigen::Index i = 0; i < rows; ++i) v.row(i) = speeds[static_cast<std::size_t>(i)];
    X.leftCols(3) << v.col(j).array().sign().matrix(), v.col(j), Eigen::VectorXd::Ones(rows);
    const double own = left_by(X.leftCols(3), y);
    Coupling& best = found[static_cast<std::size_t>(j)];
    best.r2 = 1 - own / (square - sum * sum / static_cast<double>(rows));
    for (int k = 0; k < n; ++k)
      for (const double sign : {1.0, -1.0}) {
        if (k == j || !(own > 0)) continue;
        X.col(4) = v.col(j) + sign * v.col(k);
        X.col(3) = X.col(4).array().sign().matrix();
        const double share = 1 - left_by(X, y) / own;
        if (share > best.share) best = {k, sign, share, best.r2};
      }
  }
  return found;
}

bool matters(const Coupling& coupling, double r2) {
  return coupling.share > kCoupled && r2 < kExplained;
}

const std::string& name_of_other(const Coupling& coupling, const dynamics::RobotModel& robot) {
  return robot.joints[static_cast<std::size_t>(coupling.with)].name;
}

std::string declaration_of(const Coupling& coupling, int joint, const dynamics::RobotModel& robot) {
  const auto [outer, inner] = std::minmax(joint, coupling.with, std::greater());
  return fmt::format("[[robot.coupling]] joint = \"{}\", motor = \"{}\", factor = {:g}",
                     robot.joints[static_cast<std::size_t>(outer)].name,
                     robot.joints[static_cast<std::size_t>(inner)].name, -coupling.sign);
}

}  // namespace fricid::estimate
