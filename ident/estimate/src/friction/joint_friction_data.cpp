#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

#include "fricid/base/group.hpp"
#include "fricid/base/math.hpp"
#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/friction/tangent.hpp"

namespace fricid::estimate {
namespace {

constexpr int kLanes = kLaneCount<PackD>;
constexpr std::ptrdiff_t kPromising = 16;  // orders of a grid that are looked at closely

}  // namespace

JointFrictionData::JointFrictionData(std::span<const signals::Recording> sequences,
                                     std::span<const RowMatrix> target, int joint, double cutoff_hz,
                                     const OffsetPrior& prior)
    : prior_(prior),
      dt_(sequences.front().dt),
      cutoff_hz_(cutoff_hz),
      low_pass_(cutoff_hz, 1 / sequences.front().dt) {
  double sum = 0, square = 0;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (std::size_t first = 0; first < sequences.size(); first += kLanes) {
    const auto last = std::min(sequences.size(), first + kLanes);
    int longest = 0;
    for (std::size_t s = first; s < last; ++s) longest = std::max(longest, sequences[s].length());
    const auto T = static_cast<std::size_t>(longest);

    // Shorter sequences stand still at their last position; empty lanes repeat the first sequence.
    Group group;
    group.at.resize(T);
    group.over.resize(T);
    group.target.assign(T, PackD(0));
    group.weight.assign(T, PackD(0));
    for (int lane = 0; lane < kLanes; ++lane) {
      const bool present = first + static_cast<std::size_t>(lane) < last;
      const std::size_t index = present ? first + static_cast<std::size_t>(lane) : first;
      const signals::Recording& s = sequences[index];
      const int length = s.length();
      if (present) lengths_.push_back(length);
      for (int k = 0; k < longest; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const int row = std::min(k, length - 1);
        const bool moving = k + 1 < length;
        const double q = s.wide.q(row, joint), next = moving ? s.wide.q(row + 1, joint) : q;
        friction::Input<PackD>& at = group.at[i];
        friction::Input<PackD>& over = group.over[i];
        at.q.set(lane, q);
        at.v.set(lane, k < length ? s.wide.v(row, joint) : 0.0);
        at.load.set(lane, s.load(row, joint));
        at.temperature.set(lane, s.temperature(row, joint));
        over.q.set(lane, next);
        over.v.set(lane, (next - q) / dt_);
        over.load.set(lane, s.load(row, joint));
        over.temperature.set(lane, s.temperature(row, joint));
        if (!present || k >= length || !s.use(k, joint)) continue;
        const double value = target[index](row, joint);
        group.target[i].set(lane, value);
        group.weight[i].set(lane, 1);
        ++rows_;
        sum += value;
        square += value * value;
        lowest = std::min(lowest, q);
        highest = std::max(highest, q);
        largest_target_ = std::max(largest_target_, std::abs(value));
      }
    }
    groups_.push_back(std::move(group));
  }
  travel_ = std::max(0.0, highest - lowest);
  target_mean_square_ = rows_ > 0 ? square / rows_ - std::pow(sum / rows_, 2) : 0;
}

void JointFrictionData::drive(const friction::RobotFriction& friction,
                              std::span<const double> theta,
                              std::vector<std::vector<PackD>>& out) const {
  std::vector<PackD> parameters(theta.begin(), theta.end());
  std::vector<PackD> z(static_cast<std::size_t>(friction.state_size()));
  out.resize(groups_.size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    out[g].resize(group.at.size());
    std::fill(z.begin(), z.end(), PackD(0));
    for (std::size_t k = 0; k < group.at.size(); ++k) {
      friction.torque<PackD>(parameters, {&group.at[k], 1}, z, {&out[g][k], 1});
      friction.step<PackD>(parameters, {&group.over[k], 1}, dt_, z);
    }
  }
}

void JointFrictionData::predict(const friction::RobotFriction& friction,
                                std::span<const double> theta,
                                std::vector<std::vector<PackD>>& out) const {
  std::vector<PackD> work;
  drive(friction, theta, out);
  for (std::vector<PackD>& group : out) low_pass_.apply(std::span<PackD>(group), work);
}

std::vector<double> JointFrictionData::promising_orders(
    const std::vector<std::vector<PackD>>& f, const std::vector<std::vector<PackD>>& filtered,
    const RippleGrid& grid) const {
  const auto count = static_cast<std::size_t>(grid.count);
  std::vector<PackD> sine(count, PackD(0)), cosine = sine, square = sine;
  PackD sum = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (std::size_t k = 0; k < f[g].size(); ++k)
      sum += groups_[g].weight[k] * (groups_[g].target[k] - filtered[g][k]);
  double mean = 0;
  for (int lane = 0; lane < kLanes; ++lane)
    mean += share_of_mean() * sum[lane] / std::max(1, rows_);

  std::vector<PackD> left, work;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    left.resize(f[g].size());
    for (std::size_t k = 0; k < left.size(); ++k)
      left[k] = group.weight[k] * (group.target[k] - filtered[g][k] - PackD(mean));
    low_pass_.apply(std::span<PackD>(left), work);
    for (std::size_t k = 0; k < left.size(); ++k) {
      // turns e^(i n q) from order to order
      const PackD q = group.at[k].q;
      const auto turn = sincos(PackD(grid.step) * q), start = sincos(PackD(grid.first) * q);
      PackD s = start.sin, c = start.cos;
      const PackD correlated = left[k] * f[g][k];
      const PackD size = group.weight[k] * f[g][k] * f[g][k];
      // (frequency of the wave over the cut-off)^2 is n^2 of this
      const PackD per_order = group.at[k].v * PackD(1 / (2 * std::numbers::pi * cutoff_hz_));
      const PackD slow = per_order * per_order;
      for (std::size_t i = 0; i < count; ++i) {
        const double n = grid.first + grid.step * static_cast<double>(i);
        const PackD x = PackD(n * n) * slow, x2 = x * x;
        const PackD gain = PackD(1) / (PackD(1) + x2 * x2);
        sine[i] += correlated * s;
        cosine[i] += correlated * c;
        square[i] += size * gain * gain;
        const PackD next = s * turn.cos + c * turn.sin;
        c = c * turn.cos - s * turn.sin;
        s = next;
      }
    }
  }
  std::vector<std::pair<double, double>> best;  // -explained, order
  for (std::size_t i = 0; i < count; ++i) {
    double a = 0, b = 0, size = 0;
    for (int lane = 0; lane < kLanes; ++lane)
      a += sine[i][lane], b += cosine[i][lane], size += square[i][lane];
    best.emplace_back(-(a * a + b * b) / std::max(size, 1e-300),
                      grid.first + grid.step * static_cast<double>(i));
  }
  const auto end = best.begin() + std::min<std::ptrdiff_t>(kPromising, std::ssize(best));
  std::partial_sort(best.begin(), end, best.end());
  std::vector<double> orders;
  for (auto it = best.begin(); it != end; ++it) orders.push_back(it->second);
  return orders;
}

RippleTerm JointFrictionData::strongest_ripple(const friction::RobotFriction& friction,
                                               std::span<const double> theta,
                                               const RippleGrid& grid) const {
  std::vector<std::vector<PackD>> f, filtered;
  drive(friction, theta, f);
  filtered = f;
  std::vector<PackD> work;
  for (std::vector<PackD>& group : filtered) low_pass_.apply(std::span<PackD>(group), work);

  RippleTerm best;
  best.mean_square = std::numeric_limits<double>::infinity();
  std::vector<PackD> sine, cosine;
  for (const double n : promising_orders(f, filtered, grid)) {
    // moments of (1, F[f sin nq], F[f cos nq], target - F[f]) over the used rows
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const Group& group = groups_[g];
      sine.resize(f[g].size());
      cosine.resize(f[g].size());
      for (std::size_t k = 0; k < f[g].size(); ++k) {
        const auto wave = sincos(PackD(n) * group.at[k].q);
        sine[k] = f[g][k] * wave.sin;
        cosine[k] = f[g][k] * wave.cos;
      }
      low_pass_.apply(std::span<PackD>(sine), work);
      low_pass_.apply(std::span<PackD>(cosine), work);
      PackD sum[4][4] = {};
      for (std::size_t k = 0; k < f[g].size(); ++k) {
        const PackD w = group.weight[k];
        const PackD row[4] = {w, w * sine[k], w * cosine[k],
                              w * (group.target[k] - filtered[g][k])};
        for (int a = 0; a < 4; ++a)
          for (int b = a; b < 4; ++b) sum[a][b] += row[a] * row[b];
      }
      for (int a = 0; a < 4; ++a)
        for (int b = a; b < 4; ++b)
          for (int lane = 0; lane < kLanes; ++lane) moments(a, b) += sum[a][b][lane];
    }
    moments /= std::max(1, rows_);
    moments(0, 0) += prior_.weight;
    moments.triangularView<Eigen::StrictlyLower>() = moments.transpose();
    const Eigen::Vector3d x =
        moments.topLeftCorner<3, 3>().ldlt().solve(moments.topRightCorner<3, 1>());
    const double left = moments(3, 3) - x.dot(moments.topRightCorner<3, 1>());
    if (left < best.mean_square)
      best = {n, std::hypot(x[1], x[2]), std::atan2(x[2], x[1]), std::max(0.0, left)};
  }
  return best;
}

void JointFrictionData::residual(const friction::RobotFriction& friction,
                                 std::span<const PackD> theta, int sequence,
                                 std::vector<PackD>& out, std::vector<PackD>& work) const {
  const Group& group = groups_[static_cast<std::size_t>(sequence / kLanes)];
  const int from = sequence % kLanes;
  const auto spread = [from](const friction::Input<PackD>& in) {
    return friction::Input<PackD>{PackD(in.q[from]), PackD(in.v[from]), PackD(in.load[from]),
                                  PackD(in.temperature[from])};
  };
  std::vector<PackD> z(static_cast<std::size_t>(friction.state_size()), PackD(0));
  out.resize(static_cast<std::size_t>(lengths_[static_cast<std::size_t>(sequence)]));
  for (std::size_t k = 0; k < out.size(); ++k) {
    const friction::Input<PackD> at = spread(group.at[k]), over = spread(group.over[k]);
    friction.torque<PackD>(theta, {&at, 1}, z, {&out[k], 1});
    friction.step<PackD>(theta, {&over, 1}, dt_, z);
  }
  low_pass_.apply(std::span<PackD>(out), work);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = PackD(group.weight[k][from]) * (out[k] - PackD(group.target[k][from]));
}

JointFrictionData::Linear JointFrictionData::linearise(
    const friction::RobotFriction& friction, std::span<const double> theta,
    std::span<const std::size_t> wanted, std::span<const std::vector<int>> row) const {
  // f and the columns of J, four at a time; the lanes are the sequences of a group
  constexpr std::size_t kColumns = 4;
  using Columns = fricid::Group<PackD, kColumns>;
  std::vector<std::vector<Columns>> x((wanted.size() + kColumns) / kColumns);
  const auto column = [&](std::size_t i, std::size_t k) -> PackD& {
    return x[i / kColumns][k].x[i % kColumns];
  };

  Eigen::Index rows = 0;
  for (const std::vector<int>& of_sequence : row) rows += std::ssize(of_sequence);
  Linear out{Eigen::VectorXd(rows), Eigen::MatrixXd(rows, std::ssize(wanted))};
  const std::vector<PackD> parameters(theta.begin(), theta.end());
  std::vector<PackD> z(static_cast<std::size_t>(friction.state_size())), z_bar(z.size()),
      by_theta(theta.size());
  std::vector<Columns> work;
  friction::Tangent tangent(friction);
  const PackD one(1);
  Eigen::Index begin = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    for (std::vector<Columns>& columns : x) columns.resize(group.at.size());
    std::fill(z.begin(), z.end(), PackD(0));
    tangent.reset();
    for (std::size_t k = 0; k < group.at.size(); ++k) {
      friction::Input<PackD> in_bar{};
      std::fill(z_bar.begin(), z_bar.end(), PackD(0));
      std::fill(by_theta.begin(), by_theta.end(), PackD(0));
      friction.torque<PackD>(parameters, {&group.at[k], 1}, z, {&column(0, k), 1});
      friction.torque_pullback<PackD>(parameters, {&group.at[k], 1}, z, {&one, 1}, by_theta,
                                      {&in_bar, 1}, z_bar);
      tangent.add(parameters, z_bar, by_theta);
      for (std::size_t i = 0; i < wanted.size(); ++i) column(i + 1, k) = by_theta[wanted[i]];
      tangent.step(parameters, {&group.over[k], 1}, dt_, z);
    }
    for (std::vector<Columns>& columns : x) low_pass_.apply(std::span<Columns>(columns), work);
    for (std::size_t s = g * kLanes; s < std::min(row.size(), (g + 1) * kLanes); ++s) {
      const auto pick = [&](std::size_t i, double* to) {
        for (const int k : row[s])
          *to++ = column(i, static_cast<std::size_t>(k))[static_cast<int>(s % kLanes)];
      };
      pick(0, out.f.data() + begin);
      for (std::size_t i = 0; i < wanted.size(); ++i)
        pick(i + 1, out.J.col(static_cast<Eigen::Index>(i)).data() + begin);
      begin += std::ssize(row[s]);
    }
  }
  return out;
}

JointFrictionData::Moments JointFrictionData::moments(const friction::RobotFriction& friction,
                                                      std::span<const double> theta) const {
  std::vector<std::vector<PackD>> predicted;
  predict(friction, theta, predicted);
  PackD sum = 0, square = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (std::size_t k = 0; k < predicted[g].size(); ++k) {
      const PackD e = groups_[g].weight[k] * (predicted[g][k] - groups_[g].target[k]);
      sum += e;
      square += e * e;
    }
  Moments out;
  for (int lane = 0; lane < kLanes; ++lane) {
    out.mean += sum[lane] / std::max(1, rows_);
    out.square += square[lane] / std::max(1, rows_);
  }
  return out;
}

double JointFrictionData::mean_square(const friction::RobotFriction& friction,
                                      std::span<const double> theta) const {
  const Moments e = moments(friction, theta);
  return std::isfinite(e.square) ? std::max(0.0, e.square - share_of_mean() * e.mean * e.mean)
                                 : std::numeric_limits<double>::infinity();
}

double JointFrictionData::offset(const friction::RobotFriction& friction,
                                 std::span<const double> theta) const {
  return -share_of_mean() * moments(friction, theta).mean;
}

Eigen::VectorXd JointFrictionData::predicted(const friction::RobotFriction& friction,
                                             std::span<const double> theta, int sequence) const {
  std::vector<std::vector<PackD>> all;
  predict(friction, theta, all);
  const auto group = static_cast<std::size_t>(sequence / kLanes);
  Eigen::VectorXd out(lengths_[static_cast<std::size_t>(sequence)]);
  for (Eigen::Index k = 0; k < out.size(); ++k)
    out[k] = all[group][static_cast<std::size_t>(k)][sequence % kLanes];
  return out;
}

}  // namespace fricid::estimate
