#include "fricid/signals/decimated_low_pass.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/math.hpp"

namespace fricid::signals {
namespace {

/// A complex number of packs.
template <class S>
struct Wave {
  S re, im;

  friend Wave operator+(Wave a, Wave b) { return {a.re + b.re, a.im + b.im}; }
  friend Wave operator-(Wave a, Wave b) { return {a.re - b.re, a.im - b.im}; }
  friend Wave operator*(std::complex<double> a, Wave b) {
    const S re(a.real()), im(a.imag());
    return {fma(re, b.re, -im * b.im), fma(re, b.im, im * b.re)};
  }
};

template <class S>
Wave<S> real(S x) {
  return {x, S(0)};
}

}  // namespace

DecimatedLowPass::DecimatedLowPass(const ZeroPhaseButterworth& filter, int every)
    : every_(every), padding_(filter.padding()) {
  const ZeroPhaseButterworth::Exponentials g = filter.exponentials();
  pole_ = g.pole;
  gain_ = g.gain;
  direct_ = g.direct;
  for (int o = 0; o < every; ++o) {
    std::array<double, kWeighted>& weights = weights_.emplace_back();
    for (std::size_t i = 0; i < 2; ++i) {
      const Complex forwards = std::pow(pole_[i], every - 1 - o), backwards = std::pow(pole_[i], o);
      weights[2 * i] = forwards.real();
      weights[2 * i + 1] = forwards.imag();
      weights[4 + 2 * i] = backwards.real();
      weights[5 + 2 * i] = backwards.imag();
    }
  }
}

template <class S>
void DecimatedLowPass::apply(const Record<S>& record, std::span<S> y) const {
  const auto count = std::ssize(record.sums);
  const auto sum = [&](std::ptrdiff_t b, std::size_t at) {
    const Sums<S>& of = record.sums[static_cast<std::size_t>(b)];
    return Wave<S>{of[at], of[at + 1]};
  };
  const int before = record.begin % every_, after = (record.end - 1) % every_;
  const std::ptrdiff_t remembered = std::min<std::ptrdiff_t>(count, padding_ / every_ + 2);
  std::array<Complex, 2> over_block, to_end, to_begin;
  for (std::size_t i = 0; i < 2; ++i) {
    over_block[i] = std::pow(pole_[i], every_);
    to_end[i] = std::pow(pole_[i], after + 1 - every_);
    to_begin[i] = std::pow(pole_[i], -before);
  }
  // of the odd reflection of a record about its value x at an end, 2 x - .., next to which the
  // record itself sums up to `inside`
  const auto reflection = [&](std::size_t i, S x, Wave<S> inside) {
    const Complex p = pole_[i];
    return (2.0 / (1.0 - p)) * real(x) - (1.0 / p) * (inside - real(x));
  };

  // the two poles side by side: each waits for its own last product
  std::array<Wave<S>, 2> s{real(S(0)), real(S(0))}, a;
  for (std::ptrdiff_t b = count - remembered; b < count; ++b)
    for (std::size_t i = 0; i < 2; ++i) s[i] = over_block[i] * s[i] + sum(b, 2 * i);
  for (std::size_t i = 0; i < 2; ++i)
    a[i] = to_end[i] * reflection(i, record.last, to_end[i] * s[i]);
  for (std::ptrdiff_t b = count; b-- > 0;) {
    for (std::size_t i = 0; i < 2; ++i) a[i] = over_block[i] * a[i] + sum(b, 4 + 2 * i);
    y[static_cast<std::size_t>(b)] = S(direct_) * record.sums[static_cast<std::size_t>(b)].back() +
                                     (gain_[0] * a[0]).re + (gain_[1] * a[1]).re;
  }
  for (std::size_t i = 0; i < 2; ++i)
    s[i] = to_begin[i] * reflection(i, record.first, to_begin[i] * a[i]);
  const std::array<Complex, 2> next{gain_[0] * pole_[0], gain_[1] * pole_[1]};
  for (std::ptrdiff_t b = 0; b < count; ++b) {
    y[static_cast<std::size_t>(b)] += (next[0] * s[0]).re + (next[1] * s[1]).re;
    for (std::size_t i = 0; i < 2; ++i) s[i] = over_block[i] * s[i] + sum(b, 2 * i);
  }
}

template void DecimatedLowPass::apply(const Record<double>&, std::span<double>) const;
template void DecimatedLowPass::apply(const Record<PackD>&, std::span<PackD>) const;

}  // namespace fricid::signals
