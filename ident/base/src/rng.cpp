#include "fricid/base/rng.hpp"

#include "fricid/base/math.hpp"

namespace fricid {
namespace {

// Salmon et al., SC 2011: multipliers and Weyl increments of Philox4x32
constexpr std::uint32_t kMultiplier0 = 0xD2511F53, kMultiplier1 = 0xCD9E8D57;
constexpr std::uint32_t kWeyl0 = 0x9E3779B9, kWeyl1 = 0xBB67AE85;
constexpr int kRounds = 10;
constexpr double kTwoPi = 6.283185307179586;

/// What a block of random words serves: separate counters keep uniforms and normals independent.
enum class Kind : std::uint64_t { kUniform = 0, kNormal = std::uint64_t{1} << 63 };

/// The two 64-bit words of one block.
std::array<std::uint64_t, 2> random_words(std::uint64_t seed, std::uint64_t stream,
                                          std::uint64_t block, Kind kind) {
  const std::uint64_t counter = block | static_cast<std::uint64_t>(kind);
  const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
  const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); };
  const auto w =
      philox4x32({low(counter), high(counter), low(stream), high(stream)}, {low(seed), high(seed)});
  return {w[0] | std::uint64_t{w[1]} << 32, w[2] | std::uint64_t{w[3]} << 32};
}

/// (k + 1/2) 2^-52 with k the upper 52 bits: exact, never 0 or 1.
double to_unit_interval(std::uint64_t word) {
  return static_cast<double>(word >> 12) * 0x1p-52 + 0x1p-53;
}

}  // namespace

std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t p0 = std::uint64_t{kMultiplier0} * counter[0];
    const std::uint64_t p1 = std::uint64_t{kMultiplier1} * counter[2];
    counter = {
        static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(p1),
        static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(p0)};
    key[0] += kWeyl0;
    key[1] += kWeyl1;
  }
  return counter;
}

Rng::Rng(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}

double Rng::uniform() {
  const auto words = random_words(seed_, stream_, draw_ / 2, Kind::kUniform);
  return to_unit_interval(words[draw_++ % 2]);
}

double Rng::normal() {
  // Box-Muller: the even draw of a block is r cos, the odd one r sin
  const auto words = random_words(seed_, stream_, draw_ / 2, Kind::kNormal);
  const double radius = sqrt(-2 * log(to_unit_interval(words[0])));
  const auto angle = sincos(kTwoPi * to_unit_interval(words[1]));
  return radius * (draw_++ % 2 == 0 ? angle.cos : angle.sin);
}

}  // namespace fricid
