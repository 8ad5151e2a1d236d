#pragma once

#include <cstddef>
#include <cstdint>

namespace fricid::evaluate {

/// Purposes of random numbers of an evaluation; each has streams of its own.
enum class Purpose : std::uint64_t { kFit = 1, kBand };

/// Stream of one purpose, one recording or start and one draw, so that no result depends on the
/// order of work.
constexpr std::uint64_t stream_of(Purpose purpose, std::size_t recording, int draw) {
  return static_cast<std::uint64_t>(purpose) << 56 | static_cast<std::uint64_t>(recording) << 24 |
         static_cast<std::uint64_t>(draw);
}

}  // namespace fricid::evaluate
