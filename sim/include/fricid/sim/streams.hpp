#pragma once

#include <cstdint>

#include "fricid/base/rng.hpp"

namespace fricid::sim {

/// Purposes of random numbers in the simulator; each has streams of its own.
enum class Purpose : std::uint64_t { kExcitation = 1, kEncoder, kTorque, kVelocity, kDrop, kPush };

/// Stream for one purpose, one sequence (or trajectory) and one joint (or restart), so that no
/// result depends on the order of work.
inline Rng make_rng(std::uint64_t seed, Purpose purpose, int sequence, int index) {
  return Rng(seed, (static_cast<std::uint64_t>(purpose) << 48) |
                       (static_cast<std::uint64_t>(sequence) << 24) |
                       static_cast<std::uint64_t>(index));
}

}  // namespace fricid::sim
