#include "fricid/smc/statistical_twist.hpp"

#include "fricid/base/eigen_instances.hpp"

namespace fricid::smc {
namespace {

constexpr std::uint64_t kSeed = 0x7369676D61;
constexpr double kOuterScale = 2;

}  // namespace

PairedDraws::PairedDraws(int n, int pairs, double outer)
    : n_(n),
      pairs_(pairs),
      core_pairs_(pairs - static_cast<int>(outer * pairs)),
      normals_(static_cast<std::size_t>(pairs * n)),
      white_(pairs, n),
      d_(2 * pairs, n),
      f_(2 * pairs, n),
      core_(Eigen::VectorXd::Zero(2 * pairs)),
      x_(static_cast<std::size_t>(2 * pairs / PackD::kLanes * n), PackD(0)),
      image_(x_) {
  core_.head(core_pairs_).setOnes();
  core_.segment(pairs, core_pairs_).setOnes();
}

bool PairedDraws::place(int t, const Gaussian& x) {
  constexpr int kLanes = PackD::kLanes;
  root_.compute(x.covariance);
  if (root_.info() != Eigen::Success || !x.covariance.allFinite()) return false;
  fill_normal(kSeed, static_cast<std::uint64_t>(t), 0, normals_);
  white_ = Eigen::Map<const Eigen::MatrixXd>(normals_.data(), pairs_, n_);
  d_.topRows(pairs_).noalias() = white_ * root_.matrixL().transpose();
  d_.middleRows(core_pairs_, pairs_ - core_pairs_) *= kOuterScale;
  d_.bottomRows(pairs_) = -d_.topRows(pairs_);
  for (int b = 0; b < blocks(); ++b)
    for (int i = 0; i < n_; ++i) {
      const Eigen::Matrix<double, kLanes, 1> lanes =
          d_.col(i).segment<kLanes>(b * kLanes).array() + x.mean(i);
      x_[static_cast<std::size_t>(b * n_ + i)] = load<PackD>(lanes.data());
    }
  return true;
}

void PairedDraws::linearise(const Eigen::VectorXd& s_next, Eigen::MatrixXd& A, Eigen::VectorXd& c) {
  for (int b = 0; b < blocks(); ++b)
    for (int i = 0; i < n_; ++i) store(image(b)[i], f_.data() + i * f_.rows() + b * PackD::kLanes);
  // the even part of f drops out of the slope, the odd part out of the mean
  const auto up = f_.topRows(core_pairs_), down = f_.middleRows(pairs_, core_pairs_);
  const auto white = white_.topRows(core_pairs_);
  A = (white.transpose() * white).llt().solve(white.transpose() * (0.5 * (up - down)));
  root_.matrixL().transpose().solveInPlace(A);
  A.transposeInPlace();
  c = 0.5 * (up + down).colwise().mean().transpose() - s_next;
}

}  // namespace fricid::smc
