// How far the speeds of a joint spread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace fricid::signals {

/// Speeds of a joint but for the slowest and the fastest twentieth [rad/s or m/s].
struct SpeedRange {
  double slow = 0, fast = 0;

  /// Whether a joint slides at one speed: what that varies by is the answer of its controller to
  /// the torque, and tells neither viscous friction nor a delay.
  bool is_one() const {
    constexpr double kOneSpeed = 1.5;  // fastest over slowest
    return fast > 0 && fast < kOneSpeed * slow;
  }
};

/// @param speeds  of the rows in which the joint slides; reordered. 0, 0 of none
inline SpeedRange speed_range(std::span<double> speeds) {
  constexpr double kFew = 0.05;
  const auto quantile = [&](double share) {
    const auto at = speeds.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(speeds.size() - 1));
    std::ranges::nth_element(speeds, at);
    return *at;
  };
  if (speeds.empty()) return {};
  const double slow = quantile(kFew);
  return {slow, quantile(1 - kFew)};
}

}  // namespace fricid::signals
