// Friction of a joint along its recorded motion, with its derivatives by parameters.

#include <algorithm>
#include <array>
#include <memory>

#include "fricid/base/group.hpp"
#include "fricid/base/transpose.hpp"
#include "fricid/friction/tangent.hpp"
#include "friction/drive_pieces.hpp"

namespace fricid::estimate {
namespace {

constexpr std::size_t kPackLanes = kLaneCount<PackD>;

using signals::DecimatedLowPass;
using Sums = DecimatedLowPass::Sums<PackD>;

}  // namespace

/// Keeps every sample.
class JointFrictionData::AllColumns {
 public:
  static constexpr std::size_t kWidth = 2 * kPackLanes;  // columns that are filtered side by side

  /// Of `count` columns, a multiple of kWidth.
  AllColumns(const JointFrictionData& data, std::size_t count) : data_(data) {
    for (const Series& series : data.series_)
      block_.emplace_back(count / kWidth, std::vector<Columns>(series.size()));
  }

  void reset() {}
  void step() {}
  void keep(std::span<const LaneSample> lanes, std::span<const PackD> now) {
    for (const auto& [lane, sequence, sample] : lanes) {
      const PackD* column = now.data();
      for (std::vector<Columns>& block : block_[sequence])
        for (PackD& half : block[sample - data_.series_[sequence].begin()].x)
          for (int i = 0; i < static_cast<int>(kPackLanes); ++i) half.set(i, (*column++)[lane]);
    }
  }
  void filter(std::size_t sequence) {
    for (std::vector<Columns>& block : block_[sequence])
      data_.low_pass_.apply(std::span(block), work_);
  }
  double at(std::size_t sequence, std::size_t sample, std::size_t i) const {
    const Columns& at = block_[sequence][i / kWidth][sample - data_.series_[sequence].begin()];
    return at.x[i % kWidth / kPackLanes][static_cast<int>(i % kPackLanes)];
  }

 private:
  using Columns = fricid::Group<PackD, 2>;

  const JointFrictionData& data_;
  std::vector<std::vector<std::vector<Columns>>> block_;  // of columns, in each sequence
  std::vector<Columns> work_;
};

/// Keeps sums over blocks of D samples. Every lane starts at a multiple of D, so that blocks end in
/// all lanes at once.
class JointFrictionData::DecimatedColumns {
 public:
  static constexpr std::size_t kWidth = kPackLanes;

  DecimatedColumns(const JointFrictionData& data, std::size_t count)
      : data_(data), count_(count), now_(at(data.decimated_.every()) * count) {
    for (const Series& series : data.series_) {
      const auto [begin, end] = series.range;
      Kept& of = kept_.emplace_back();
      of.first_block = begin / every();
      of.blocks = begin == end ? 0 : at((end - 1) / every() - of.first_block + 1);
      // written before they are read
      of.sums = std::make_unique_for_overwrite<Sums[]>(of.blocks * count / kPackLanes);
      of.ends.resize(2 * count / kPackLanes);
    }
  }

  void reset() {
    end_block();
    step_ = 0;
  }
  void step() {
    if (++step_ % every() == 0) end_block();
  }
  void keep(std::span<const LaneSample> lanes, std::span<const PackD> now) {
    const int phase = step_ % every();
    std::fill(row(filled_), row(phase), PackD(0));
    filled_ = phase + 1;
    PackD counts(0);
    for (const LaneSample& at : lanes) {
      counts.set(at.lane, 1);
      in_block_[static_cast<std::size_t>(at.lane)] = {true, at.sequence,
                                                      static_cast<int>(at.sample) / every()};
      const SampleRange& range = data_.series_[at.sequence].range;
      if (static_cast<int>(at.sample) == range.begin) keep_end(0, at, now);
      if (static_cast<int>(at.sample) == range.end - 1) keep_end(1, at, now);
    }
    for (std::size_t i = 0; i < count_; ++i) row(phase)[i] = now[i] * counts;
  }
  void filter(std::size_t sequence) {
    Kept& of = kept_[sequence];
    const auto [begin, end] = data_.series_[sequence].range;
    of.y.resize(of.blocks * count_ / kPackLanes);
    for (std::size_t pack = 0; pack < count_ / kPackLanes; ++pack)
      data_.decimated_.apply<PackD>({begin, end, of.ends[2 * pack], of.ends[2 * pack + 1],
                                     std::span(of.sums.get() + pack * of.blocks, of.blocks)},
                                    std::span(of.y).subspan(pack * of.blocks, of.blocks));
  }
  double at(std::size_t sequence, std::size_t sample, std::size_t i) const {
    const Kept& of = kept_[sequence];
    const std::size_t block = sample / at(every()) - at(of.first_block);
    return of.y[i / kPackLanes * of.blocks + block][static_cast<int>(i % kPackLanes)];
  }

 private:
  /// Of one sequence, columns in packs, one pack after the other.
  struct Kept {
    int first_block = 0;
    std::size_t blocks = 0;
    std::unique_ptr<Sums[]> sums;
    std::vector<PackD> ends;  // first and last sample
    std::vector<PackD> y;     // filtered
  };
  /// The block that a lane is in.
  struct LaneBlock {
    bool counts = false;
    std::size_t sequence = 0;
    int block = 0;
  };

  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  int every() const { return data_.decimated_.every(); }
  std::vector<PackD>::iterator row(int phase) {
    return now_.begin() + static_cast<std::ptrdiff_t>(at(phase) * count_);
  }
  void keep_end(std::size_t which, const LaneSample& of, std::span<const PackD> now) {
    for (std::size_t i = 0; i < count_; ++i)
      kept_[of.sequence].ends[i / kPackLanes * 2 + which].set(static_cast<int>(i % kPackLanes),
                                                              now[i][of.lane]);
  }
  /// Sums up the samples since the last block.
  void end_block() {
    if (filled_ == 0) return;
    std::array<std::array<PackD, kPackLanes>, DecimatedLowPass::kSums> sums;
    for (std::size_t pack = 0; pack < count_ / kPackLanes; ++pack) {
      for (std::size_t i = 0; i < kPackLanes; ++i) {
        const std::size_t column = pack * kPackLanes + i;
        std::array<PackD, DecimatedLowPass::kWeighted> sum;
        sum.fill(PackD(0));
        for (int phase = 0; phase < filled_; ++phase) {
          const PackD x = row(phase)[static_cast<std::ptrdiff_t>(column)];
          const auto weights = data_.decimated_.weights(phase);
          for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = fma(PackD(weights[k]), x, sum[k]);
        }
        for (std::size_t k = 0; k < sum.size(); ++k) sums[k][i] = sum[k];
        sums.back()[i] = now_[column];
      }
      for (auto& of_columns : sums) transpose(of_columns);
      for (std::size_t lane = 0; lane < kPackLanes; ++lane) {
        if (!in_block_[lane].counts) continue;
        Kept& of = kept_[in_block_[lane].sequence];
        Sums& to = of.sums[pack * of.blocks + at(in_block_[lane].block - of.first_block)];
        for (std::size_t k = 0; k < to.size(); ++k) to[k] = sums[k][lane];
      }
    }
    filled_ = 0;
    in_block_ = {};
  }

  const JointFrictionData& data_;
  std::size_t count_;
  std::vector<PackD> now_;  // columns at the steps of a block
  int filled_ = 0;          // of these steps
  int step_ = 0;
  std::array<LaneBlock, kPackLanes> in_block_;
  std::vector<Kept> kept_;
};

bool JointFrictionData::are_decimated(std::span<const std::vector<int>> row) const {
  for (std::size_t s = 0; s < row.size(); ++s) {
    if (row[s].empty()) continue;
    const SampleRange& range = series_[s].range;
    if (!decimated_.is_of_use(range.size()) || !std::ranges::all_of(row[s], [&](int k) {
          return k % decimated_.every() == 0 && k >= range.begin && k < range.end;
        }))
      return false;
  }
  return true;
}

template <class Columns>
JointFrictionData::Linear JointFrictionData::linearise_into(
    const friction::RobotFriction& friction, std::span<const double> theta,
    std::span<const std::size_t> wanted, std::span<const std::vector<int>> row) const {
  struct {
    const friction::RobotFriction& friction;
    std::span<const std::size_t> wanted;
    double dt;
    friction::Tangent tangent;
    std::vector<PackD> theta, z_bar, by_theta;
    std::vector<PackD> now;  // f and the columns at one step
    Columns kept;

    void reset() {
      tangent.reset();
      kept.reset();
    }
    void torque(const friction::Input<PackD>& in, std::span<const PackD> z,
                std::span<const LaneSample> lanes) {
      const PackD one(1);
      friction::Input<PackD> in_bar{};
      std::ranges::fill(z_bar, PackD(0));
      std::ranges::fill(by_theta, PackD(0));
      friction.torque<PackD>(theta, {&in, 1}, z, {now.data(), 1});
      friction.torque_pullback<PackD>(theta, {&in, 1}, z, {&one, 1}, by_theta, {&in_bar, 1}, z_bar);
      tangent.add(theta, z_bar, by_theta);
      for (std::size_t i = 0; i < wanted.size(); ++i) now[i + 1] = by_theta[wanted[i]];
      kept.keep(lanes, now);
    }
    void step(std::span<const friction::Input<PackD>> over, std::span<PackD> z) {
      for (const friction::Input<PackD>& in : over) tangent.step(theta, {&in, 1}, dt, z);
      kept.step();
    }
  } driver{friction,
           wanted,
           step_s(),
           friction::Tangent(friction),
           {theta.begin(), theta.end()},
           std::vector<PackD>(static_cast<std::size_t>(friction.state_size())),
           std::vector<PackD>(theta.size()),
           std::vector<PackD>((wanted.size() / Columns::kWidth + 1) * Columns::kWidth, PackD(0)),
           Columns(*this, (wanted.size() / Columns::kWidth + 1) * Columns::kWidth)};
  drive(friction, theta, driver);
  driver.kept.reset();

  Eigen::Index rows = 0;
  for (const std::vector<int>& of_sequence : row) rows += std::ssize(of_sequence);
  Linear out{Eigen::VectorXd(rows), Eigen::MatrixXd(rows, std::ssize(wanted))};
  Eigen::Index r = 0;
  for (std::size_t s = 0; s < row.size(); ++s) {
    if (row[s].empty()) continue;
    driver.kept.filter(s);
    for (std::size_t i = 0; i <= wanted.size(); ++i) {
      double* column = i == 0 ? out.f.data() + r : &out.J(r, static_cast<Eigen::Index>(i) - 1);
      for (const int k : row[s]) *column++ = driver.kept.at(s, static_cast<std::size_t>(k), i);
    }
    r += std::ssize(row[s]);
  }
  return out;
}

JointFrictionData::Linear JointFrictionData::linearise(
    const friction::RobotFriction& friction, std::span<const double> theta,
    std::span<const std::size_t> wanted, std::span<const std::vector<int>> row) const {
  return are_decimated(row) ? linearise_into<DecimatedColumns>(friction, theta, wanted, row)
                            : linearise_into<AllColumns>(friction, theta, wanted, row);
}

}  // namespace fricid::estimate
