// Text, numbers and tables as HTML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fricid::render::html {

/// Text as the content of an element or of an attribute in quotes.
std::string escaped(std::string_view text);

/// A number with so many significant digits: "0.12", "4667", "7.2 × 10⁻⁹" with a raised exponent;
/// "–" for NaN.
std::string number(double value, int digits = 2);

/// 100 times the value and " %".
std::string percent(double share, int digits = 2);

/// A cell of a table: HTML, and what it means to the style sheet ("best", "bad", "muted", ...).
struct Cell {
  std::string text;
  std::string style = {};
};

/// A row; `style` as for cells.
struct Row {
  std::vector<Cell> cells;
  std::string style = {};
};

/// A table whose first column is a heading. It scrolls sideways inside itself where it must.
/// @param head     HTML of the column headings
/// @param caption  HTML; empty: none
std::string table(const std::vector<std::string>& head, const std::vector<Row>& rows,
                  const std::string& caption = {});

}  // namespace fricid::render::html
