#pragma once

#include <string>
#include <vector>

namespace fricid::cli {

/// Seeds of "1-5" or "1,3"; none of an empty text. @throws UserError
std::vector<int> parse_seeds(const std::string& text);

}  // namespace fricid::cli
