// The functions psi of the twisted filter by statistical linearisation.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/smc/twist.hpp"

namespace fricid::smc {

/// psi along the smoothed means s_t of `path`, with the slope and offset that f_t has on average
/// over N(s_t, P_t) instead of its Jacobian at s_t. By least squares over at least 64 draws d of
/// N(0, P_t), which come in pairs +d, -d, twice as many pairs as states,
///
///     A = argmin sum |f(s + d) - mean f - A d|^2,     c = mean (f(s + d) - A d) - s_{t+1}.
///
/// Where f has a kink in reach of x_t, as friction where a joint sticks, particles on both sides of
/// it then depart from the linearisation by less. Exact for a linear model.
/// @see Garcia-Fernandez, Svensson & Sarkka, IEEE TSP 63, 2015
template <StateSpaceModel M>
void make_statistical_twist(M& model, const RowMatrix& y, const GaussianPath& path, Twist& twist) {
  constexpr std::uint64_t kSeed = 0x7369676D61;
  constexpr int kFewestPairs = 32, kLanes = PackD::kLanes;
  const int n = model.state_size(), half = padded(std::max(kFewestPairs, 2 * n));
  const auto T = static_cast<std::size_t>(path.steps());
  twist.s.resize(T);
  twist.c.resize(T - 1);
  twist.A.resize(T - 1);
  for (std::size_t t = 0; t < T; ++t) twist.s[t] = path.smoothed[t].mean;
  Eigen::MatrixXd white(half, n), rise(half, n), B(n, n);
  Eigen::VectorXd sum(n);
  std::vector<double> draws(static_cast<std::size_t>(half * n));
  std::vector<PackD> up(static_cast<std::size_t>(n)), down(up);
  for (std::size_t t = 0; t + 1 < T; ++t) {
    const Eigen::LLT<Eigen::MatrixXd> root(path.smoothed[t].covariance);
    fill_normal(kSeed, t, 0, draws);
    white = Eigen::Map<const Eigen::MatrixXd>(draws.data(), half, n);
    const Eigen::MatrixXd d = white * root.matrixL().transpose();
    sum.setZero();
    for (int k = 0; k < half; k += kLanes) {
      for (int i = 0; i < n; ++i)
        for (int l = 0; l < kLanes; ++l) {
          up[static_cast<std::size_t>(i)].set(l, twist.s[t](i) + d(k + l, i));
          down[static_cast<std::size_t>(i)].set(l, twist.s[t](i) - d(k + l, i));
        }
      model.transition(static_cast<int>(t), std::span<PackD>(up));
      model.transition(static_cast<int>(t), std::span<PackD>(down));
      for (int i = 0; i < n; ++i) {
        const auto at = static_cast<std::size_t>(i);
        for (int l = 0; l < kLanes; ++l) {
          rise(k + l, i) = 0.5 * (up[at][l] - down[at][l]);
          sum(i) += up[at][l] + down[at][l];
        }
      }
    }
    // the even part of f drops out of the slope, the odd part out of the mean
    B = (white.transpose() * white).llt().solve(white.transpose() * rise);
    root.matrixL().transpose().solveInPlace(B);
    twist.A[t] = B.transpose();
    twist.c[t] = sum / (2 * half) - twist.s[t + 1];
  }
  twist_backward(model.Q(), model.C(), model.R(), y, Foresight::kWhole, twist);
}

}  // namespace fricid::smc
