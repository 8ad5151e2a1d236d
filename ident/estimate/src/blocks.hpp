// Rows by blocks of time, and the jackknife over them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "fricid/estimate/time_blocks.hpp"

namespace fricid::estimate {

/// Rows [begin, begin + size) of a stack, all of one block.
struct RowBlock {
  Eigen::Index begin = 0, size = 0;
  int block = 0;
};

/// The blocks of a stack of the samples row[s] of every recording s, in order; empty ones are left
/// out.
inline std::vector<RowBlock> blocks_of(std::span<const std::vector<int>> row,
                                       const TimeBlocks& time) {
  std::vector<RowBlock> blocks;
  Eigen::Index r = 0;
  for (std::size_t s = 0; s < row.size(); ++s)
    for (const int sample : row[s]) {
      const int block = time.of(s, sample);
      if (blocks.empty() || blocks.back().block != block) blocks.push_back({r, 0, block});
      ++blocks.back().size;
      ++r;
    }
  return blocks;
}

/// The blocks of the rows of a stack.
struct Blocks {
  std::vector<int> of_row;   ///< (rows) ascending from 0
  std::vector<int> passage;  ///< (blocks) as of `TimeBlocks`
};

/// Root D of the covariance D D' of an estimate by the jackknife over passages.
/// @param moves    by which it moves without block b (unknowns x blocks)
/// @param passage  (blocks) as of `TimeBlocks`; empty: each block is its own
inline Eigen::MatrixXd jackknife(Eigen::MatrixXd moves, std::span<const int> passage = {}) {
  if (!passage.empty()) {
    std::vector<int> order(passage.begin(), passage.begin() + moves.cols());
    std::ranges::sort(order);
    order.erase(std::ranges::unique(order).begin(), order.end());
    Eigen::MatrixXd of_passages = Eigen::MatrixXd::Zero(moves.rows(), std::ssize(order));
    for (Eigen::Index b = 0; b < moves.cols(); ++b)
      of_passages.col(std::ranges::lower_bound(order, passage[static_cast<std::size_t>(b)]) -
                      order.begin()) += moves.col(b);
    moves = std::move(of_passages);
  }
  const auto count = static_cast<double>(std::max<Eigen::Index>(1, moves.cols()));
  moves.colwise() -= moves.rowwise().mean().eval();
  return moves * std::sqrt((count - 1) / count);
}

}  // namespace fricid::estimate
