// Blocks of time whose residuals count as independent, and the jackknife over them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace fricid::estimate {

/// Residuals less than this apart are correlated: friction's memory leaves them so [s].
inline constexpr double kBlock = 1;

/// Samples of a block.
inline int block_length(double dt) {
  return std::max(1, static_cast<int>(std::lround(kBlock / dt)));
}

/// Rows [begin, begin + size) of a stack.
struct RowBlock {
  Eigen::Index begin = 0, size = 0;
};

/// The blocks of a stack of the samples row[s] of every recording s, in order; empty ones are left
/// out.
inline std::vector<RowBlock> blocks_of(std::span<const std::vector<int>> row, double dt) {
  const int length = block_length(dt);
  std::vector<RowBlock> blocks;
  Eigen::Index r = 0;
  for (const std::vector<int>& samples : row)
    for (std::size_t i = 0; i < samples.size(); ++i, ++r) {
      if (i == 0 || samples[i] / length != samples[i - 1] / length) blocks.push_back({r, 0});
      ++blocks.back().size;
    }
  return blocks;
}

/// Root D of the covariance D D' of an estimate by the jackknife.
/// @param moves  by which it moves without block b (unknowns x blocks)
inline Eigen::MatrixXd jackknife(Eigen::MatrixXd moves) {
  const auto blocks = static_cast<double>(std::max<Eigen::Index>(1, moves.cols()));
  moves.colwise() -= moves.rowwise().mean().eval();
  return moves * std::sqrt((blocks - 1) / blocks);
}

}  // namespace fricid::estimate
