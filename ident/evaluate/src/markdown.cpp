#include "markdown.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace fricid::evaluate {
namespace {

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

std::string digits(double value) {
  if (std::isnan(value)) return "–";
  if (value == 0) return "0";
  const double magnitude = std::abs(value);
  if (magnitude >= 0.01 && magnitude < 1e5)
    return fmt::format("{:.{}f}", value,
                       magnitude < 0.1  ? 3
                       : magnitude < 1  ? 2
                       : magnitude < 10 ? 1
                                        : 0);
  std::string text = fmt::format("{:.1e}", value);
  const std::size_t e = text.find('e');
  const int exponent = std::stoi(text.substr(e + 1));
  return fmt::format("{}e{}", text.substr(0, e), exponent);
}

std::string percent(double share) { return std::isnan(share) ? "–" : digits(100 * share); }

std::string fixed(double value) {
  return std::isnan(value) ? "–" : fmt::format("{:.2f}", value + 0.0);
}

std::string seconds(double value) { return fmt::format("{:.3g} s", value); }

std::string range(const Interval& interval) {
  return std::isnan(interval.low)
             ? "–"
             : fmt::format("{} … {}", digits(interval.low), digits(interval.high));
}

std::string markdown_table(const std::vector<Cells>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 3);
  for (const Cells& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width_of(row[c]));
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string pad(widths[c] - width_of(rows[r][c]), ' ');
      text += c == 0 ? fmt::format("| {}{} ", rows[r][c], pad)
                     : fmt::format("| {}{} ", pad, rows[r][c]);
    }
    text += "|\n";
    if (r > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c)
      text += c == 0 ? fmt::format("|{:-<{}}", "", widths[c] + 2)
                     : fmt::format("|{:-<{}}:", "", widths[c] + 1);
    text += "|\n";
  }
  return text;
}

Cells horizon_titles(const std::string& first, const std::vector<double>& horizons_s) {
  Cells cells{first};
  append(cells, horizons_s, seconds);
  return cells;
}

}  // namespace fricid::evaluate
