// Normal random numbers in single precision, by the thousand: the noise of particles.
#pragma once

#include <cstdint>
#include <span>

namespace fricid {

/// out[i] = draw i of the stream, N(0, 1), |x| < 6.8, about half the cost of the double-precision
/// draws of Rng (rng.hpp), of which these are independent. Seven rounds of Philox, whose counter is
/// the stream, i / 4 and a mark of its own: four draws share a block of 128 bits. The same on any
/// number of threads; between instruction sets equal but for rounding.
void fill_normal(std::uint64_t seed, std::uint64_t stream, std::span<float> out);

}  // namespace fricid
