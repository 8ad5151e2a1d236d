#include "rigid_body/dilution.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"

namespace fricid::estimate {
namespace {

constexpr Eigen::Index kMostRows = 20'000;  // of noise, about
constexpr double kMostDiluted = 0.98;       // share of noise in a direction that is told apart
constexpr std::uint64_t kSeed = 1;

}  // namespace

signals::Motion with_noise(const signals::Recording& recording, double cutoff_hz,
                           std::uint64_t seed) {
  signals::Motion out = signals::motion_of_noise(recording, cutoff_hz, seed);
  out.q += recording.narrow.q;
  out.v += recording.narrow.v;
  out.a += recording.narrow.a;
  return out;
}

NoiseRows draw_noise_rows(const dynamics::RobotModel& robot,
                          std::span<const signals::Recording> sequences, const Regression& data,
                          double cutoff_hz) {
  const int n = robot.n(), p = robot.parameter_count();
  std::vector<signals::Motion> moved;
  for (std::size_t i = 0; i < sequences.size(); ++i)
    moved.push_back(with_noise(sequences[i], cutoff_hz, kSeed + i));
  const Eigen::Index every = 1 + data.rows.rows() / kMostRows;
  const auto same_sample = [&](std::size_t r, std::size_t other) {
    return data.sequence[r] == data.sequence[other] && data.sample[r] == data.sample[other];
  };
  NoiseRows out;
  Eigen::Index samples = 0;
  for (std::size_t r = 0; r < data.joint.size(); ++r) {
    if (r == 0 || !same_sample(r, r - 1)) ++samples;
    if ((samples - 1) % every == 0) out.of.push_back(static_cast<Eigen::Index>(r));
  }
  out.share = static_cast<double>(out.of.size()) /
              static_cast<double>(std::max<std::size_t>(1, data.joint.size()));
  out.rows.setZero(std::ssize(out.of), data.rows.cols());
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd Y(n, p);
  for (Eigen::Index i = 0; i < out.rows.rows(); ++i) {
    const auto r = static_cast<std::size_t>(out.of[static_cast<std::size_t>(i)]);
    const int k = data.sample[r], j = data.joint[r];
    const signals::Motion& motion = moved[static_cast<std::size_t>(data.sequence[r])];
    if (i == 0 ||
        !same_sample(r, static_cast<std::size_t>(out.of[static_cast<std::size_t>(i - 1)]))) {
      regressor_at(robot, ws, motion, k, Y);
    }
    const int viscous = viscous_column(robot, j);
    out.rows.row(i).head(p) = Y.row(j) - data.rows.row(out.of[static_cast<std::size_t>(i)]).head(p);
    out.rows(i, viscous) = motion.v(k, j) - data.rows(out.of[static_cast<std::size_t>(i)], viscous);
  }
  return out;
}

Eigen::MatrixXd noise_information(const NoiseRows& noise, const std::vector<int>& columns,
                                  const Eigen::VectorXd& weight) {
  Eigen::MatrixXd N = noise.rows(Eigen::all, columns);
  for (Eigen::Index i = 0; i < N.rows(); ++i)
    N.row(i) *= std::sqrt(weight[noise.of[static_cast<std::size_t>(i)]] / noise.share);
  return N.transpose() * N;
}

Eigen::MatrixXd dilution_root(const Eigen::MatrixXd& information, const Eigen::MatrixXd& H,
                              const Eigen::VectorXd& score) {
  const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> cholesky(
      Eigen::MatrixXd(scale.asDiagonal() * H * scale.asDiagonal()));
  if (cholesky.info() != Eigen::Success) return Eigen::MatrixXd::Zero(H.rows(), 0);
  const auto in_L = [&](const Eigen::MatrixXd& x) {  // L^-1 x
    return Eigen::MatrixXd(cholesky.matrixL().solve(scale.asDiagonal() * x));
  };
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      in_L(in_L(information).transpose().eval()));
  const Eigen::ArrayXd mu = eigen.eigenvalues().array().max(0.0).min(kMostDiluted);
  const Eigen::ArrayXd y = (eigen.eigenvectors().transpose() * in_L(score)).array();
  return scale.asDiagonal() * cholesky.matrixU().solve(eigen.eigenvectors()) *
         ((y.square() + mu.square()).sqrt() / (1 - mu)).matrix().asDiagonal();
}

}  // namespace fricid::estimate
