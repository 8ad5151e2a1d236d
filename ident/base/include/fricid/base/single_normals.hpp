// Normal random numbers in single precision for large arrays: the noise of particles.
#pragma once

#include <cstdint>
#include <span>

namespace fricid {

/// out[i] = draw i of the stream, N(0, 1), |x| < 6.8. Independent of the draws of Rng (rng.hpp), at
/// about half their cost. Seven rounds of Philox; its counter holds the stream, i / 4 and a
/// constant, and four draws share a block of 128 bits. The same for any number of threads;
/// instruction sets differ by rounding only.
void fill_normal(std::uint64_t seed, std::uint64_t stream, std::span<float> out);

}  // namespace fricid
