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

/// Of Philox.
template <Kind kind>
constexpr int kRounds = kind == Kind::kSingleNormal ? 7 : 10;

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

/// Moves the upper half to the lower one; the upper half of the result is undefined.
std::uint64_t upper(std::uint64_t a) { return a >> 32; }
Words upper(Words a) {
#if defined(__AVX512F__)
  return (Words::Vector)_mm512_maskz_shuffle_epi32(0xFFFF, (__m512i)a.v, _MM_PERM_DDBB);
#else
  return a >> 32;
#endif
}

/// Rounds on the lower halves of `c`; the upper halves are undefined. Works on several blocks side
/// by side, so that a processor overlaps their chains of operations.
template <int blocks, class W>
[[gnu::always_inline]] inline void philox_rounds(W (&c)[blocks][4], std::uint32_t key0,
                                                 std::uint32_t key1, int rounds) {
#pragma GCC unroll 10
  for (int round = 0; round < rounds; ++round) {
#pragma GCC unroll 4
    for (int b = 0; b < blocks; ++b) {
      const W p0 = multiply_low(c[b][0], 0xD2511F53);
      const W p1 = multiply_low(c[b][2], 0xCD9E8D57);
      c[b][0] = upper(p1) ^ c[b][1] ^ W(key0);
      c[b][1] = p1;
      c[b][2] = upper(p0) ^ c[b][3] ^ W(key1);
      c[b][3] = p0;
    }
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
template <Kind kind, int blocks, class W>
void random_words(std::uint64_t seed, std::uint64_t stream, const W (&block)[blocks],
                  W (&c)[blocks][4]) {
  for (int b = 0; b < blocks; ++b) {
    const W counter = block[b] | W(static_cast<std::uint64_t>(kind));
    c[b][0] = counter;
    c[b][1] = counter >> 32;
    c[b][2] = W(stream);
    c[b][3] = W(stream >> 32);
  }
  philox_rounds(c, low(seed), high(seed), kRounds<kind>);
}

/// Two uniforms of each block.
template <Kind kind, class S>
Pair<S> uniforms(std::uint64_t seed, std::uint64_t stream, detail::Words<S> block) {
  using W = detail::Words<S>;
  W words[1][4];
  random_words<kind, 1, W>(seed, stream, {block}, words);
  const auto& c = words[0];
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
  const Pair<S> u = uniforms<kind, S>(seed, stream, block);
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

/// sqrt(-2 log u), u = (k + 1/2) 2^-32 of every word k to the 24 digits of a float.
PackF radius_of(detail::Words<PackF> word) {
  const PackF k(__builtin_convertvector(word.v, PackF::Vector));
  const auto u = detail::log_parts(fma(k, PackF(0x1p-32f), PackF(0x1p-33f)));
  // -2 log(1 + f) / f for 1 + f in [sqrt(1/2), sqrt(2)], to 2e-7
  constexpr float kLog[] = {-0x1.fffffep+0f, 0x1.00007ap+0f, -0x1.5559dcp-1f, 0x1.ff623cp-2f,
                            -0x1.978e38p-2f, 0x1.614c20p-2f, -0x1.4c3cc0p-2f, 0x1.9df91ap-3f};
  constexpr float kMinusTwoLn2 = -0x1.62e430p+0f;
  const PackF f = u.m - PackF(1);
  return sqrt(fma(f, detail::polynomial(f, kLog), u.n * PackF(kMinusTwoLn2)));
}

/// cos and sin of 2 pi k 2^-32 times `radius`.
Pair<PackF> turn(PackF radius, detail::Words<PackF> k) {
  using W = detail::Words<PackF>;
  // pi/2 t plus a whole or half turn: what differs in the upper two bits of k
  typedef std::int32_t Integers __attribute__((vector_size(sizeof(W))));
  const W twice = k << 1;
  const PackF t =
      PackF(__builtin_convertvector((Integers)twice.v, PackF::Vector)) * PackF(0x1p-31f);
  const PackF r = from_bits(to_bits(radius) ^ ((k ^ twice) & W(1U << 31)));
  // cos(pi/2 t) and sin(pi/2 t) / t in t^2 for |t| <= 1, to 1e-7
  constexpr float kCos[] = {0x1.fffffep-1f, -0x1.3bd3a6p+0f, 0x1.03bd06p-2f, -0x1.54f61ap-6f,
                            0x1.c1f064p-11f};
  constexpr float kSin[] = {0x1.921fb6p+0f, -0x1.4abbc2p-1f, 0x1.4668b0p-4f, -0x1.324ccap-8f,
                            0x1.3daff6p-13f};
  const PackF z = t * t;
  return {r * detail::polynomial(z, kCos), r * t * detail::polynomial(z, kSin)};
}

/// The pairs of a block are in the lanes 2 i and 2 i + 1 that its lane of 64 bits consists of.
[[gnu::always_inline]] inline Pair<PackF> single_normals(const Words (&c)[4]) {
  static_assert(PackF::kLanes == 2 * kLanes);
  const Words mask(0xFFFFFFFF);
  const Words radius = (c[0] & mask) | (c[2] << 32), angle = (c[1] & mask) | (c[3] << 32);
  detail::Words<PackF> u, w;
  std::memcpy(&u, &radius, sizeof(u));
  std::memcpy(&w, &angle, sizeof(w));
  return turn(radius_of(u), w);
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
                                        std::array<std::uint32_t, 2> key, int rounds) {
  std::uint64_t c[1][4] = {{counter[0], counter[1], counter[2], counter[3]}};
  philox_rounds(c, key[0], key[1], rounds);
  return {low(c[0][0]), low(c[0][1]), low(c[0][2]), low(c[0][3])};
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
  constexpr int kSideBySide = 2;
  constexpr std::size_t kDraws = 2 * PackF::kLanes;
  constexpr auto kInTurn = std::make_index_sequence<PackF::kLanes>();
  Words block[kSideBySide];
  for (int b = 0; b < kSideBySide; ++b)
    for (int i = 0; i < kLanes; ++i) block[b].set(i, static_cast<std::uint64_t>(b * kLanes + i));
  while (!out.empty()) {
    Words c[kSideBySide][4];
    random_words<Kind::kSingleNormal>(seed, stream, block, c);
    float rest[kSideBySide * kDraws];
    const bool whole = out.size() >= std::size(rest);
    float* to = whole ? out.data() : rest;
    for (int b = 0; b < kSideBySide; ++b) {
      const Pair<PackF> pair = single_normals(c[b]);
      store_in_turn(pair.first, pair.second, to + static_cast<std::size_t>(b) * kDraws, kInTurn);
      block[b] = block[b] + Words(kSideBySide * kLanes);
    }
    if (!whole) std::copy_n(rest, out.size(), out.data());
    out = whole ? out.subspan(std::size(rest)) : std::span<float>();
  }
}

}  // namespace fricid
