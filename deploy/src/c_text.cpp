#include "c_text.hpp"

#include <fmt/format.h>

#include "fricid/base/names.hpp"

namespace fricid::deploy {

std::string c_comment(std::string_view text) {
  std::string result = "/* ";
  char last = ' ';
  for (const char c : printable(text)) {
    // neither an end nor a start of a comment, nor a trigraph
    if ((last == '*' && c == '/') || (last == '/' && c == '*') || (last == '?' && c == '?'))
      result += ' ';
    result += c;
    last = c;
  }
  return result + " */";
}

std::string c_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte >= 0x20 && byte < 0x7f && c != '"' && c != '\\' && c != '?';
    result += plain ? std::string(1, c) : fmt::format("\\{:03o}", byte);
  }
  return result + '"';
}

}  // namespace fricid::deploy
