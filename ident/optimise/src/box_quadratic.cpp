#include "fricid/optimise/box_quadratic.hpp"

namespace fricid::optimise {
namespace {

constexpr int kExchanges = 10;  // of coordinates; afterwards none leaves a side of the box

/// Minimiser with coordinates held at sides of the box. @param side  -1: lower, 1: upper, 0: free
Eigen::VectorXd least_beside(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                             const std::vector<Block>& blocks, const Box& box,
                             const Eigen::VectorXi& side) {
  Eigen::VectorXd held = Eigen::VectorXd::Zero(g.size());
  for (Eigen::Index i = 0; i < g.size(); ++i)
    if (side[i] != 0) held[i] = side[i] < 0 ? box.lower[i] : box.upper[i];
  Eigen::MatrixXd of_free = H;
  Eigen::VectorXd pull = g + H * held;
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    if (side[i] == 0) continue;
    of_free.row(i).setZero();
    of_free.col(i).setZero();
    of_free(i, i) = 1;
    pull[i] = 0;
  }
  return held - solve_arrow(of_free, pull, blocks);
}

}  // namespace

Eigen::VectorXd least_in_box(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                             const std::vector<Block>& blocks, const Box& box) {
  Eigen::VectorXi side = Eigen::VectorXi::Zero(g.size());
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    if (box.lower[i] >= 0 && g[i] > 0) side[i] = -1;
    if (box.upper[i] <= 0 && g[i] < 0) side[i] = 1;
  }
  for (int exchange = 0;; ++exchange) {
    const Eigen::VectorXd s = least_beside(H, g, blocks, box, side);
    const Eigen::VectorXd slope = g + H * s;
    const bool may_leave = exchange < kExchanges;
    bool settled = true;
    for (Eigen::Index i = 0; i < g.size(); ++i) {
      int wanted = side[i];
      if (side[i] == 0)
        wanted = s[i] < box.lower[i] ? -1 : s[i] > box.upper[i] ? 1 : 0;
      else if (may_leave && side[i] * slope[i] > 0)
        wanted = 0;
      settled = settled && wanted == side[i];
      side[i] = wanted;
    }
    if (settled || !s.allFinite()) return box.clamp(s);
  }
}

}  // namespace fricid::optimise
