#include "columns.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>

#include "fricid/base/error.hpp"
#include "fricid/base/text.hpp"

namespace fricid::data {

std::string lower_case(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string shown = as_utf8(text.substr(0, kLongest));
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return fmt::format("\"{}{}\"", shown, text.size() > kLongest ? "..." : "");
}

std::string as_utf8(std::string_view text) {
  std::string utf8;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const std::size_t more = c < 0x80 ? 0 : c >= 0xC2 && c < 0xE0 ? 1 : c < 0xF0 ? 2 : 3;
    bool whole = c < 0x80 || (c >= 0xC2 && c < 0xF5 && i + more < text.size());
    for (std::size_t m = 1; whole && m <= more; ++m)
      whole = (static_cast<unsigned char>(text[i + m]) & 0xC0) == 0x80;
    if (whole) {
      utf8 += text.substr(i, more + 1);
      i += more;
    } else {
      utf8 += static_cast<char>(0xC0 | c >> 6);
      utf8 += static_cast<char>(0x80 | (c & 0x3F));
    }
  }
  return utf8;
}

std::size_t find_column(const std::vector<std::string>& names, const std::string& name,
                        const std::string& where) {
  const auto exact = std::find(names.begin(), names.end(), name);
  if (std::count(exact, names.end(), name) > 1)
    throw UserError("{}: column {} appears twice", where, in_quotes(name));
  if (exact != names.end()) return static_cast<std::size_t>(exact - names.begin());
  std::vector<std::size_t> alike;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (lower_case(names[i]) == lower_case(name)) alike.push_back(i);
  if (alike.size() == 1) return alike[0];
  if (alike.size() > 1)
    throw UserError("{}: column {} may be {} or {}; allowed: the name in its own letter case",
                    where, in_quotes(name), in_quotes(names[alike[0]]), in_quotes(names[alike[1]]));
  const std::vector<std::string_view> known(names.begin(), names.end());
  const std::string meant = nearest(name, known);
  constexpr std::size_t kShown = 60;
  throw UserError("{}: no column {}; {}", where, in_quotes(name),
                  meant.empty() ? "found: " + first_of(names, kShown)
                                : fmt::format("nearest: {}", in_quotes(meant)));
}

bool parse_number(std::string_view text, bool decimal_comma, double& value) {
  const std::string_view cell = text;
  const auto missing = [&] {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  };
  if (text.empty()) return missing();
  if (text.front() == '+') text.remove_prefix(1);
  std::string with_point;
  if (decimal_comma) {
    with_point = text;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    text = with_point;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size()) return true;
  // words that loggers write where they have no value; "nan" was a number
  const std::string word = lower_case(cell.substr(0, 5));
  return (word == "null" || word == "none") && missing();
}

}  // namespace fricid::data
