// Text as a cell of a CSV file.
#pragma once

#include <string>
#include <string_view>

#include "fricid/base/names.hpp"

namespace fricid {

/// RFC 4180: in quotes, inner ones doubled; without line breaks or other control characters.
/// @param always  false: only where the text has a comma, semicolon, quote or space
inline std::string csv_cell(std::string_view text, bool always = true) {
  const std::string shown = printable(text);
  if (!always && shown.find_first_of(",\"; ") == shown.npos) return shown;
  std::string cell = "\"";
  for (const char c : shown) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

}  // namespace fricid
