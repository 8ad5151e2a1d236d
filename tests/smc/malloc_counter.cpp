// Counts what operator new does not see: Eigen calls malloc by itself.
#include "malloc_counter.hpp"

#include <atomic>
#include <cstddef>

namespace {
std::atomic<long> blocks = 0;
}

namespace fricid::smc::test {
long heap_blocks() { return blocks; }
}  // namespace fricid::smc::test

extern "C" {
void* __real_malloc(std::size_t size);
void* __real_calloc(std::size_t count, std::size_t size);
void* __real_realloc(void* p, std::size_t size);
void* __real_aligned_alloc(std::size_t alignment, std::size_t size);

void* __wrap_malloc(std::size_t size) {
  ++blocks;
  return __real_malloc(size);
}
void* __wrap_calloc(std::size_t count, std::size_t size) {
  ++blocks;
  return __real_calloc(count, size);
}
void* __wrap_realloc(void* p, std::size_t size) {
  ++blocks;
  return __real_realloc(p, size);
}
void* __wrap_aligned_alloc(std::size_t alignment, std::size_t size) {
  ++blocks;
  return __real_aligned_alloc(alignment, size);
}
}
