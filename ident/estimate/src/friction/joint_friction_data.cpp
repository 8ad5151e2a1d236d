#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

#include "fricid/base/group.hpp"
#include "fricid/base/math.hpp"
#include "fricid/estimate/friction/friction_fit.hpp"
#include "friction/drive_pieces.hpp"

namespace fricid::estimate {
namespace {

constexpr int kPromising = 2 * PackD::kLanes;  // orders of a grid that are looked at closely
constexpr double kLoadStep = 1e-4;             // of 1 N m and the load
constexpr double kLoadMargin = 2;              // by which a predicted load may err

using Columns = fricid::Group<PackD, 2>;  // filtered side by side

template <class T>
friction::Input<PackD> spread(const T& in) {
  return {PackD(in.q), PackD(in.v), PackD(in.load), PackD(in.temperature)};
}

void set_lane_of(friction::Input<PackD>& to, int lane, const friction::Input<double>& from) {
  to.q.set(lane, from.q);
  to.v.set(lane, from.v);
  to.load.set(lane, from.load);
  to.temperature.set(lane, from.temperature);
}

/// Rotates a wave by an angle.
template <class S>
void turn(SinCos<S>& wave, const SinCos<S>& by) {
  const S sine = wave.sin * by.cos + wave.cos * by.sin;
  wave.cos = wave.cos * by.cos - wave.sin * by.sin;
  wave.sin = sine;
}

}  // namespace

JointFrictionData::JointFrictionData(std::span<const signals::Recording> sequences,
                                     std::span<const RowMatrix> target, int joint, double cutoff_hz,
                                     const OffsetPrior& prior, std::span<const SampleRange> ranges,
                                     const FrictionDrive& how)
    : prior_(prior),
      dt_(sequences.front().dt),
      cutoff_hz_(cutoff_hz),
      blocks_(sequences, kBlock),
      steps_(how.steps),
      low_pass_(cutoff_hz, 1 / sequences.front().dt),
      decimated_(low_pass_, signals::decimation(sequences.front().dt, cutoff_hz)) {
  double sum = 0, square = 0;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  std::vector<std::vector<double>> q;
  std::vector<SampleRange> all;
  for (std::size_t i = 0; i < sequences.size(); ++i) {
    const signals::Recording& s = sequences[i];
    const signals::Motion& motion = how.motion.empty() ? s.wide : how.motion[i];
    const auto T = static_cast<std::size_t>(s.length());
    const Eigen::VectorXd path =
        signals::between_samples(Eigen::VectorXd(motion.q.col(joint)), steps_);
    Series& series = series_.emplace_back();
    series.range = ranges.empty() ? SampleRange{0, s.length()} : ranges[i];
    all.push_back(series.range);
    series.target.assign(T, 0);
    series.weight.assign(T, 0);
    for (int k = 0; k < s.length(); ++k) {
      const double at = motion.q(k, joint), load = s.load(k, joint),
                   temperature = s.temperature(k, joint);
      series.at.push_back({at, motion.v(k, joint), load, temperature});
      for (Eigen::Index step = k * steps_; step < (k + 1) * steps_; ++step) {
        const Eigen::Index last = path.size() - 1;
        const double from = path[std::min(step, last)], to = path[std::min(step + 1, last)];
        series.over.push_back({to, (to - from) / step_s(), load, temperature});
      }
      if (target.empty() || k < series.range.begin || k >= series.range.end || !s.use(k, joint))
        continue;
      const auto row = static_cast<std::size_t>(k);
      const double value = target[i](k, joint);
      series.target[row] = value;
      series.weight[row] = 1;
      ++rows_;
      sum += value;
      square += value * value;
      lowest = std::min(lowest, at);
      highest = std::max(highest, at);
      largest_target_ = std::max(largest_target_, std::abs(value));
    }
    q.emplace_back();
    for (const friction::Input<double>& in : series.at) q.back().push_back(in.q);
  }
  run_in_ = run_in(q, all);
  groups_ = side_by_side(cut_motion(q, all, dt_, PackD::kLanes, decimated_.every()));
  travel_ = std::max(0.0, highest - lowest);
  target_mean_square_ = rows_ > 0 ? square / rows_ - std::pow(sum / rows_, 2) : 0;
}

std::vector<JointFrictionData::Group> JointFrictionData::side_by_side(
    std::span<const MotionPiece> pieces) const {
  std::vector<Group> groups;
  for (std::size_t first = 0; first < pieces.size(); first += PackD::kLanes) {
    const auto own =
        pieces.subspan(first, std::min<std::size_t>(PackD::kLanes, pieces.size() - first));
    Group& group = groups.emplace_back();
    group.pieces.assign(own.begin(), own.end());
    int longest = 0;
    for (const MotionPiece& piece : own) longest = std::max(longest, piece.end - piece.start);
    group.at.resize(static_cast<std::size_t>(longest));
    const auto steps = static_cast<std::size_t>(steps_);
    group.over.resize(group.at.size() * steps);
    for (int lane = 0; lane < PackD::kLanes; ++lane) {
      // empty lanes repeat the first piece; a lane stands still after the end of its piece
      const MotionPiece& piece = own[static_cast<std::size_t>(lane) < own.size() ? lane : 0];
      const Series& series = series_[static_cast<std::size_t>(piece.sequence)];
      for (int k = 0; k < longest; ++k) {
        const int sample = piece.start + k;
        const bool moves = sample < piece.end;
        const auto row = static_cast<std::size_t>(std::min(sample, piece.end - 1)),
                   to = static_cast<std::size_t>(k);
        friction::Input<double> at = series.at[row];
        if (!moves) at.v = 0;
        set_lane_of(group.at[to], lane, at);
        std::size_t step = to * steps;
        for (friction::Input<double> over : over_sample(series.over, row)) {
          if (!moves) over.v = 0;
          set_lane_of(group.over[step++], lane, over);
        }
      }
    }
  }
  return groups;
}

PerSample JointFrictionData::unfiltered(const friction::RobotFriction& friction,
                                        std::span<const double> theta) const {
  struct {
    const friction::RobotFriction& friction;
    std::vector<PackD> theta;
    double dt;
    PerSample f;
    PackD now;
    void reset() {}
    void torque(const friction::Input<PackD>& in, std::span<const PackD> z,
                std::span<const LaneSample> lanes) {
      friction.torque<PackD>(theta, {&in, 1}, z, {&now, 1});
      for (const auto& [lane, sequence, sample] : lanes) f[sequence][sample] = now[lane];
    }
    void step(std::span<const friction::Input<PackD>> over, std::span<PackD> z) {
      for (const friction::Input<PackD>& in : over) friction.step<PackD>(theta, {&in, 1}, dt, z);
    }
  } driver{friction, {theta.begin(), theta.end()}, step_s(), {}, {}};
  for (const Series& series : series_) driver.f.emplace_back(series.at.size(), 0.0);
  drive(friction, theta, driver);
  return std::move(driver.f);
}

double JointFrictionData::load_gain(const friction::RobotFriction& friction,
                                    std::span<const double> theta) const {
  struct {
    const friction::RobotFriction& friction;
    std::vector<PackD> theta;
    double dt, largest;
    PackD now;
    void reset() {}
    void torque(friction::Input<PackD> in, std::span<const PackD> z,
                std::span<const LaneSample> lanes) {
      PackD further;
      in.load *= PackD(kLoadMargin);
      friction.torque<PackD>(theta, {&in, 1}, z, {&now, 1});
      const PackD h = PackD(kLoadStep) * (PackD(1) + abs(in.load));
      in.load += h;
      friction.torque<PackD>(theta, {&in, 1}, z, {&further, 1});
      const PackD gain = abs((further - now) / h);
      for (const LaneSample& at : lanes) largest = std::max(largest, gain[at.lane]);
    }
    void step(std::span<const friction::Input<PackD>> over, std::span<PackD> z) {
      for (const friction::Input<PackD>& in : over) friction.step<PackD>(theta, {&in, 1}, dt, z);
    }
  } driver{friction, {theta.begin(), theta.end()}, step_s(), 0, {}};
  drive(friction, theta, driver);
  return driver.largest;
}

/// Ranges of equal length go through the filter side by side.
void JointFrictionData::low_pass(PerSample& x) const {
  std::vector<PackD> packs, work;
  std::vector<double> alone;
  const auto of = [&](std::size_t s) {
    const SampleRange& range = series_[s].range;
    return std::span(x[s]).subspan(static_cast<std::size_t>(range.begin),
                                   static_cast<std::size_t>(range.size()));
  };
  for (std::size_t first = 0, last; first < x.size(); first = last) {
    const std::size_t size = of(first).size();
    for (last = first + 1; last < std::min(x.size(), first + PackD::kLanes); ++last)
      if (of(last).size() != size) break;
    if (last == first + 1) {
      low_pass_.apply(of(first), alone);
      continue;
    }
    packs.assign(size, PackD(0));
    for (std::size_t s = first; s < last; ++s)
      for (std::size_t k = 0; k < size; ++k) packs[k].set(static_cast<int>(s - first), of(s)[k]);
    low_pass_.apply(std::span(packs), work);
    for (std::size_t s = first; s < last; ++s)
      for (std::size_t k = 0; k < size; ++k) of(s)[k] = packs[k][static_cast<int>(s - first)];
  }
}

PerSample JointFrictionData::predict(const friction::RobotFriction& friction,
                                     std::span<const double> theta) const {
  PerSample f = unfiltered(friction, theta);
  low_pass(f);
  return f;
}

std::vector<double> JointFrictionData::promising_orders(const PerSample& f,
                                                        const PerSample& filtered,
                                                        const RippleGrid& grid) const {
  const auto count = static_cast<std::size_t>(grid.count);
  std::vector<PackD> sine(count, PackD(0)), cosine = sine, square = sine;
  double mean = 0;
  for (std::size_t s = 0; s < series_.size(); ++s)
    for (std::size_t k = 0; k < f[s].size(); ++k)
      mean += share_of_mean() / std::max(1, rows_) * series_[s].weight[k] *
              (series_[s].target[k] - filtered[s][k]);

  PerSample left;
  for (std::size_t s = 0; s < series_.size(); ++s) {
    left.emplace_back(f[s].size());
    for (std::size_t k = 0; k < f[s].size(); ++k)
      left[s][k] = series_[s].weight[k] * (series_[s].target[k] - filtered[s][k] - mean);
  }
  low_pass(left);
  for (std::size_t s = 0; s < series_.size(); ++s) {
    const Series& series = series_[s];
    for (int first = series.range.begin; first < series.range.end; first += PackD::kLanes) {
      PackD q(0), v(0), correlated(0), size(0);  // of eight samples; none beyond the end
      for (int lane = 0; lane < std::min(PackD::kLanes, series.range.end - first); ++lane) {
        const auto k = static_cast<std::size_t>(first + lane);
        q.set(lane, series.at[k].q);
        v.set(lane, series.at[k].v);
        correlated.set(lane, left[s][k] * f[s][k]);
        size.set(lane, series.weight[k] * f[s][k] * f[s][k]);
      }
      // turns e^(i n q) from order to order
      SinCos<PackD> wave = sincos(PackD(grid.first) * q);
      const SinCos<PackD> between = sincos(PackD(grid.step) * q);
      // (frequency of the wave over the cut-off)^2 is n^2 of this
      const PackD per_order = v * PackD(1 / (2 * std::numbers::pi * cutoff_hz_));
      const PackD slow = per_order * per_order;
      for (std::size_t i = 0; i < count; ++i) {
        const double n = grid.first + grid.step * static_cast<double>(i);
        const PackD x = PackD(n * n) * slow, x2 = x * x;
        const PackD gain = PackD(1) / (PackD(1) + x2 * x2);
        sine[i] += correlated * wave.sin;
        cosine[i] += correlated * wave.cos;
        square[i] += size * gain * gain;
        turn(wave, between);
      }
    }
  }
  std::vector<std::pair<double, double>> best;  // -explained, order
  for (std::size_t i = 0; i < count; ++i) {
    double a = 0, b = 0, size = 0;
    for (int lane = 0; lane < PackD::kLanes; ++lane)
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
  const PerSample f = unfiltered(friction, theta);
  PerSample filtered = f;
  low_pass(filtered);
  std::vector<double> orders = promising_orders(f, filtered, grid);
  orders.resize(kPromising, orders.front());

  // per order, in lanes, moments of (1, F[f sin nq], F[f cos nq], target - F[f]) over the used rows
  Columns n, sum[4][4] = {};
  for (std::size_t i = 0; i < orders.size(); ++i)
    n.x[i / PackD::kLanes].set(static_cast<int>(i % PackD::kLanes), orders[i]);
  std::vector<Columns> sine, cosine, work;
  for (std::size_t s = 0; s < series_.size(); ++s) {
    const Series& series = series_[s];
    const auto begin = static_cast<std::size_t>(series.range.begin);
    sine.resize(static_cast<std::size_t>(series.range.size()));
    cosine.resize(sine.size());
    for (std::size_t k = 0; k < sine.size(); ++k)
      for (int half = 0; half < 2; ++half) {
        const SinCos<PackD> wave = sincos(n.x[half] * PackD(series.at[begin + k].q));
        sine[k].x[half] = PackD(f[s][begin + k]) * wave.sin;
        cosine[k].x[half] = PackD(f[s][begin + k]) * wave.cos;
      }
    low_pass_.apply(std::span(sine), work);
    low_pass_.apply(std::span(cosine), work);
    for (std::size_t k = 0; k < sine.size(); ++k) {
      if (series.weight[begin + k] == 0) continue;
      const Columns row[4] = {Columns(1), sine[k], cosine[k],
                              Columns(series.target[begin + k] - filtered[s][begin + k])};
      for (int a = 0; a < 4; ++a)
        for (int b = a; b < 4; ++b) sum[a][b] = sum[a][b] + row[a] * row[b];
    }
  }
  RippleTerm best;
  best.mean_square = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < orders.size(); ++i) {
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
    for (int a = 0; a < 4; ++a)
      for (int b = a; b < 4; ++b)
        moments(a, b) = sum[a][b].x[i / PackD::kLanes][static_cast<int>(i % PackD::kLanes)];
    moments /= std::max(1, rows_);
    moments(0, 0) += prior_.weight;
    moments.triangularView<Eigen::StrictlyLower>() = moments.transpose();
    const Eigen::Vector3d x =
        moments.topLeftCorner<3, 3>().ldlt().solve(moments.topRightCorner<3, 1>());
    const double left = moments(3, 3) - x.dot(moments.topRightCorner<3, 1>());
    if (left < best.mean_square)
      best = {orders[i], std::hypot(x[1], x[2]), std::atan2(x[2], x[1]), std::max(0.0, left)};
  }
  return best;
}

std::vector<std::vector<int>> JointFrictionData::used_rows() const {
  std::vector<std::vector<int>> rows;
  for (const Series& series : series_) {
    rows.emplace_back();
    for (int k = 0; k < std::ssize(series.weight); ++k)
      if (series.weight[static_cast<std::size_t>(k)] > 0) rows.back().push_back(k);
  }
  return rows;
}

void JointFrictionData::residual(const friction::RobotFriction& friction,
                                 std::span<const PackD> theta, int sequence,
                                 std::vector<PackD>& out, std::vector<PackD>& work) const {
  const Series& series = series_[static_cast<std::size_t>(sequence)];
  std::vector<PackD> z(static_cast<std::size_t>(friction.state_size()), PackD(0));
  out.assign(series.at.size(), PackD(0));
  const auto begin = static_cast<std::size_t>(series.range.begin),
             end = static_cast<std::size_t>(series.range.end);
  for (std::size_t k = 0; k < end; ++k) {
    const friction::Input<PackD> at = spread(series.at[k]);
    if (k >= begin) friction.torque<PackD>(theta, {&at, 1}, z, {&out[k], 1});
    for (const friction::Input<double>& in : over_sample(series.over, k)) {
      const friction::Input<PackD> over = spread(in);
      friction.step<PackD>(theta, {&over, 1}, step_s(), z);
    }
  }
  low_pass_.apply(std::span(out).subspan(begin, end - begin), work);
  for (std::size_t k = begin; k < end; ++k)
    out[k] = PackD(series.weight[k]) * (out[k] - PackD(series.target[k]));
}

JointFrictionData::Moments JointFrictionData::moments(const friction::RobotFriction& friction,
                                                      std::span<const double> theta) const {
  const PerSample f = predict(friction, theta);
  Moments out;
  for (std::size_t s = 0; s < f.size(); ++s)
    for (std::size_t k = 0; k < f[s].size(); ++k) {
      const double e = series_[s].weight[k] * (f[s][k] - series_[s].target[k]);
      out.mean += e;
      out.square += e * e;
    }
  out.mean /= std::max(1, rows_);
  out.square /= std::max(1, rows_);
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

}  // namespace fricid::estimate
