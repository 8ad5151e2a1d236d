// Rows by blocks of time, and the jackknife over them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "fricid/estimate/time_blocks.hpp"

namespace fricid::estimate {

/// Rows [begin, begin + size) of a stack.
struct RowBlock {
  Eigen::Index begin = 0, size = 0;
};

/// The blocks of a stack of the samples row[s] of every recording s, in order; empty ones are left
/// out.
inline std::vector<RowBlock> blocks_of(std::span<const std::vector<int>> row,
                                       const TimeBlocks& time) {
  std::vector<RowBlock> blocks;
  Eigen::Index r = 0;
  int last = -1;
  for (std::size_t s = 0; s < row.size(); ++s)
    for (const int sample : row[s]) {
      if (const int block = time.of(s, sample); block != last) {
        blocks.push_back({r, 0});
        last = block;
      }
      ++blocks.back().size;
      ++r;
    }
  return blocks;
}

/// The rows of each passage, those without any left out.
/// @param passage  of each row
inline std::vector<std::vector<Eigen::Index>> rows_by_passage(std::span<const int> passage) {
  std::vector<std::vector<Eigen::Index>> rows;
  for (std::size_t r = 0; r < passage.size(); ++r) {
    const auto at = static_cast<std::size_t>(passage[r]);
    if (at >= rows.size()) rows.resize(at + 1);
    rows[at].push_back(static_cast<Eigen::Index>(r));
  }
  std::erase_if(rows, [](const auto& of_passage) { return of_passage.empty(); });
  return rows;
}

/// Root D of the covariance D D' of an estimate by the jackknife.
/// @param moves  by which it moves without passage b (unknowns x passages)
inline Eigen::MatrixXd jackknife(Eigen::MatrixXd moves) {
  const auto count = static_cast<double>(std::max<Eigen::Index>(1, moves.cols()));
  moves.colwise() -= moves.rowwise().mean().eval();
  return moves * std::sqrt((count - 1) / count);
}

}  // namespace fricid::estimate
