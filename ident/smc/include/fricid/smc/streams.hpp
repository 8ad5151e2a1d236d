#pragma once

#include <cstdint>

namespace fricid::smc {

/// Purposes of random numbers; streams of different purposes are independent.
enum class Purpose : std::uint64_t { kFilter, kBackward, kGaussianPath, kGibbs };

/// Number of the random stream of one purpose, sequence and step: draws depend on nothing else, so
/// neither on threads nor on whether a step is computed for the first time or again.
/// @param sequence  < 2^29
constexpr std::uint64_t stream_of(Purpose purpose, std::uint32_t sequence, std::uint32_t step) {
  return static_cast<std::uint64_t>(purpose) << 61 | static_cast<std::uint64_t>(sequence) << 32 |
         step;
}

}  // namespace fricid::smc
