#include "fricid/signals/recording.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"

namespace fricid::signals {
namespace {

constexpr double kWidest = 0.4;           // of the sample rate
constexpr int kFrequencies = 1000;        // of the sum over the band
constexpr double kRest = 0.15;            // shortest rest [s]
constexpr double kNoiseRange = 6;         // standard deviations that noise spans
constexpr double kStepRange = 1.5;        // steps that a position spans which hardly moves
constexpr double kNormalMedian = 0.6745;  // median of |x|, x ~ N(0, 1)

// Bridges NaN by straight lines between neighbours (held at the ends).
void bridge(Eigen::Ref<Eigen::VectorXd> x) {
  const auto size = x.size();
  Eigen::Index last = -1;
  for (Eigen::Index k = 0; k < size; ++k) {
    if (std::isnan(x[k])) continue;
    for (Eigen::Index i = last + 1; i < k; ++i)
      x[i] = last < 0 ? x[k]
                      : x[last] + (x[k] - x[last]) * static_cast<double>(i - last) /
                                      static_cast<double>(k - last);
    last = k;
  }
  for (Eigen::Index i = last + 1; last >= 0 && i < size; ++i) x[i] = x[last];
}

// (q_{k+1} - q_{k-1}) / (2 dt), at the ends the slope of a parabola through three samples.
RowMatrix central_difference(const RowMatrix& q, double dt) {
  const Eigen::Index T = q.rows();
  RowMatrix v(T, q.cols());
  v.middleRows(1, T - 2) = (q.bottomRows(T - 2) - q.topRows(T - 2)) / (2 * dt);
  v.row(0) = (-3 * q.row(0) + 4 * q.row(1) - q.row(2)) / (2 * dt);
  v.row(T - 1) = (3 * q.row(T - 1) - 4 * q.row(T - 2) + q.row(T - 3)) / (2 * dt);
  return v;
}

// Second derivative per sample^2 of the parabola through the first `count` values of x(0), x(1),
// ..; 0 where it is within three standard errors.
template <class X>
double curvature_at_edge(const X& x, Eigen::Index count) {
  constexpr double kCertain = 3;
  Eigen::MatrixXd A(count, 3);
  Eigen::VectorXd y(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto at = static_cast<double>(k);
    A.row(k) << 1, at, at * at / 2;
    y[k] = x(k) - x(0);
  }
  const Eigen::Matrix3d H = A.transpose() * A;
  const Eigen::Vector3d fit = H.ldlt().solve(A.transpose() * y);
  const double variance = (y - A * fit).squaredNorm() / static_cast<double>(count - 3);
  const double error = std::sqrt(variance * H.ldlt().solve(Eigen::Vector3d::Unit(2))[2]);
  return std::abs(fit[2]) > kCertain * error ? fit[2] : 0;
}

// What bends a record at its ends: parabolas that fade within some periods of the filter, which
// passes them. A record that begins or ends in motion has no other curvature left there, where its
// odd reflection would turn the acceleration round and the filter take a mean of both.
Eigen::VectorXd bends_at_edges(const Eigen::VectorXd& x, double cutoff_hz, double rate_hz) {
  constexpr double kFade = 3;         // periods of the cut-off
  constexpr double kUnderflow = 746;  // exp(-746) = 0
  constexpr Eigen::Index kFewest = 8;
  const double period = rate_hz / cutoff_hz;
  const Eigen::Index T = x.size();
  const Eigen::Index count =
      std::clamp<Eigen::Index>(std::lround(period), kFewest, std::max(kFewest, T / 2));
  Eigen::VectorXd bends = Eigen::VectorXd::Zero(T);
  const auto add_parabola = [&](double a, auto&& from_edge) {
    if (a == 0) return;
    const auto faded = static_cast<Eigen::Index>(std::min(kUnderflow * kFade * period, 1e18));
    for (Eigen::Index k = 0; k < std::min(T, faded); ++k) {
      const auto at = static_cast<double>(k);
      from_edge[k] += a / 2 * at * at * std::exp(-at / (kFade * period));
    }
  };
  add_parabola(curvature_at_edge(x, count), bends);
  add_parabola(curvature_at_edge(x.reverse(), count), bends.reverse());
  return bends;
}

// A position through a filter.
Eigen::VectorXd low_passed(const Eigen::VectorXd& x, const ZeroPhaseButterworth& filter,
                           std::vector<double>& work) {
  const Eigen::VectorXd bends = bends_at_edges(x, filter.cutoff_hz(), filter.rate_hz());
  Eigen::VectorXd out = x - bends;
  filter.apply(std::span<double>(out.data(), static_cast<std::size_t>(out.size())), work);
  return out + bends;
}

// Share of the variance of white noise that a filter leaves.
double noise_share(const ZeroPhaseButterworth& filter) {
  double share = 0;
  for (int i = 0; i < kFrequencies; ++i) {
    const double gain = filter.gain((i + 0.5) / kFrequencies * filter.rate_hz() / 2);
    share += gain * gain / kFrequencies;
  }
  return share;
}

// Least step of each column; 0 of one that stands.
Eigen::VectorXd least_steps(const RowMatrix& q) {
  Eigen::VectorXd steps = Eigen::VectorXd::Zero(q.cols());
  for (Eigen::Index j = 0; j < q.cols(); ++j)
    for (Eigen::Index k = 1; k < q.rows(); ++k)
      if (const double step = std::abs(q(k, j) - q(k - 1, j)); step > 0)
        steps[j] = steps[j] > 0 ? std::min(steps[j], step) : step;
  return steps;
}

// Samples [begin, end).
struct Stretch {
  Eigen::Index begin, end;
};

// Stretches of kRest and longer over which a joint stays within what the noise of its encoder spans
// in the narrow band, or within a step to and fro, which no filter takes out.
std::vector<Stretch> rests_of(const Eigen::VectorXd& narrow_q, double noise_sd, double step,
                              const ZeroPhaseButterworth& low_pass) {
  const double range =
      std::max(kNoiseRange * std::sqrt(noise_share(low_pass)) * noise_sd, kStepRange * step);
  const auto shortest = static_cast<Eigen::Index>(std::ceil(kRest * low_pass.rate_hz()));
  // the longest stretch from each sample on, unless that from the sample before contains it
  std::vector<Stretch> stretches;
  std::deque<Eigen::Index> low, high;  // of the samples from begin to end, the extremes first
  const auto& q = narrow_q;
  for (Eigen::Index begin = 0, end = 0, last = 0; begin < q.size(); ++begin) {
    while (!low.empty() && low.front() < begin) low.pop_front();
    while (!high.empty() && high.front() < begin) high.pop_front();
    for (; end < q.size(); ++end) {
      const double lowest = low.empty() ? q[end] : std::min(q[low.front()], q[end]),
                   highest = high.empty() ? q[end] : std::max(q[high.front()], q[end]);
      if (highest - lowest > range) break;
      while (!low.empty() && q[low.back()] >= q[end]) low.pop_back();
      while (!high.empty() && q[high.back()] <= q[end]) high.pop_back();
      low.push_back(end);
      high.push_back(end);
    }
    if (end > last && end - begin >= shortest) stretches.push_back({begin, end});
    last = end;
  }
  // of those that overlap the longest
  std::ranges::stable_sort(stretches, std::greater(),
                           [](const Stretch& s) { return s.end - s.begin; });
  std::vector<char> taken(static_cast<std::size_t>(q.size()), 0);
  std::vector<Stretch> rests;
  for (Stretch s : stretches) {
    const auto is_taken = [&](Eigen::Index k) { return taken[static_cast<std::size_t>(k)] != 0; };
    while (s.begin < s.end && is_taken(s.begin)) ++s.begin;
    while (s.begin < s.end && is_taken(s.end - 1)) --s.end;
    if (s.end - s.begin < shortest) continue;
    std::fill(taken.begin() + s.begin, taken.begin() + s.end, 1);
    rests.push_back(s);
  }
  return rests;
}

// Makes q, of the joints of r, a straight line where a joint rests.
void straighten_rests(const Recording& r, const ZeroPhaseButterworth& low_pass, RowMatrix& q) {
  for (Eigen::Index j = 0; j < q.cols(); ++j)
    for (const auto& [begin, end] : rests_of(r.narrow.q.col(j), r.noise_sd[j], r.step[j], low_pass))
      q.col(j).segment(begin, end - begin) =
          Eigen::VectorXd::LinSpaced(end - begin, r.narrow.q(begin, j), r.narrow.q(end - 1, j));
}

// At the samples, what has the means x over two samples, weighted by a triangle: the solution y of
// (y_{k-1} + 10 y_k + y_{k+1}) / 12 = x_k (Numerov), y = x at the ends.
void take_out_means(Eigen::Ref<Eigen::VectorXd, 0, Eigen::InnerStride<>> x) {
  constexpr double kBeside = 1.0 / 12, kOwn = 10.0 / 12;
  const Eigen::Index T = x.size();
  std::vector<double> above(static_cast<std::size_t>(T), 0.0);
  for (Eigen::Index k = 1; k + 1 < T; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double pivot = kOwn - kBeside * above[i - 1];
    above[i] = kBeside / pivot;
    x[k] = (x[k] - kBeside * x[k - 1]) / pivot;
  }
  for (Eigen::Index k = T - 2; k > 0; --k) x[k] -= above[static_cast<std::size_t>(k)] * x[k + 1];
}

// Accelerations at the samples of a filtered motion, see `make_recording`.
RowMatrix accelerations(const RowMatrix& q, double dt) {
  const Eigen::Index T = q.rows();
  RowMatrix a(T, q.cols());
  a.middleRows(1, T - 2) =
      (q.bottomRows(T - 2) - 2 * q.middleRows(1, T - 2) + q.topRows(T - 2)) / (dt * dt);
  a.row(0) = a.row(1);
  a.row(T - 1) = a.row(T - 2);
  for (Eigen::Index j = 0; j < q.cols(); ++j) take_out_means(a.col(j));
  return a;
}

// Slopes at the samples, per sample, exact for polynomials of degree 4; near the ends those of
// parabolas.
Eigen::VectorXd slopes(const Eigen::VectorXd& x) {
  const Eigen::Index T = x.size();
  Eigen::VectorXd slope = central_difference(x, 1);
  slope.segment(2, T - 4) =
      (8 * (x.segment(3, T - 4) - x.segment(1, T - 4)) - x.tail(T - 4) + x.head(T - 4)) / 12;
  return slope;
}

// Standard deviation of white noise on each column of x (n), from the part that a filter removed.
Eigen::VectorXd noise_above_band(const RowMatrix& x, const RowMatrix& filtered,
                                 const ZeroPhaseButterworth& filter) {
  // white noise has this share of its variance above the band; the median is robust to reversals
  double share = 0;
  for (int i = 0; i < kFrequencies; ++i) {
    const double above = 1 - filter.gain((i + 0.5) / kFrequencies * filter.rate_hz() / 2);
    share += above * above / kFrequencies;
  }
  Eigen::VectorXd sd(x.cols());
  std::vector<double> residual;
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    residual.clear();
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      const double e = std::abs(x(k, j) - filtered(k, j));
      if (std::isfinite(e)) residual.push_back(e);
    }
    const auto middle = residual.begin() + std::ssize(residual) / 2;
    std::nth_element(residual.begin(), middle, residual.end());
    sd[j] = *middle / kNormalMedian / std::sqrt(share);
  }
  return sd;
}

}  // namespace

double wide_band(double cutoff_hz, double rate_hz) {
  return std::min(kWideBand * cutoff_hz, kWidest * rate_hz);
}

RowMatrix held_torque(ConstRowMatrix tau) {
  RowMatrix held = tau;
  for (Eigen::Index j = 0; j < held.cols(); ++j) {
    double last = 0;
    for (Eigen::Index k = 0; k < held.rows(); ++k)
      last = held(k, j) = std::isfinite(held(k, j)) ? held(k, j) : last;
  }
  return held;
}

void leave_out_run_in(Recording& r) {
  const RowMatrix& q = r.narrow.q;
  for (Eigen::Index j = 0; j < q.cols(); ++j)
    for (Eigen::Index k = 0; k < q.rows() && std::abs(q(k, j) - q(0, j)) < kWashout; ++k)
      r.use(k, j) = false;
}

Eigen::VectorXd resolution(const Recording& r) {
  return r.noise_sd.cwiseMax(r.step / std::sqrt(12.0));
}

UseMask at_rest(const Recording& r, double cutoff_hz) {
  const ZeroPhaseButterworth low_pass(cutoff_hz, 1 / r.dt);
  const auto near = static_cast<Eigen::Index>(std::ceil(1 / (cutoff_hz * r.dt)));
  const Eigen::VectorXd noise = resolution(r);
  UseMask rests = UseMask::Constant(r.length(), r.n(), false);
  for (Eigen::Index j = 0; j < rests.cols(); ++j)
    for (const auto& [begin, end] : rests_of(r.narrow.q.col(j), noise[j], r.step[j], low_pass)) {
      const Eigen::Index from = std::max<Eigen::Index>(0, begin - near),
                         to = std::min(rests.rows(), end + near);
      rests.col(j).segment(from, to - from).setConstant(true);
    }
  return rests;
}

Motion filtered_again(const Recording& recording, double cutoff_hz) {
  const double rate = 1 / recording.dt;
  const ZeroPhaseButterworth wide(wide_band(cutoff_hz, rate), rate);
  Motion out{.q = recording.wide.q, .v = {}, .a = {}};
  std::vector<double> work;
  for (Eigen::Index j = 0; j < out.q.cols(); ++j)
    out.q.col(j) = low_passed(recording.wide.q.col(j), wide, work);
  straighten_rests(recording, ZeroPhaseButterworth(cutoff_hz, rate), out.q);
  out.v = central_difference(out.q, recording.dt);
  return out;
}

Motion motion_of_noise(const Recording& recording, double cutoff_hz, std::uint64_t seed) {
  const ZeroPhaseButterworth narrow(cutoff_hz, 1 / recording.dt);
  const Eigen::VectorXd sd = resolution(recording);
  Motion out{.q = RowMatrix(recording.length(), recording.n()), .v = {}, .a = {}};
  Eigen::VectorXd draws(recording.length());
  for (int j = 0; j < recording.n(); ++j) {
    fill_normal(seed, static_cast<std::uint64_t>(j), 0,
                {draws.data(), static_cast<std::size_t>(draws.size())});
    out.q.col(j) = sd[j] * draws;
  }
  narrow.apply(out.q);
  out.v = central_difference(out.q, recording.dt);
  out.a = accelerations(out.q, recording.dt);
  return out;
}

Eigen::VectorXd between_samples(const Eigen::VectorXd& q, int factor) {
  if (factor == 1) return q;
  const Eigen::Index intervals = q.size() - 1;
  const Eigen::VectorXd slope = slopes(q);
  Eigen::VectorXd out(intervals * factor + 1);
  for (Eigen::Index k = 0; k < out.size(); ++k) {
    const Eigen::Index i = std::min(k / factor, intervals - 1);
    const double x = static_cast<double>(k - i * factor) / factor, y = 1 - x,
                 rise = q[i + 1] - q[i];
    out[k] = y * q[i] + x * q[i + 1] + x * y * (y * (slope[i] - rise) + x * (rise - slope[i + 1]));
  }
  return out;
}

std::vector<bool> beside_missing(const Dataset& log, double cutoff_hz) {
  const int T = log.length(), near = static_cast<int>(std::ceil(1 / (cutoff_hz * log.dt())));
  std::vector<bool> made_up(static_cast<std::size_t>(T), false);
  int from = 0;  // samples before are done
  for (int k = 0; k < T; ++k) {
    if (!log.q.row(k).hasNaN() && !log.tau.row(k).hasNaN()) continue;
    const int to = std::min(T, k + near + 1);
    for (int i = std::max(from, k - near); i < to; ++i) made_up[static_cast<std::size_t>(i)] = true;
    from = to;
  }
  return made_up;
}

Recording make_recording(Dataset log, double cutoff_hz) {
  const ZeroPhaseButterworth low_pass(cutoff_hz, log.rate_hz);
  const ZeroPhaseButterworth wide(wide_band(cutoff_hz, log.rate_hz), log.rate_hz);
  const int T = log.length(), n = log.n();
  const double dt = log.dt();
  if (T < 8 / (cutoff_hz * dt))
    throw UserError("{}: {} samples are shorter than {} s, the least a {} Hz filter needs",
                    log.name, T, 8 / cutoff_hz, cutoff_hz);

  Recording out;
  out.dt = dt;
  for (auto* signal : {&out.narrow.q, &out.wide.q, &out.filtered_tau}) signal->resize(T, n);
  out.temperature = log.temperature;
  if (out.temperature.size() == 0) out.temperature = RowMatrix::Constant(T, n, kRoomTemperature);

  std::vector<double> work;
  Eigen::VectorXd column(T);
  const auto filter = [&](const RowMatrix& signal, int j, const ZeroPhaseButterworth& by,
                          bool held) {
    column = signal.col(j);
    bridge(column);
    const std::string& joint = log.joint_names[static_cast<std::size_t>(j)];
    if (column.hasNaN()) throw UserError("{}: joint {}: no finite sample", log.name, joint);
    // Torque in force around t_k: mean of the values held before and after it.
    if (held)
      for (int k = T - 1; k > 0; --k) column[k] = 0.5 * (column[k - 1] + column[k]);
    if (held)
      by.apply(std::span<double>(column.data(), static_cast<std::size_t>(T)), work);
    else
      column = low_passed(column, by, work);
    if (!column.allFinite())
      throw UserError("{}: joint {}: numbers too large for a filter", log.name, joint);
    return column;
  };
  for (int j = 0; j < n; ++j) {
    out.narrow.q.col(j) = filter(log.q, j, low_pass, false);
    out.wide.q.col(j) = filter(log.q, j, wide, false);
    out.filtered_tau.col(j) = filter(log.tau, j, low_pass, true);
    column = out.temperature.col(j);
    bridge(column);
    out.temperature.col(j) = column;
  }

  out.noise_sd = noise_above_band(log.q, out.wide.q, wide);
  out.step = least_steps(log.q);
  straighten_rests(out, low_pass, out.wide.q);

  out.narrow.v = central_difference(out.narrow.q, dt);
  out.wide.v = central_difference(out.wide.q, dt);
  out.narrow.a = accelerations(out.narrow.q, dt);
  for (int j = 0; j < n; ++j) take_out_means(out.filtered_tau.col(j));

  const int edge = static_cast<int>(std::ceil(2 / (cutoff_hz * dt)));
  const std::vector<bool> made_up = beside_missing(log, cutoff_hz);
  out.use.setConstant(T, n, true);
  const auto skip = [&](int from, int to) {
    from = std::max(0, from);
    out.use.middleRows(from, std::max(0, std::min(T, to) - from)).setConstant(false);
  };
  skip(0, edge);
  skip(T - edge, T);
  for (int k = 0; k < T; ++k)
    if (made_up[static_cast<std::size_t>(k)]) skip(k, k + 1);
  leave_out_run_in(out);

  out.load = out.filtered_tau;
  out.held_tau = held_torque(log.tau);
  out.log = std::move(log);
  return out;
}

}  // namespace fricid::signals
