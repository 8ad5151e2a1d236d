// What the program prints on stdout and stderr.
#pragma once

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace fricid::cli {

/// Lines of text safe for a terminal: each made `printable` (names.hpp), tabs and line ends kept.
std::string visible_lines(std::string_view text);

/// Prints `visible_lines(text)`.
void print(std::string_view text, std::FILE* stream = stdout);

/// JSON text safe for a terminal: if some of it is not printable, everything beyond ASCII is
/// written as \uXXXX.
/// @param text  JSON that this program wrote
std::string visible_json(const std::string& text);

/// Prints a value as JSON on stdout.
template <class Json>
void print_json(const Json& value) {
  print(visible_json(value.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n");
}

}  // namespace fricid::cli
