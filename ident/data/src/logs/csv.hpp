// Text with one header line, then rows of the same length. The header may be a comment, where it
// lies directly above the numbers and has as many cells. What lies above the header is skipped by
// count (`LogStyle::skip_rows`).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/log_reader.hpp"

namespace fricid::data {

/// The text behind its first `count` lines, whatever they hold.
std::string_view without_lines(std::string_view text, int count);

/// @param prefix  cut off from headers that begin with it
/// @throws UserError "file:line: ..." for an empty file
std::vector<std::string> csv_names(std::string_view text, const std::string& file,
                                   const LogStyle& style, std::string_view prefix = {});

/// Lines that are blank or start with # are skipped; only the wanted cells need be numbers.
/// @throws UserError "file:line: ..." for an empty file, a missing column (with the line that has
/// it,
///         where it is another one), a row of another length, a cell that is no number
LogTable parse_csv(std::string_view text, const std::string& file,
                   const std::vector<std::string>& wanted, const LogStyle& style,
                   std::string_view prefix = {});

}  // namespace fricid::data
