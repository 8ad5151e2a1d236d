#pragma once

#include <span>
#include <string>
#include <string_view>

namespace fricid {

/// Fewest insertions, deletions and substitutions of one character and swaps of two neighbours that
/// turn `a` into `b`, no part changed twice (optimal string alignment distance).
int edit_distance(std::string_view a, std::string_view b);

/// Suggestion for a misspelled word: the first known word with the smallest edit distance, letter
/// case ignored; empty if more than a third of the letters would have to change.
std::string nearest(std::string_view word, std::span<const std::string_view> known);

/// "a, b, c", or where these are more than `most`, "a, b and 7 more".
std::string first_of(std::span<const std::string> parts, std::size_t most);

/// "a, b and c".
std::string enumeration(std::span<const std::string> parts);

}  // namespace fricid
