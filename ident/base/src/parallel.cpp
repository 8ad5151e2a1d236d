#include "fricid/base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "fricid/base/progress.hpp"

namespace fricid {
namespace {

thread_local bool inside_parallel_for = false;

}  // namespace

void parallel_for(int count, int jobs, const std::function<void(int)>& body) {
  if (jobs <= 0) jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  jobs = inside_parallel_for ? 1 : std::min(jobs, count);

  // Indices are handed out in order, so all below a failed one have been started: the lowest
  // failure is the same for any number of threads.
  std::atomic<int> next = 0;
  std::mutex mutex;
  int failed = count;
  std::exception_ptr failure;
  const auto work = [&] {
    for (int i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;) {
      try {
        throw_if_stopped();
        body(i);
      } catch (...) {
        next.store(count, std::memory_order_relaxed);
        const std::lock_guard lock(mutex);
        if (i < failed) {
          failed = i;
          failure = std::current_exception();
        }
      }
    }
  };

  if (jobs <= 1) {
    work();
  } else {
    std::vector<std::jthread> threads;
    for (int i = 0; i < jobs; ++i) {
      threads.emplace_back([&work] {
        inside_parallel_for = true;
        work();
      });
    }
    threads.clear();  // joins
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace fricid
