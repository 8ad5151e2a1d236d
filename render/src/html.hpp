// Text, numbers and tables as HTML.
#pragma once

#include <concepts>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/code.hpp"

namespace fricid::render {

using Html = Code<struct HtmlLanguage>;

namespace html {

/// Text as the content of an element or of an attribute in quotes.
Html escaped(std::string_view text);

/// A number with so many significant digits: "0.12", "4667", "7.2 × 10⁻⁹" with a raised exponent;
/// "–" for NaN.
Html number(double value, int digits = 2);

/// 100 times the value and " %".
Html percent(double share, int digits = 2);

/// "s" unless `count` is 1.
Html plural(std::integral auto count) { return count == 1 ? Html() : Html::of("s"); }

/// Class of a cell or row in the style sheet.
enum class Style { kPlain, kBest, kBad, kSoft, kText, kRule, kSoftRule };

/// A cell of a table.
struct Cell {
  Html text;
  Style style = Style::kPlain;
};

struct Row {
  std::vector<Cell> cells;
  Style style = Style::kPlain;
};

/// Column headings from words, each escaped.
std::vector<Html> headings(std::initializer_list<std::string_view> words);

/// A table whose first column is a heading; scrolls sideways if too wide.
/// @param caption  empty: none
Html table(const std::vector<Html>& head, const std::vector<Row>& rows, const Html& caption = {});

/// "a, b and c".
Html enumeration(const std::vector<Html>& parts);

/// A collapsible part; empty if its content is.
Html details(std::string_view summary, const Html& part);

/// Links to the second-level headings of a page.
Html navigation(const Html& page);

}  // namespace html
}  // namespace fricid::render
