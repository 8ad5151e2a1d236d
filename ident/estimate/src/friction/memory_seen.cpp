#include "friction/memory_seen.hpp"

#include <cmath>
#include <vector>

#include "blocks.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kFitted = 0.8;     // of every recording
constexpr double kLeastGain = 0.3;  // of what is left: a sharper step at reversals gains less
constexpr std::size_t kFewestBlocks = 3;

/// Residuals at given samples of a law that was fitted to `fitted`.
Eigen::VectorXd residual_of(const char* law, const JointFrictionData& fitted,
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
  return Eigen::VectorXd::Map(e.data(), std::ssize(e));
}

}  // namespace

bool shows_memory(std::span<const signals::Recording> recordings, const FrictionTorques& target,
                  const RigidBodyFit& rigid, int joint, double cutoff_hz) {
  std::vector<SampleRange> ranges;
  for (const signals::Recording& r : recordings)
    ranges.push_back({0, static_cast<int>(kFitted * r.length())});
  const OffsetPrior prior = offset_prior(rigid, joint);
  const JointFrictionData fitted(recordings, target, joint, cutoff_hz, prior, ranges),
      all(recordings, target, joint, cutoff_hz, prior);
  std::vector<std::vector<int>> row = all.used_rows();
  for (std::size_t s = 0; s < row.size(); ++s)
    std::erase_if(row[s], [&](int k) { return k < ranges[s].end; });
  const std::vector<RowBlock> blocks = blocks_of(row, all.blocks());
  if (fitted.rows() == 0 || blocks.size() < kFewestBlocks) return false;

  const auto squares = [&](const char* law) {
    return residual_of(law, fitted, all, rigid, joint, row).array().square().eval();
  };
  const Eigen::ArrayXd without = squares("coulomb_viscous"), with = squares("dahl");
  if (!without.allFinite() || !with.allFinite()) return false;
  Eigen::ArrayXd gain(std::ssize(blocks));
  for (std::size_t b = 0; b < blocks.size(); ++b)
    gain[static_cast<Eigen::Index>(b)] =
        (without - with).segment(blocks[b].begin, blocks[b].size).sum();
  const auto count = static_cast<double>(blocks.size());
  const double error = std::sqrt((gain - gain.mean()).square().sum() / (count - 1) * count);
  return gain.sum() > std::max(error, kLeastGain * without.sum());
}

}  // namespace fricid::estimate
