#include "gnuplot.hpp"

#include <fmt/format.h>

#include "fricid/base/names.hpp"

namespace fricid::render::gnuplot {

namespace {

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' ||
         c == '_' || c == '-' || c == '.' || c == ' ';
}

/// "..." with every byte but plain characters as \ooo, so that gnuplot finds no end of the string,
/// `program`, @macro or escape in it. gnuplot reads more than three digits after a \, so a digit
/// that follows is escaped too.
std::string in_octal(std::string_view text) {
  std::string result = "\"";
  bool after_escape = false;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9';
    after_escape = !is_plain(c) || (after_escape && digit);
    result +=
        after_escape ? fmt::format("\\{:03o}", static_cast<unsigned char>(c)) : std::string(1, c);
  }
  return result + "\"";
}

}  // namespace

// '...' is read literally but for the apostrophe: '' for it is misread beside the ends of a string
// (gnuplot 5.4). The svg terminal does not escape >, and XML does not allow ]]>.
Script string_of(std::string_view text) {
  std::string shown = printable(text);
  for (std::size_t at = 0; (at = shown.find("]]>", at)) != shown.npos;)
    shown.insert(at + 2, 1, ' ');
  const bool literal = shown.find_first_of("'\\`@\"") == shown.npos;
  return Script(Vouched{literal ? fmt::format("'{}'", shown) : in_octal(shown)});
}

Script tic(std::string_view text) {
  std::string doubled;
  for (const char c : text) doubled += c == '%' ? std::string("%%") : std::string(1, c);
  return string_of(doubled);
}

// A \ at the very end of a line would join the next one to it.
Script comment(std::string_view text) {
  return Script(Vouched{"# " + printable(text) + (text.ends_with('\\') ? " \n" : "\n")});
}

Script file(const std::filesystem::path& path) {
  return Script(Vouched{in_octal(std::filesystem::absolute(path).string())});
}

}  // namespace fricid::render::gnuplot
