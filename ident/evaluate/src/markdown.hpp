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

/// "90 of 120 (75 %)": intervals that hold the truth; a dash where none is stated.
Markdown held(const IntervalCount& count);

/// Intervals of the parameters of every model that states some; empty if none does.
template <class Models>
Markdown parameter_table(const Models& models) {
  std::vector<Cells> rows{{Markdown::of("90 % intervals that hold the truth"),
                           Markdown::of("base parameters"), Markdown::of("friction parameters")}};
  for (const auto& model : models)
    if (model.intervals && model.intervals->base.stated + model.intervals->friction.stated > 0)
      rows.push_back(
          {escaped(model.label), held(model.intervals->base), held(model.intervals->friction)});
  return rows.size() == 1 ? Markdown() : markdown_table(rows);
}

template <class Values>
void append(Cells& cells, const Values& values, Markdown (*format)(double)) {
  for (const double value : values) cells.push_back(format(value));
}

}  // namespace fricid::evaluate
