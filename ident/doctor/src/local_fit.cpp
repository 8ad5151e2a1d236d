#include "local_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fricid::doctor {
namespace {

constexpr int kFewest = 4;  // samples on either side

}  // namespace

Parabola local_fit(const data::RowMatrix& x, int column, int k, int half) {
  const double N = 2.0 * half + 1;
  double s2 = 0, s4 = 0;
  for (int i = 1; i <= half; ++i) {
    s2 += 2.0 * i * i;
    s4 += 2.0 * i * i * i * i;
  }
  double sum = 0, first = 0, second = 0;
  for (int i = -half; i <= half; ++i) {
    const double value = x(k + i, column);
    sum += value;
    first += i * value;
    second += (static_cast<double>(i) * i - s2 / N) * value;
  }
  const double c2 = second / (s4 - s2 * s2 / N);
  return {sum / N - c2 * s2 / N, first / s2, c2};
}

namespace {

// The torque of a joint about sample i of a motion, moved back in time by `delay` samples.
Parabola torque_near(const Motion& motion, int i, int joint, double delay) {
  const double shift = delay - 0.5;
  const int whole = static_cast<int>(std::lround(shift));
  const Parabola p = local_fit(motion.log->tau, joint,
                               motion.samples[static_cast<std::size_t>(i)] + whole, motion.half);
  const double s = shift - whole;
  return {p.at(s), p.c1 + 2 * p.c2 * s, p.c2};
}

}  // namespace

data::RowMatrix smooth(const data::RowMatrix& x, int half) {
  constexpr int kPasses = 3;
  const Eigen::Index T = x.rows();
  data::RowMatrix y = x;
  std::vector<double> sum(static_cast<std::size_t>(T) + 1);
  std::vector<int> missing(sum.size());
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    for (int pass = 0; pass < kPasses; ++pass) {
      sum[0] = 0;
      missing[0] = 0;
      for (Eigen::Index k = 0; k < T; ++k) {
        const auto at = static_cast<std::size_t>(k);
        const bool finite = std::isfinite(y(k, j));
        sum[at + 1] = sum[at] + (finite ? y(k, j) : 0);
        missing[at + 1] = missing[at] + (finite ? 0 : 1);
      }
      for (Eigen::Index k = 0; k < T; ++k) {
        const bool inside = k >= half && k + half < T;
        const auto begin = static_cast<std::size_t>(std::max<Eigen::Index>(0, k - half));
        const auto end = static_cast<std::size_t>(std::min<Eigen::Index>(T, k + half + 1));
        const bool whole = inside && missing[end] == missing[begin];
        y(k, j) = whole ? (sum[end] - sum[begin]) / (2.0 * half + 1)
                        : std::numeric_limits<double>::quiet_NaN();
      }
    }
  return y;
}

Eigen::VectorXd Motion::torque(int joint, double delay) const {
  Eigen::VectorXd tau(length());
  for (int i = 0; i < length(); ++i) tau[i] = torque_near(*this, i, joint, delay).c0;
  return tau;
}

Eigen::MatrixX3d Motion::torque_and_rates(int joint, double delay) const {
  Eigen::MatrixX3d tau(length(), 3);
  for (int i = 0; i < length(); ++i) {
    const Parabola p = torque_near(*this, i, joint, delay);
    tau.row(i) << p.c0, p.c1 / dt, 2 * p.c2 / (dt * dt);
  }
  return tau;
}

Motion local_motion(const data::Dataset& d, int count, double half_s, int margin) {
  Motion motion;
  motion.log = &d;
  motion.dt = d.dt();
  motion.half = std::max(kFewest, static_cast<int>(std::lround(half_s / d.dt())));
  const int reach = motion.half + margin;

  // last sample with a value missing, for each sample
  const int T = d.length(), n = d.n();
  int last_missing = -1;
  std::vector<int> whole;  // centres whose window has ended without a missing value
  for (int k = 0; k < T; ++k) {
    if (!d.q.row(k).allFinite() || !d.tau.row(k).allFinite()) last_missing = k;
    if (k - 2 * reach > last_missing) whole.push_back(k - reach);
  }
  const int size = static_cast<int>(whole.size());
  const int chosen = std::min(count, size);
  for (int i = 0; i < chosen; ++i)
    motion.samples.push_back(
        whole[static_cast<std::size_t>(static_cast<long long>(i) * size / chosen)]);

  motion.q.resize(chosen, n);
  motion.v.resize(chosen, n);
  motion.a.resize(chosen, n);
  for (int i = 0; i < chosen; ++i)
    for (int j = 0; j < n; ++j) {
      const Parabola p =
          local_fit(d.q, j, motion.samples[static_cast<std::size_t>(i)], motion.half);
      motion.q(i, j) = p.c0;
      motion.v(i, j) = p.c1 / motion.dt;
      motion.a(i, j) = 2 * p.c2 / (motion.dt * motion.dt);
    }
  return motion;
}

VelocityProducts compare_velocity(const Motion& motion, int j,
                                  const std::function<double(int)>& logged) {
  VelocityProducts sums;
  for (int i = 0; i < motion.length(); ++i) {
    const double w = logged(motion.samples[static_cast<std::size_t>(i)]);
    if (!std::isfinite(w)) continue;
    sums.dot += w * motion.v(i, j);
    sums.square += motion.v(i, j) * motion.v(i, j);
    sums.logged += w * w;
  }
  return sums;
}

}  // namespace fricid::doctor
