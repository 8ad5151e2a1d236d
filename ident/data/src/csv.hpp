#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace fricid::data {

/// A table of numbers as text files have it: one header line, then rows of the same length.
struct CsvTable {
  std::vector<std::string> header;
  std::vector<std::vector<double>> columns;  ///< NaN where a cell is empty or "nan"
  std::vector<int> lines;                    ///< line of the file of each row, from 1
  int header_line = 1;
};

/// Reads the columns `wanted` (header names; letter case matters only where it tells two apart).
/// @param separator  one character, or '\0' to find it in the header
/// @throws UserError "file:line: ..." for an empty file, a missing column, a row of another length,
/// a
///         cell that is no number
CsvTable read_csv(const std::filesystem::path& path, const std::vector<std::string>& wanted,
                  char separator, bool decimal_comma);

}  // namespace fricid::data
