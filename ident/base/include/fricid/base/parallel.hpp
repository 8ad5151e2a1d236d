#pragma once

#include <functional>

namespace fricid {

/// Calls body(i) for i = 0 .. count-1 on up to `jobs` threads (jobs <= 0: all cores). Each index
/// runs once; the first exception by index is rethrown. Results must not depend on the order.
void parallel_for(int count, int jobs, const std::function<void(int)>& body);

}  // namespace fricid
