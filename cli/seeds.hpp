#pragma once

#include <string>
#include <vector>

namespace fricid::cli {

/// Seeds of fits in the order given: numbers and ranges with commas between, such as "1-5" or
/// "1,3-4".
/// @throws UserError on anything else, a seed beyond limits::kFitSeed, a seed given twice, and more
/// than limits::kFitSeeds of them
std::vector<int> parse_seeds(const std::string& text);

}  // namespace fricid::cli
