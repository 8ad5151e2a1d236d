// Parallel loops and reductions: each index once, bytes independent of the number of threads.
#include "fricid/base/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"

namespace fricid {
namespace {

constexpr int kJobs[] = {0, 1, 2, 3, 8, 100};

TEST(ParallelFor, RunsEachIndexOnce) {
  for (const int jobs : kJobs) {
    for (const int count : {0, 1, 2, 7, 1000}) {
      std::vector<std::atomic<int>> calls(static_cast<std::size_t>(count));
      parallel_for(count, jobs, [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
      for (const auto& c : calls) EXPECT_EQ(c, 1) << jobs << " jobs, " << count << " indices";
    }
  }
  parallel_for(-1, 2, [](int) { FAIL(); });
}

/// Two bodies that wait for each other end only when two threads run.
TEST(ParallelFor, RunsOnSeveralThreads) {
  std::atomic<int> arrived = 0;
  std::set<std::thread::id> threads;
  std::mutex mutex;
  parallel_for(2, 2, [&](int) {
    ++arrived;
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (arrived < 2 && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
    const std::lock_guard lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(threads.size(), 2u);
}

TEST(ParallelFor, OneJobStaysOnTheCallingThread) {
  parallel_for(5, 1, [caller = std::this_thread::get_id()](int) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
  });
}

TEST(ParallelFor, RethrowsTheFirstExceptionByIndex) {
  for (const int jobs : kJobs) {
    for (int repetition = 0; repetition < 20; ++repetition) {
      std::string message;
      try {
        parallel_for(50, jobs, [](int i) {
          // the later index fails sooner
          if (i == 10) std::this_thread::sleep_for(std::chrono::milliseconds(1));
          if (i >= 10) throw std::runtime_error(std::to_string(i));
        });
      } catch (const std::runtime_error& error) {
        message = error.what();
      }
      EXPECT_EQ(message, "10") << jobs << " jobs";
    }
  }
}

TEST(ParallelFor, ALoopInsideALoopRunsOnItsThread) {
  std::atomic<int> calls = 0;
  parallel_for(4, 3, [&](int) {
    parallel_for(5, 8, [&, outer = std::this_thread::get_id()](int) {
      EXPECT_EQ(std::this_thread::get_id(), outer);
      parallel_for(2, 0, [&](int) { ++calls; });
    });
  });
  EXPECT_EQ(calls, 40);

  // Afterwards the calling thread may start threads again.
  std::set<std::thread::id> threads;
  std::mutex mutex;
  parallel_for(8, 2, [&](int) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const std::lock_guard lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(threads.count(std::this_thread::get_id()), 0u);
}

std::vector<double> awkward_numbers(int count) {
  std::vector<double> x(static_cast<std::size_t>(count));
  fill_normal(1, 0, 0, x);
  for (double& v : x) v = v * v * v * 1e8;  // sums depend on their order
  return x;
}

TEST(ParallelReduce, SameBytesForAnyNumberOfJobs) {
  for (const int count : {1, 2, 3, 5, 8, 17, 1000}) {
    const std::vector<double> x = awkward_numbers(count);
    const auto sum = [&](int jobs) {
      return parallel_reduce(
          count, jobs, 0.0, [&](int i) { return x[static_cast<std::size_t>(i)]; },
          [](double a, double b) { return a + b; });
    };
    const double one = sum(1);
    for (const int jobs : {2, 3, 8}) {
      const double more = sum(jobs);
      EXPECT_EQ(std::memcmp(&one, &more, sizeof one), 0) << count << " terms, " << jobs << " jobs";
    }
    EXPECT_NEAR(one, std::accumulate(x.begin(), x.end(), 0.0), 1e-9 * std::fabs(one) + 1e-3);
  }
}

/// The tree keeps the order and has the shape that the header draws.
TEST(ParallelReduce, ShapeIsFixed) {
  const auto text = [](int count) {
    return parallel_reduce(
        count, 3, std::string("zero"), [](int i) { return std::to_string(i); },
        [](const std::string& a, const std::string& b) { return "(" + a + b + ")"; });
  };
  EXPECT_EQ(text(0), "zero");
  EXPECT_EQ(text(1), "0");
  EXPECT_EQ(text(2), "(01)");
  EXPECT_EQ(text(6), "(((01)(23))(45))");
}

TEST(ParallelReduce, ThrowsWhatMapThrows) {
  EXPECT_THROW(parallel_reduce(
                   10, 2, 0, [](int i) { return i < 5 ? i : throw std::domain_error("5"); },
                   [](int a, int b) { return a + b; }),
               std::domain_error);
}

/// A stop request ends the loop at the next index; in a child, for the request is for ever.
TEST(ParallelFor, StopsBetweenIndices) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        install_stop_handler();
        std::atomic<int> calls = 0;
        try {
          parallel_for(1000, 2, [&](int i) {
            ++calls;
            if (i == 3) std::raise(SIGTERM);
            // the other thread must not be through before the signal
            if (i > 3) std::this_thread::sleep_for(std::chrono::milliseconds(1));
          });
        } catch (const Stopped&) {
          std::_Exit(calls >= 4 && calls < 1000 ? 130 : 1);
        }
        std::_Exit(2);
      },
      ::testing::ExitedWithCode(130), "");
}

}  // namespace
}  // namespace fricid
