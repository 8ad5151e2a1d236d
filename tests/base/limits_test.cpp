#include "fricid/base/limits.hpp"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <regex>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "source_dir.hpp"

namespace fricid {
namespace {

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const UserError& error) {
    return error.what();
  }
  return "accepted";
}

// docs/limits.md has one row per limit, in this order, and no others.
TEST(Limits, DocumentAndTableAgree) {
  const std::string document = read_file(source_dir() / "docs/limits.md");
  const std::regex row(R"(\| ([^|]+) \| (\d+) \|)");
  std::vector<std::string> found, expected;
  for (std::sregex_iterator at(document.begin(), document.end(), row), end; at != end; ++at)
    found.push_back((*at)[1].str() + ": " + (*at)[2].str());
  for (const Limit& limit : all_limits())
    expected.push_back(fmt::format("{}: {}", limit.what, limit.most));
  EXPECT_EQ(found, expected);
}

TEST(Limits, SentenceSaysWhereFoundAndAllowed) {
  for (const Limit& limit : all_limits()) {
    EXPECT_EQ(error_of([&] { require_within(limit, limit.most, "a.toml"); }), "accepted");
    EXPECT_EQ(
        error_of([&] { require_within(limit, limit.most + 1, "a.toml"); }),
        fmt::format("a.toml: {} {}; allowed: up to {}", limit.most + 1, limit.what, limit.most));
  }
}

TEST(Memory, RefusesWhatIsMoreThanHalfOfWhatIsFree) {
  const double budget = memory_budget();
  EXPECT_GT(budget, 1e6);
  EXPECT_EQ(error_of([] { require_memory(1, "a.toml", "the data"); }), "accepted");
  EXPECT_THAT(error_of([] { require_memory(1e18, "a.toml", "the data"); }),
              testing::MatchesRegex("a.toml: the data would take 1e\\+09 GB of memory; allowed: "
                                    "[0-9.e+]+ GB, half of what is free"));
  EXPECT_NE(error_of([] { require_memory(std::nan(""), "a.toml", "the data"); }), "accepted");
}

/// For a child: whether the budget follows a limit of 512 MB more than the process has already.
int budget_under_a_limit() {
  const double before = memory_budget();
  std::ifstream pages("/proc/self/statm");
  std::size_t size = 0;
  pages >> size;
  const rlim_t most = size * static_cast<std::size_t>(::getpagesize()) + (std::size_t{512} << 20);
  const rlimit space{most, most};
  if (::setrlimit(RLIMIT_AS, &space) != 0) return 2;
  const double after = memory_budget();
  return after > 200e6 && after < 270e6 && after < before ? 0 : 1;
}

TEST(Memory, KnowsTheLimitOfTheAddressSpace) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer takes address space of its own";
#endif
  EXPECT_EXIT(std::exit(budget_under_a_limit()), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace fricid
