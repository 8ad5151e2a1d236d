#include "fricid/signals/filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fricid/base/error.hpp"
#include "fricid/base/group.hpp"
#include "fricid/base/pack.hpp"

namespace fricid::signals {
namespace {

constexpr double kForgotten =
    1e-15;  // share of a start-up transient that remains after the padding

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

void ZeroPhaseButterworth::apply(RowMatrix& x) const {
  std::vector<double> work;
  Eigen::VectorXd column;
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    column = x.col(j);
    apply(std::span<double>(column.data(), static_cast<std::size_t>(column.size())), work);
    x.col(j) = column;
  }
}

template void ZeroPhaseButterworth::apply(std::span<double>, std::vector<double>&) const;
template void ZeroPhaseButterworth::apply(std::span<PackD>, std::vector<PackD>&) const;
template void ZeroPhaseButterworth::apply(std::span<Group<PackD, 4>>,
                                          std::vector<Group<PackD, 4>>&) const;

double ZeroPhaseButterworth::gain(double frequency_hz) const {
  const double ratio = std::tan(std::numbers::pi * frequency_hz / rate_hz_) / warped_cutoff_;
  return 1 / (1 + std::pow(ratio, 8));
}

int decimation(double dt, double cutoff_hz) {
  return std::max(1, static_cast<int>(std::floor(1 / (2 * cutoff_hz * dt))));
}

std::vector<double> impulse_response(const ZeroPhaseButterworth& filter) {
  constexpr double kLeft = 0.01;
  const int reach = filter.padding();
  std::vector<double> x(static_cast<std::size_t>(2 * reach + 1), 0.0), work;
  x[static_cast<std::size_t>(reach)] = 1;
  filter.apply(std::span<double>(x), work);
  std::vector<double> g(x.begin() + reach, x.end());
  double sum = 0;
  for (const double value : g) sum += std::abs(value);
  double left = 0;
  while (g.size() > 1 && left + std::abs(g.back()) < kLeft * sum) {
    left += std::abs(g.back());
    g.pop_back();
  }
  double total = g[0];
  for (std::size_t k = 1; k < g.size(); ++k) total += 2 * g[k];
  for (double& value : g) value /= total;
  return g;
}

}  // namespace fricid::signals
