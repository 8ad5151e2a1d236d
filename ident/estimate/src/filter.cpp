#include "fricid/estimate/filter.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "fricid/base/error.hpp"
#include "fricid/base/pack.hpp"

namespace fricid::estimate {
namespace {

constexpr double kWidest = 0.4;       // of the sample rate
constexpr double kForgotten = 1e-15;  // share of a start-up transient left after the padding
constexpr double kRoomTemperature = 293.15;

// Bridges NaN by straight lines between neighbours (held at the ends); marks them in `missing`.
void bridge(Eigen::Ref<Eigen::VectorXd> x, std::vector<std::uint8_t>& missing) {
  const auto size = x.size();
  Eigen::Index last = -1;
  for (Eigen::Index k = 0; k < size; ++k) {
    if (std::isnan(x[k])) {
      missing[static_cast<std::size_t>(k)] = 1;
      continue;
    }
    for (Eigen::Index i = last + 1; i < k; ++i)
      x[i] = last < 0 ? x[k]
                      : x[last] + (x[k] - x[last]) * static_cast<double>(i - last) /
                                      static_cast<double>(k - last);
    last = k;
  }
  for (Eigen::Index i = last + 1; last >= 0 && i < size; ++i) x[i] = x[last];
}

// (q_{k+1} - q_{k-1}) / (2 dt); the end rows, never used, repeat their neighbours.
data::RowMatrix central_difference(const data::RowMatrix& q, double dt) {
  const Eigen::Index T = q.rows();
  data::RowMatrix v(T, q.cols());
  v.middleRows(1, T - 2) = (q.bottomRows(T - 2) - q.topRows(T - 2)) / (2 * dt);
  v.row(0) = v.row(1);
  v.row(T - 1) = v.row(T - 2);
  return v;
}

}  // namespace

ZeroPhaseButterworth::ZeroPhaseButterworth(double cutoff_hz, double rate_hz) : rate_hz_(rate_hz) {
  if (!(cutoff_hz > 0 && cutoff_hz < rate_hz / 2))
    throw UserError("cut-off frequency = {} Hz is outside (0, {}) for a log at {} Hz", cutoff_hz,
                    rate_hz / 2, rate_hz);
  const double w = std::tan(std::numbers::pi * cutoff_hz / rate_hz);
  warped_cutoff_ = w;
  double slowest = 0;
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    // One pole pair at angle pi (2 i + 1) / 8 from the imaginary axis.
    const double damping = 2 * std::sin(std::numbers::pi * (2.0 * static_cast<double>(i) + 1) / 8);
    const double scale = 1 / (1 + damping * w + w * w);
    sections_[i] = {w * w * scale, 2 * w * w * scale, w * w * scale, 2 * (w * w - 1) * scale,
                    (1 - damping * w + w * w) * scale};
    slowest = std::max(slowest, std::sqrt(sections_[i].a2));
  }
  padding_ = static_cast<int>(std::ceil(std::log(kForgotten) / std::log(slowest)));
}

template <class S>
void ZeroPhaseButterworth::run(std::span<S> x) const {
  const auto [f, g] = sections_;
  // Transposed direct form II, both sections in steady state at the first value.
  const S x0 = x.front();
  S f1 = S(1 - f.b0) * x0, f2 = S(f.b2 - f.a2) * x0;
  S g1 = S(1 - g.b0) * x0, g2 = S(g.b2 - g.a2) * x0;
  for (S& value : x) {
    const S u = value;
    const S y = S(f.b0) * u + f1;
    f1 = S(f.b1) * u - S(f.a1) * y + f2;
    f2 = S(f.b2) * u - S(f.a2) * y;
    const S w = S(g.b0) * y + g1;
    g1 = S(g.b1) * y - S(g.a1) * w + g2;
    g2 = S(g.b2) * y - S(g.a2) * w;
    value = w;
  }
}

template <class S>
void ZeroPhaseButterworth::apply(std::span<S> x, std::vector<S>& work) const {
  const auto size = x.size();
  if (size < 2) return;
  const auto pad = std::min(size - 1, static_cast<std::size_t>(padding_));
  work.resize(size + 2 * pad);
  for (std::size_t i = 0; i < pad; ++i) {
    work[i] = S(2) * x.front() - x[pad - i];
    work[pad + size + i] = S(2) * x.back() - x[size - 2 - i];
  }
  std::copy(x.begin(), x.end(), work.begin() + static_cast<std::ptrdiff_t>(pad));
  run(std::span<S>(work));
  std::reverse(work.begin(), work.end());
  run(std::span<S>(work));
  for (std::size_t i = 0; i < size; ++i) x[i] = work[pad + size - 1 - i];
}

template void ZeroPhaseButterworth::apply(std::span<double>, std::vector<double>&) const;
template void ZeroPhaseButterworth::apply(std::span<PackD>, std::vector<PackD>&) const;

double ZeroPhaseButterworth::gain(double frequency_hz) const {
  const double ratio = std::tan(std::numbers::pi * frequency_hz / rate_hz_) / warped_cutoff_;
  return 1 / (1 + std::pow(ratio, 8));
}

int decimation(double dt, double cutoff_hz) {
  return std::max(1, static_cast<int>(std::floor(1 / (2 * cutoff_hz * dt))));
}

double wide_band(double cutoff_hz, double rate_hz) {
  return std::min(kWideBand * cutoff_hz, kWidest * rate_hz);
}

Filtered filter_dataset(const data::Dataset& dataset, double cutoff_hz) {
  const ZeroPhaseButterworth low_pass(cutoff_hz, dataset.rate_hz);
  const ZeroPhaseButterworth wide(wide_band(cutoff_hz, dataset.rate_hz), dataset.rate_hz);
  const int T = dataset.length(), n = dataset.n();
  const double dt = dataset.dt();
  if (T < 8 / (cutoff_hz * dt))
    throw UserError("{}: {} samples are shorter than {} s, the least a {} Hz filter needs",
                    dataset.name, T, 8 / cutoff_hz, cutoff_hz);

  Filtered out;
  out.name = dataset.name;
  out.dt = dt;
  out.t = dataset.t;
  for (auto* signal : {&out.q, &out.q_wide, &out.tau, &out.a}) signal->resize(T, n);
  out.temperature = dataset.temperature;
  if (out.temperature.size() == 0)
    out.temperature = data::RowMatrix::Constant(T, n, kRoomTemperature);

  std::vector<std::uint8_t> missing(static_cast<std::size_t>(T), 0);
  std::vector<double> work;
  Eigen::VectorXd column(T);
  const auto filter = [&](const data::RowMatrix& signal, int j, const ZeroPhaseButterworth& by,
                          bool held) {
    column = signal.col(j);
    bridge(column, missing);
    if (column.hasNaN())
      throw UserError("{}: joint {}: no finite sample", dataset.name,
                      dataset.joint_names[static_cast<std::size_t>(j)]);
    // Torque in force around t_k: mean of the values held before and after it.
    if (held)
      for (int k = T - 1; k > 0; --k) column[k] = 0.5 * (column[k - 1] + column[k]);
    by.apply(std::span<double>(column.data(), static_cast<std::size_t>(T)), work);
    return column;
  };
  for (int j = 0; j < n; ++j) {
    out.q.col(j) = filter(dataset.q, j, low_pass, false);
    out.q_wide.col(j) = filter(dataset.q, j, wide, false);
    out.tau.col(j) = filter(dataset.tau, j, low_pass, true);
    column = out.temperature.col(j);
    std::vector<std::uint8_t> ignored(static_cast<std::size_t>(T), 0);
    bridge(column, ignored);
    out.temperature.col(j) = column;
  }

  out.v = central_difference(out.q, dt);
  out.v_wide = central_difference(out.q_wide, dt);
  out.a.middleRows(1, T - 2) =
      (out.q.bottomRows(T - 2) - 2 * out.q.middleRows(1, T - 2) + out.q.topRows(T - 2)) / (dt * dt);
  out.a.row(0) = out.a.row(1);
  out.a.row(T - 1) = out.a.row(T - 2);

  const int edge = static_cast<int>(std::ceil(2 / (cutoff_hz * dt)));
  const int near = static_cast<int>(std::ceil(1 / (cutoff_hz * dt)));
  out.use.setConstant(T, n, true);
  const auto skip = [&](int from, int to) {
    from = std::max(0, from);
    out.use.middleRows(from, std::max(0, std::min(T, to) - from)).setConstant(false);
  };
  skip(0, edge);
  skip(T - edge, T);
  for (int k = 0; k < T; ++k)
    if (missing[static_cast<std::size_t>(k)]) skip(k - near, k + near + 1);
  for (int j = 0; j < n; ++j)
    for (int k = 0; k < T && std::abs(out.q(k, j) - out.q(0, j)) < kWashout; ++k)
      out.use(k, j) = false;
  return out;
}

}  // namespace fricid::estimate
