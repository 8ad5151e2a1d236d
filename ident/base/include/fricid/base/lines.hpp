#pragma once

#include <cstddef>
#include <string_view>

namespace fricid {

/// Number of the line, from 1, that holds byte `at` of a text.
int line_at(std::string_view text, std::size_t at);

}  // namespace fricid
