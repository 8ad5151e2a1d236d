#pragma once

#include <cstddef>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

namespace fricid {

/// Calls body(i) for i = 0 .. count-1 on up to `jobs` threads (jobs <= 0: all cores). Each index
/// runs once; the first exception by index is rethrown, and indices not begun by then are left out.
/// Results must not depend on the order. A loop inside a loop runs on the thread it is called from.
/// Starting the threads costs about 50 us each: one index should be worth 0.1 ms or more.
/// @throws Stopped when a stop was requested before the last index began
void parallel_for(int count, int jobs, const std::function<void(int)>& body);

/// combine(...combine(map(0), map(1))..., ...) over a binary tree whose shape depends on `count`
/// only, so that floating-point results have the same bytes for any number of jobs:
///
///     ((r0 + r1) + (r2 + r3)) + (r4 + r5)
///
/// @param zero     the result for count <= 0; not used otherwise
/// @param map      T map(int i), called from several threads
/// @param combine  T combine(T left, T right), called from one thread
/// @throws the exception of map with the lowest index; Stopped as parallel_for
/// @note Holds `count` values of T until the end.
template <class T, class Map, class Combine>
T parallel_reduce(int count, int jobs, T zero, Map map, Combine combine) {
  static_assert(!std::is_same_v<T, bool>, "neighbours of a vector<bool> share a byte");
  if (count <= 0) return zero;
  const auto n = static_cast<std::size_t>(count);
  std::vector<T> values(n, zero);
  parallel_for(count, jobs, [&](int i) { values[static_cast<std::size_t>(i)] = map(i); });
  for (std::size_t stride = 1; stride < n; stride *= 2) {
    for (std::size_t i = 0; i + stride < n; i += 2 * stride) {
      values[i] = combine(std::move(values[i]), std::move(values[i + stride]));
    }
  }
  return std::move(values[0]);
}

}  // namespace fricid
