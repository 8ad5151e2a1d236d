#include "seeds.hpp"

#include <cstdio>

#include "fricid/base/error.hpp"

namespace fricid::cli {

std::vector<int> parse_seeds(const std::string& text) {
  std::vector<int> seeds;
  for (std::size_t at = 0; at < text.size();) {
    int first = 0, last = 0, used = 0;
    const char* rest = text.c_str() + at;
    if (std::sscanf(rest, "%d-%d%n", &first, &last, &used) == 2) {
    } else if (std::sscanf(rest, "%d%n", &first, &used) == 1) {
      last = first;
    }
    at += static_cast<std::size_t>(used);
    const bool separated = at == text.size() || text[at] == ',';
    if (used == 0 || !separated || first < 0 || last < first || last - first > 1000)
      throw UserError("--seeds {}: allowed: numbers and ranges such as 1-5 or 1,3", text);
    for (int seed = first; seed <= last; ++seed) seeds.push_back(seed);
    ++at;
  }
  return seeds;
}

}  // namespace fricid::cli
