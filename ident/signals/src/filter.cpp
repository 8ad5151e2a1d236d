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

ZeroPhaseButterworth::ZeroPhaseButterworth(double cutoff_hz, double rate_hz)
    : rate_hz_(rate_hz), cutoff_hz_(cutoff_hz) {
  if (!(cutoff_hz > 0 && cutoff_hz < rate_hz / 2))
    throw UserError(
        "identify.cutoff_hz = {:g}; allowed for a log at {:.4g} Hz: above 0 and below {:.4g} Hz, "
        "as "
        "{:.2g}",
        cutoff_hz, rate_hz, rate_hz / 2, rate_hz / 4);
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

/// Both sections one after the other, in transposed direct form II.
template <class S>
class ZeroPhaseButterworth::Cascade {
 public:
  /// In steady state at the value x0.
  Cascade(const std::array<Section, 2>& sections, S x0)
      : f_(sections[0]),
        g_(sections[1]),
        f1_(S(1 - f_.b0) * x0),
        f2_(S(f_.b2 - f_.a2) * x0),
        g1_(S(1 - g_.b0) * x0),
        g2_(S(g_.b2 - g_.a2) * x0) {}

  S operator()(S u) {
    const S y = S(f_.b0) * u + f1_;
    f1_ = S(f_.b1) * u - S(f_.a1) * y + f2_;
    f2_ = S(f_.b2) * u - S(f_.a2) * y;
    const S w = S(g_.b0) * y + g1_;
    g1_ = S(g_.b1) * y - S(g_.a1) * w + g2_;
    g2_ = S(g_.b2) * y - S(g_.a2) * w;
    return w;
  }

 private:
  Section f_, g_;
  S f1_, f2_, g1_, g2_;
};

template <class S>
void ZeroPhaseButterworth::apply(std::span<S> x, std::vector<S>& work) const {
  const std::size_t size = x.size();
  if (size < 2) return;
  const std::size_t pad = std::min(size - 1, static_cast<std::size_t>(padding_));
  // forwards over the reflection before the record, the record, and the reflection after it
  work.resize(size + pad);
  const S first = S(2) * x.front(), last = S(2) * x.back();
  Cascade<S> forwards(sections_, first - x[pad]);
  for (std::size_t i = pad; i > 0; --i) forwards(first - x[i]);
  for (std::size_t i = 0; i < size; ++i) work[i] = forwards(x[i]);
  for (std::size_t i = 0; i < pad; ++i) work[size + i] = forwards(last - x[size - 2 - i]);
  Cascade<S> backwards(sections_, work.back());
  for (std::size_t i = size + pad; i > size; --i) backwards(work[i - 1]);
  for (std::size_t i = size; i > 0; --i) x[i - 1] = backwards(work[i - 1]);
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
template void ZeroPhaseButterworth::apply(std::span<Group<PackD, 2>>,
                                          std::vector<Group<PackD, 2>>&) const;

double ZeroPhaseButterworth::gain(double frequency_hz) const {
  const double ratio = std::tan(std::numbers::pi * frequency_hz / rate_hz_) / warped_cutoff_;
  return 1 / (1 + std::pow(ratio, 8));
}

/// Residues of H(z) H(1/z) z^(d-1) inside the unit circle: at the poles of H and, for d = 0, at 0.
ZeroPhaseButterworth::Exponentials ZeroPhaseButterworth::exponentials() const {
  using Complex = std::complex<double>;
  Exponentials g{{}, {}, 1};
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const Section& of = sections_[i];
    g.pole[i] = {-of.a1 / 2, std::sqrt(of.a2 - of.a1 * of.a1 / 4)};
    g.direct *= of.b0 * of.b2 / of.a2;
  }
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const Complex p = g.pole[i];
    Complex residue = 1.0 / (p * (p - std::conj(p)));
    for (std::size_t k = 0; k < sections_.size(); ++k) {
      const Section& of = sections_[k];
      residue *= of.b0 * p * p + of.b1 * p + of.b2;
      residue *= (of.b0 + of.b1 * p + of.b2 * p * p) / (1.0 + of.a1 * p + of.a2 * p * p);
      if (k != i) residue /= (p - g.pole[k]) * (p - std::conj(g.pole[k]));
    }
    g.gain[i] = 2.0 * residue;
  }
  return g;
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
