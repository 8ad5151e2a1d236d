#include "fricid/base/rng.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "fricid/base/math.hpp"
#include "fricid/base/single_normals.hpp"

namespace fricid {
namespace {

constexpr double kTwoPi = 6.283185307179586;

/// What a block of random words serves: the top bits of its index.
enum class Kind : std::uint64_t {
  kUniform = 0,
  kNormal = std::uint64_t{1} << 63,
  kSingleNormal = std::uint64_t{1} << 62
};

// Lanes of 64 bits of which Philox uses the lower 32.
using Words = detail::Words<PackD>;
constexpr int kLanes = PackD::kLanes;

/// The product of the lower halves.
std::uint64_t multiply_low(std::uint64_t a, std::uint32_t b) { return (a & 0xFFFFFFFF) * b; }
Words multiply_low(Words a, std::uint32_t b) {
#if defined(__AVX512F__)
  return (Words::Vector)_mm512_maskz_mul_epu32(0xFF, (__m512i)a.v, _mm512_set1_epi64(b));
#elif defined(__AVX2__)
  return (Words::Vector)_mm256_mul_epu32((__m256i)a.v, _mm256_set1_epi64x(b));
#else
  return (a & Words(0xFFFFFFFF)) * Words(b);
#endif
}

/// Ten rounds on the lower halves of `c`; the upper ones hold anything.
template <class W>
void philox_rounds(W (&c)[4], std::uint32_t key0, std::uint32_t key1) {
#pragma GCC unroll 10
  for (int round = 0; round < 10; ++round) {
    const W p0 = multiply_low(c[0], 0xD2511F53);
    const W p1 = multiply_low(c[2], 0xCD9E8D57);
    c[0] = (p1 >> 32) ^ c[1] ^ W(key0);
    c[1] = p1;
    c[2] = (p0 >> 32) ^ c[3] ^ W(key1);
    c[3] = p0;
    key0 += 0x9E3779B9;
    key1 += 0xBB67AE85;
  }
}

std::uint32_t low(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
std::uint32_t high(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }

/// (k + 1/2) 2^-52 with k the upper 52 bits of the word: exact, never 0 or 1.
template <class W>
auto unit_interval(W word) {
  const auto one_to_two = from_bits((word >> 12) | W(to_bits(1.0)));
  return one_to_two - (1 - 0x1p-53);
}

/// The two numbers of a block; a block per lane.
template <class S>
struct Pair {
  S first, second;
};

/// The four random words of each block, in the lower halves of c.
template <class W>
void random_words(std::uint64_t seed, std::uint64_t stream, W block, Kind kind, W (&c)[4]) {
  const W counter = block | W(static_cast<std::uint64_t>(kind));
  c[0] = counter;
  c[1] = counter >> 32;
  c[2] = W(stream);
  c[3] = W(stream >> 32);
  philox_rounds(c, low(seed), high(seed));
}

/// Two uniforms of each block.
template <class S>
Pair<S> uniforms(std::uint64_t seed, std::uint64_t stream, detail::Words<S> block, Kind kind) {
  using W = detail::Words<S>;
  W c[4];
  random_words(seed, stream, block, kind, c);
  const W mask(0xFFFFFFFF);
  return {unit_interval((c[0] & mask) | (c[1] << 32)), unit_interval((c[2] & mask) | (c[3] << 32))};
}

/// Box and Muller: two normals of two uniforms.
template <class S>
Pair<S> normals(Pair<S> u) {
  const S radius = sqrt(S(-2) * log(u.first));
  const SinCos<S> angle = sincos(S(kTwoPi) * u.second);
  return {radius * angle.cos, radius * angle.sin};
}

template <Kind kind, class S>
Pair<S> draws(std::uint64_t seed, std::uint64_t stream, detail::Words<S> block) {
  const Pair<S> u = uniforms<S>(seed, stream, block, kind);
  if constexpr (kind == Kind::kNormal)
    return normals(u);
  else
    return u;
}

template <Kind kind>
double draw_one(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  const Pair<double> pair = draws<kind, double>(seed, stream, index / 2);
  return index % 2 == 0 ? pair.first : pair.second;
}

/// a[0], b[0], a[1], b[1], ... to memory.
template <class T, int N, std::size_t... I>
void store_in_turn(Pack<T, N> a, Pack<T, N> b, T* out, std::index_sequence<I...>) {
  const Pack<T, N> first = __builtin_shufflevector(a.v, b.v, (I / 2 + I % 2 * N)...);
  const Pack<T, N> second = __builtin_shufflevector(a.v, b.v, (N / 2 + I / 2 + I % 2 * N)...);
  std::memcpy(out, &first, sizeof(first));
  std::memcpy(out + N, &second, sizeof(second));
}

/// (k + 1/2) 2^-32 of every word k, to the 24 digits of a float: never 0, 1 only by rounding.
PackF unit_interval(detail::Words<PackF> word) {
  using W = detail::Words<PackF>;
  // the halves of the word behind 2^23, exactly
  const PackF high = from_bits((word >> 16) | W(0x4B000000)) - PackF(0x1p23f);
  const PackF low_half = from_bits((word & W(0xFFFF)) | W(0x4B000000)) - PackF(0x1p23f - 0.5f);
  return fma(high, PackF(0x1p-16f), low_half * PackF(0x1p-32f));
}

/// Two blocks' worth of pairs per lane of 64 bits: lanes 2 b and 2 b + 1 are the pairs of block b.
[[gnu::always_inline]] inline Pair<PackF> single_normals(std::uint64_t seed, std::uint64_t stream,
                                                         Words block) {
  static_assert(PackF::kLanes == 2 * kLanes);
  Words c[4];
  random_words(seed, stream, block, Kind::kSingleNormal, c);
  const Words mask(0xFFFFFFFF);
  const Words radius = (c[0] & mask) | (c[2] << 32), angle = (c[1] & mask) | (c[3] << 32);
  detail::Words<PackF> u, w;
  std::memcpy(&u, &radius, sizeof(u));
  std::memcpy(&w, &angle, sizeof(w));
  return normals(Pair<PackF>{unit_interval(u), unit_interval(w)});
}

template <Kind kind>
[[gnu::flatten]] void fill(std::uint64_t seed, std::uint64_t stream, std::uint64_t first,
                           std::span<double> out) {
  constexpr std::size_t kDraws = 2 * kLanes;
  // an odd start is the second of a pair
  if (first % 2 == 1 && !out.empty()) {
    out[0] = draw_one<kind>(seed, stream, first++);
    out = out.subspan(1);
  }
  Words block(0);
  for (int i = 0; i < kLanes; ++i) block.set(i, first / 2 + static_cast<std::uint64_t>(i));
  while (!out.empty()) {
    const Pair<PackD> pair = draws<kind, PackD>(seed, stream, block);
    if (out.size() >= kDraws) {
      store_in_turn(pair.first, pair.second, out.data(), std::make_index_sequence<kLanes>());
      out = out.subspan(kDraws);
    } else {
      double values[kDraws];
      store_in_turn(pair.first, pair.second, values, std::make_index_sequence<kLanes>());
      std::copy_n(values, out.size(), out.data());
      out = {};
    }
    block = block + Words(kLanes);
  }
}

}  // namespace

std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key) {
  std::uint64_t c[4] = {counter[0], counter[1], counter[2], counter[3]};
  philox_rounds(c, key[0], key[1]);
  return {low(c[0]), low(c[1]), low(c[2]), low(c[3])};
}

Rng::Rng(std::uint64_t seed, std::uint64_t stream, std::uint64_t draw)
    : seed_(seed), stream_(stream), draw_(draw) {}

double Rng::uniform() { return draw_one<Kind::kUniform>(seed_, stream_, draw_++); }
double Rng::normal() { return draw_one<Kind::kNormal>(seed_, stream_, draw_++); }

void fill_uniform(std::uint64_t seed, std::uint64_t stream, std::uint64_t first,
                  std::span<double> out) {
  fill<Kind::kUniform>(seed, stream, first, out);
}

void fill_normal(std::uint64_t seed, std::uint64_t stream, std::uint64_t first,
                 std::span<double> out) {
  fill<Kind::kNormal>(seed, stream, first, out);
}

[[gnu::flatten]] void fill_normal(std::uint64_t seed, std::uint64_t stream, std::span<float> out) {
  constexpr std::size_t kDraws = 2 * PackF::kLanes;
  constexpr auto kInTurn = std::make_index_sequence<PackF::kLanes>();
  Words block(0);
  for (int i = 0; i < kLanes; ++i) block.set(i, static_cast<std::uint64_t>(i));
  for (; !out.empty(); block = block + Words(kLanes)) {
    const Pair<PackF> pair = single_normals(seed, stream, block);
    if (out.size() >= kDraws) {
      store_in_turn(pair.first, pair.second, out.data(), kInTurn);
      out = out.subspan(kDraws);
    } else {
      float values[kDraws];
      store_in_turn(pair.first, pair.second, values, kInTurn);
      std::copy_n(values, out.size(), out.data());
      out = {};
    }
  }
}

}  // namespace fricid
