#include "fricid/base/limits.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <string>

#include "fricid/base/error.hpp"

namespace fricid {
namespace {

constexpr std::array kAll{limits::kTextBytes,
                          limits::kJsonLevels,
                          limits::kTomlLevels,
                          limits::kSceneFiles,
                          limits::kLinks,
                          limits::kJoints,
                          limits::kNameBytes,
                          limits::kLabelBytes,
                          limits::kTables,
                          limits::kColumns,
                          limits::kHdf5AttributeValues,
                          limits::kMatLevels,
                          limits::kChunkBytes,
                          limits::kMcapBytes,
                          limits::kBagMessageBytes,
                          limits::kFilledSamples,
                          limits::kSeed,
                          limits::kFitSeed,
                          limits::kFitSeeds};

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr double kSmall = 1e6;  // [bytes] a task may take without a look at the free memory

/// Bytes behind "KEY:" of a file in /proc that counts in kB; unbounded if the key is missing.
double kilobytes_of(const char* file, const std::string& key) {
  std::ifstream lines(file);
  for (std::string word; lines >> word;)
    if (double value = 0; word == key + ":" && lines >> value) return 1024 * value;
  return kUnbounded;
}

/// The number in a file that holds one number; unbounded for "max".
double number_of(const char* file) {
  std::ifstream text(file);
  double value = 0;
  return text >> value ? value : kUnbounded;
}

double left_by_control_group() {
  for (const auto& [most, used] :
       {std::pair("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        std::pair("/sys/fs/cgroup/memory/memory.limit_in_bytes",
                  "/sys/fs/cgroup/memory/memory.usage_in_bytes")})
    if (const double bytes = number_of(most) - number_of(used); bytes == bytes && bytes < 1e18)
      return bytes;
  return kUnbounded;
}

double left_of_address_space() {
  rlimit space{};
  if (::getrlimit(RLIMIT_AS, &space) != 0 || space.rlim_cur == RLIM_INFINITY) return kUnbounded;
  return static_cast<double>(space.rlim_cur) - kilobytes_of("/proc/self/status", "VmSize");
}

}  // namespace

std::span<const Limit> all_limits() { return kAll; }

void require_within(const Limit& limit, std::uint64_t found, std::string_view where) {
  if (found > limit.most)
    throw UserError("{}: {} {}; allowed: up to {}", where, found, limit.what, limit.most);
}

double memory_budget() {
  return std::max(0.0, std::min({kilobytes_of("/proc/meminfo", "MemAvailable"),
                                 left_by_control_group(), left_of_address_space()}) /
                           2);
}

void require_memory(double bytes, std::string_view where, std::string_view what) {
  if (bytes <= kSmall) return;
  if (const double budget = memory_budget(); !(bytes <= budget))
    throw UserError(
        "{}: {} would take {:.3g} GB of memory; allowed: {:.3g} GB, half of what is free", where,
        what, bytes / 1e9, budget / 1e9);
}

}  // namespace fricid
