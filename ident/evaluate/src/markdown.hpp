// Numbers and tables as reports show them.
#pragma once

#include <string_view>
#include <vector>

#include "fricid/base/code.hpp"
#include "fricid/evaluate/evaluation.hpp"

namespace fricid::evaluate {

using Markdown = Code<struct MarkdownLanguage>;
using Cells = std::vector<Markdown>;

/// Text as itself in a table or a line: one line, no sign of Markdown or HTML left.
Markdown escaped(std::string_view text);

/// Two or three significant digits, as errors deserve: "1.5e-4", "0.12", "3.7", "4667".
Markdown digits(double value);
Markdown percent(double share);
/// Two decimals: shares of the headroom are compared by difference.
Markdown fixed(double value);
Markdown seconds(double value);
/// "low … high"; a dash where there is none.
Markdown range(const Interval& interval);

/// A Markdown table that is readable as plain text too: padded, first column left, the rest right.
Markdown markdown_table(const std::vector<Cells>& rows);

/// First row of a table: `first`, then the horizons.
Cells horizon_titles(const Markdown& first, const std::vector<double>& horizons_s);

template <class Values>
void append(Cells& cells, const Values& values, Markdown (*format)(double)) {
  for (const double value : values) cells.push_back(format(value));
}

}  // namespace fricid::evaluate
