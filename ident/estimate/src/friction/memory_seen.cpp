#include "friction/memory_seen.hpp"

#include <cmath>
#include <vector>

#include "blocks.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kHeldOut = 0.8;    // of every recording, from there on
constexpr double kLeastGain = 0.3;  // of what is left: a sharper step at reversals gains less
constexpr std::size_t kFewestBlocks = 3;

/// A part of every recording that is predicted from the rest of it, [from, to) of its length.
struct HeldOut {
  double from, to;

  SampleRange of(int length) const {
    return {static_cast<int>(from * length), static_cast<int>(to * length)};
  }
  SampleRange rest_of(int length) const {
    const SampleRange out = of(length);
    return out.begin > 0 ? SampleRange{0, out.begin} : SampleRange{out.end, length};
  }
};

/// Squared residuals at given samples of a law that was fitted to `fitted`.
Eigen::ArrayXd squares_of(const char* law, const JointFrictionData& fitted,
                          const JointFrictionData& all, const RigidBodyFit& rigid, int joint,
                          std::span<const std::vector<int>> row) {
  const friction::RobotFriction one({friction::JointSpec{{{law, 0, {}}}}});
  FrictionFitOptions options;
  options.starts = 1;
  const std::vector<double> theta =
      fit_joint_friction(fitted, one, friction::start_from(one, guess_of(rigid, fitted, joint)),
                         options)
          .theta;
  const double c = fitted.offset(one, theta);
  const PerSample f = all.predict(one, theta);
  std::vector<double> e;
  for (std::size_t s = 0; s < row.size(); ++s)
    for (const int k : row[s])
      e.push_back(all.target(static_cast<int>(s), k) - f[s][static_cast<std::size_t>(k)] - c);
  return Eigen::ArrayXd::Map(e.data(), std::ssize(e)).square();
}

/// What a law leaves in each block of a second without memory, and by how much less with one.
struct Gains {
  std::vector<double> left, less;
};

}  // namespace

bool shows_memory(std::span<const signals::Recording> recordings, const FrictionTorques& target,
                  const RigidBodyFit& rigid, int joint, double cutoff_hz) {
  const OffsetPrior prior = offset_prior(rigid, joint);
  const JointFrictionData all(recordings, target, joint, cutoff_hz, prior);
  const auto rows_in = [&](const HeldOut& part) {
    std::vector<std::vector<int>> row = all.used_rows();
    for (std::size_t s = 0; s < row.size(); ++s) {
      const SampleRange out = part.of(recordings[s].length());
      std::erase_if(row[s], [&](int k) { return k < out.begin || k >= out.end; });
    }
    return row;
  };
  std::vector<HeldOut> parts{{kHeldOut, 1}};
  if (blocks_of(rows_in(parts[0]), all.blocks()).size() < kFewestBlocks)
    parts = {{0, 0.5}, {0.5, 1}};
  Gains gains;
  for (const HeldOut& part : parts) {
    std::vector<SampleRange> ranges;
    for (const signals::Recording& r : recordings) ranges.push_back(part.rest_of(r.length()));
    const JointFrictionData fitted(recordings, target, joint, cutoff_hz, prior, ranges);
    if (fitted.rows() == 0) return false;
    const std::vector<std::vector<int>> row = rows_in(part);
    const Eigen::ArrayXd without = squares_of("coulomb_viscous", fitted, all, rigid, joint, row),
                         with = squares_of("dahl", fitted, all, rigid, joint, row);
    if (!without.allFinite() || !with.allFinite()) return false;
    for (const auto& [begin, size] : blocks_of(row, all.blocks())) {
      gains.left.push_back(without.segment(begin, size).sum());
      gains.less.push_back(gains.left.back() - with.segment(begin, size).sum());
    }
  }
  if (gains.less.size() < kFewestBlocks) return false;
  const auto gain = Eigen::ArrayXd::Map(gains.less.data(), std::ssize(gains.less)),
             left = Eigen::ArrayXd::Map(gains.left.data(), std::ssize(gains.left));
  const auto count = static_cast<double>(gain.size());
  const double error = std::sqrt((gain - gain.mean()).square().sum() / (count - 1) * count);
  return gain.sum() > std::max(error, kLeastGain * left.sum());
}

}  // namespace fricid::estimate
