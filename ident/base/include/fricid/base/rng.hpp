#pragma once

#include <array>
#include <cstdint>

namespace fricid {

/// Philox4x32-10 (Salmon et al., SC 2011): 128 random bits from a counter and a key, no state.
std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key);

/// A stream of random numbers fixed by (seed, stream): draw k of a stream is the same on any number
/// of threads and any machine of the same floating-point width.
class Rng {
 public:
  Rng(std::uint64_t seed, std::uint64_t stream);
  double uniform();  ///< in (0, 1)
  double normal();   ///< N(0, 1)

 private:
  std::uint64_t seed_, stream_, draw_ = 0;
};

}  // namespace fricid
