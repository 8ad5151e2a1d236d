#include "seeds.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"

namespace fricid::cli {
namespace {

/// Removes a number from the front of `text`; empty when there is none, or it is too large.
std::optional<int> take_number(std::string_view& text) {
  std::uint64_t value = 0;
  if (text.empty() || text.front() < '0' || text.front() > '9') return std::nullopt;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || value > limits::kFitSeed.most) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return static_cast<int>(value);
}

}  // namespace

std::vector<int> parse_seeds(const std::string& text) {
  const auto refuse = [&] {
    throw UserError(
        "--seeds \"{}\": allowed: up to {} numbers from 0 to {}, each once, such as 1-5 "
        "or 1,3",
        text, limits::kFitSeeds.most, limits::kFitSeed.most);
  };
  std::vector<int> seeds;
  std::string_view rest = text;
  for (bool more = true; more;) {
    const std::optional<int> first = take_number(rest);
    std::optional<int> last = first;
    if (first && rest.starts_with('-')) {
      rest.remove_prefix(1);
      last = take_number(rest);
    }
    if (!first || !last || *last < *first ||
        static_cast<std::uint64_t>(*last - *first) >= limits::kFitSeeds.most - seeds.size())
      refuse();
    for (int seed = *first; seed <= *last; ++seed) {
      if (std::ranges::count(seeds, seed) > 0) refuse();
      seeds.push_back(seed);
    }
    more = rest.starts_with(',');
    if (more) rest.remove_prefix(1);
  }
  if (!rest.empty()) refuse();
  return seeds;
}

}  // namespace fricid::cli
