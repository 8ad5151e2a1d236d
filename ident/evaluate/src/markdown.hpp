// Numbers and tables as reports show them.
#pragma once

#include <string>
#include <vector>

#include "fricid/evaluate/report.hpp"

namespace fricid::evaluate {

using Cells = std::vector<std::string>;

/// Two or three significant digits, as errors deserve: "1.5e-4", "0.12", "3.7", "4667".
std::string digits(double value);
std::string percent(double share);
/// Two decimals: shares of the headroom are compared by difference.
std::string fixed(double value);
std::string seconds(double value);
/// "low … high"; a dash where there is none.
std::string range(const Interval& interval);

/// A Markdown table that is readable as plain text too: padded, first column left, the rest right.
std::string markdown_table(const std::vector<Cells>& rows);

/// First row of a table: `first`, then the horizons.
Cells horizon_titles(const std::string& first, const std::vector<double>& horizons_s);

template <class Values>
void append(Cells& cells, const Values& values, std::string (*format)(double)) {
  for (const double value : values) cells.push_back(format(value));
}

}  // namespace fricid::evaluate
