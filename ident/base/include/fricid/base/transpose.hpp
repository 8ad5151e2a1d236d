// Rows of packs turned into columns.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "fricid/base/pack.hpp"

namespace fricid {
namespace detail {

/// Exchanges blocks of kSize x kSize lanes across the diagonal of a pair of rows.
template <int kSize, class T, int N, int... lane>
void exchange_blocks(Pack<T, N>& upper, Pack<T, N>& lower, std::integer_sequence<int, lane...>) {
  const auto a = upper.v, b = lower.v;
  upper.v = __builtin_shufflevector(a, b, ((lane & kSize) ? N + lane - kSize : lane)...);
  lower.v = __builtin_shufflevector(a, b, ((lane & kSize) ? N + lane : lane + kSize)...);
}

template <int kSize, class T, int N>
void transpose_blocks(Pack<T, N>* x) {
  if constexpr (kSize > 0) {
    for (int i = 0; i < N; ++i)
      if ((i & kSize) == 0)
        exchange_blocks<kSize>(x[i], x[i + kSize], std::make_integer_sequence<int, N>());
    transpose_blocks<kSize / 2>(x);
  }
}

}  // namespace detail

/// Lane k of row i becomes lane i of row k.
template <class T, int N, std::size_t kRows>
requires(kRows == N) void transpose(std::array<Pack<T, N>, kRows>& x) {
  detail::transpose_blocks<N / 2>(x.data());
}

}  // namespace fricid
