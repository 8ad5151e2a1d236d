#include "markdown.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/names.hpp"

namespace fricid::evaluate {
namespace {

std::size_t width_of(const Markdown& cell) {
  const std::string& text = cell.text();
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

Markdown repeated(const Markdown& piece, std::size_t times) {
  Markdown text;
  for (std::size_t i = 0; i < times; ++i) text += piece;
  return text;
}

/// A number that does not exist.
Markdown dash() { return Markdown::of("–"); }

}  // namespace

// \\ before a sign of ASCII makes it itself (CommonMark 2.4); HTML begins with < or &.
Markdown escaped(std::string_view text) {
  constexpr std::string_view kSigns = "\\`*[]<>|&~#$";
  std::string result;
  for (const char c : printable(text)) {
    if (kSigns.find(c) != kSigns.npos) result += '\\';
    result += c;
  }
  return Markdown(Vouched{result});
}

Markdown digits(double value) {
  if (std::isnan(value)) return dash();
  if (value == 0) return Markdown::of("0");
  if (std::isinf(value)) return Markdown(Vouched{value > 0 ? "inf" : "-inf"});
  const double magnitude = std::abs(value);
  if (magnitude >= 0.01 && magnitude < 1e5)
    return Markdown::of("{:.{}f}", value,
                        magnitude < 0.1  ? 3
                        : magnitude < 1  ? 2
                        : magnitude < 10 ? 1
                                         : 0);
  const std::string text = fmt::format("{:.1e}", value);
  const std::size_t e = text.find('e');
  const int exponent = std::stoi(text.substr(e + 1));
  return Markdown(Vouched{fmt::format("{}e{}", text.substr(0, e), exponent)});
}

Markdown percent(double share) { return std::isnan(share) ? dash() : digits(100 * share); }

Markdown fixed(double value) {
  return std::isnan(value) ? dash() : Markdown::of("{:.2f}", value + 0.0);
}

Markdown seconds(double value) { return Markdown::of("{:.3g} s", value); }

Markdown range(const Interval& interval) {
  return std::isnan(interval.low)
             ? dash()
             : Markdown::of("{} … {}", digits(interval.low), digits(interval.high));
}

Markdown markdown_table(const std::vector<Cells>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 3);
  for (const Cells& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width_of(row[c]));
  Markdown text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const Markdown pad = repeated(Markdown::of(" "), widths[c] - width_of(rows[r][c]));
      text += c == 0 ? Markdown::of("| {}{} ", rows[r][c], pad)
                     : Markdown::of("| {}{} ", pad, rows[r][c]);
    }
    text += Markdown::of("|\n");
    if (r > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const Markdown rule = repeated(Markdown::of("-"), widths[c] + 1);
      text += c == 0 ? Markdown::of("|{}-", rule) : Markdown::of("|{}:", rule);
    }
    text += Markdown::of("|\n");
  }
  return text;
}

Markdown held(const IntervalCount& count) {
  if (count.stated == 0) return Markdown::of("–");
  return Markdown::of("{} of {} ({:.0f} %)", count.hold, count.stated,
                      100. * count.hold / count.stated);
}

Cells horizon_titles(const Markdown& first, const std::vector<double>& horizons_s) {
  Cells cells{first};
  append(cells, horizons_s, seconds);
  return cells;
}

}  // namespace fricid::evaluate
