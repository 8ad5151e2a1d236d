// What all readers of logs share.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fricid::data {

/// Lower-case copy.
std::string lower_case(std::string_view text);
/// Without spaces, tabs and carriage returns around it.
std::string_view trimmed(std::string_view text);
/// A text of unknown origin for a message: in quotes, short, one line.
std::string in_quotes(std::string_view text);
/// ISO 8859-1 as UTF-8; valid UTF-8 stays.
std::string as_utf8(std::string_view text);

/// Index of a column by name; letter case matters only where it tells two apart.
/// @throws UserError naming `where` when it is missing or there twice
std::size_t find_column(const std::vector<std::string>& names, const std::string& name,
                        const std::string& where);

/// False when the text is no number; "", "nan", "null" and "none" in any case are missing values.
bool parse_number(std::string_view text, bool decimal_comma, double& value);

}  // namespace fricid::data
