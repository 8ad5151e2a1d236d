#include "fricid/optimise/arrow.hpp"

#include "fricid/base/eigen_instances.hpp"

namespace fricid::optimise {

Eigen::VectorXd solve_arrow(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                            const std::vector<Block>& blocks) {
  if (blocks.empty()) return H.ldlt().solve(g);
  std::vector<Eigen::Index> rest;
  Eigen::Index next = 0;
  for (const Block& block : blocks) {
    for (; next < block.begin; ++next) rest.push_back(next);
    next += block.size;
  }
  for (; next < g.size(); ++next) rest.push_back(next);

  Eigen::MatrixXd R = H(rest, rest);
  Eigen::VectorXd r = g(rest);
  std::vector<Eigen::VectorXd> own;      // D^-1 g
  std::vector<Eigen::MatrixXd> carried;  // D^-1 B'
  // where the blocks are all, nothing is solved for the rest
  const auto solved = [](const auto& factor, const Eigen::MatrixXd& y) {
    return y.size() == 0 ? y : Eigen::MatrixXd(factor.solve(y));
  };
  for (const Block& block : blocks) {
    const Eigen::MatrixXd D = H.block(block.begin, block.begin, block.size, block.size);
    const Eigen::MatrixXd B = H.middleCols(block.begin, block.size)(rest, Eigen::all);
    const Eigen::LDLT<Eigen::MatrixXd> factor(D);
    own.push_back(factor.solve(g.segment(block.begin, block.size)));
    carried.push_back(solved(factor, B.transpose()));
    R.noalias() -= B * carried.back();
    r.noalias() -= B * own.back();
  }
  const Eigen::VectorXd of_rest = solved(R.ldlt(), r);
  Eigen::VectorXd x(g.size());
  x(rest) = of_rest;
  for (std::size_t b = 0; b < blocks.size(); ++b)
    x.segment(blocks[b].begin, blocks[b].size) = own[b] - carried[b] * of_rest;
  return x;
}

}  // namespace fricid::optimise
