#include "fricid/sim/fourier.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "fricid/base/eigen_instances.hpp"

namespace fricid::sim {

double Fourier::period() const { return 2 * std::numbers::pi / w; }

TimeGrid::TimeGrid(double w, int harmonics, Eigen::VectorXd t)
    : t_(std::move(t)), kw_(w * Eigen::ArrayXd::LinSpaced(harmonics, 1, harmonics)) {
  const Eigen::MatrixXd angle = kw_.matrix() * t_.transpose();
  cosine_ = angle.unaryExpr([](double x) { return std::cos(x); });
  sine_ = angle.unaryExpr([](double x) { return std::sin(x); });
}

TimeGrid TimeGrid::over_period(double w, int harmonics, int count) {
  return {w, harmonics, Eigen::VectorXd::LinSpaced(count + 1, 0, 2 * std::numbers::pi / w)};
}

Motion TimeGrid::sample(const Fourier& series) const {
  const Eigen::MatrixXd a_kw = series.a * kw_.matrix().asDiagonal();
  const Eigen::MatrixXd b_kw = series.b * kw_.matrix().asDiagonal();
  const auto inverse = kw_.inverse().matrix().eval();
  Motion motion;
  motion.q = series.a * inverse.asDiagonal() * sine_ - series.b * inverse.asDiagonal() * cosine_;
  motion.q.colwise() += series.q0;
  motion.v = series.a * cosine_ + series.b * sine_;
  motion.a = b_kw * cosine_ - a_kw * sine_;
  motion.jerk =
      -(a_kw * kw_.matrix().asDiagonal() * cosine_) - b_kw * kw_.matrix().asDiagonal() * sine_;
  return motion;
}

void start_at_rest(Fourier& series) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(series.harmonics());
  const Eigen::VectorXd k = Eigen::VectorXd::LinSpaced(series.harmonics(), 1, series.harmonics());
  series.a -= (series.a * ones) * ones.transpose() / ones.squaredNorm();
  series.b -= (series.b * k) * k.transpose() / k.squaredNorm();
}

}  // namespace fricid::sim
