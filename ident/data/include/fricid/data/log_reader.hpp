// The formats of real logs, one table row each. A reader gives named columns of numbers; the
// contract says what they mean (`contract.hpp`).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fricid::data {

/// The requested columns, in the requested order, and the line of each row.
struct LogTable {
  std::vector<std::vector<double>> columns;  ///< NaN where a value is missing; equal lengths
  std::vector<int> lines;                    ///< line of the file of each row; empty if binary
  std::vector<std::string> units{};  ///< of the columns, by a row below the header; or empty
  int units_line = 0;                ///< of the file
};

/// How the numbers of a text file are written, and which signals of a file are meant.
struct LogStyle {
  char separator = '\0';       ///< '\0': found in the header
  bool decimal_comma = false;  ///< 1,5 instead of 1.5
  std::string topic{};         ///< of a bag; empty: its only topic of joint states
  int skip_rows = 0;           ///< lines above the header, whatever they hold
};

/// Default columns of a format. In names {} stands for 1, 2, ..., {0} for 0, 1, ..., {name} for the
/// name of the joint; | separates alternatives. Empty: the contract must name the column.
struct LogDefaults {
  std::string_view time{};
  std::string_view time_unit{"s"};
  std::string_view position{};
  std::string_view position_unit{"rad"};
  std::string_view velocity{};  ///< used if the file has it
  std::string_view velocity_unit{"rad"};
};

/// One format.
struct LogReader {
  std::string_view name;     ///< in a contract: format = "..."
  std::string_view meaning;  ///< one phrase
  LogDefaults defaults;
  /// Whether a file that begins with `head` is of this format.
  bool (*recognises)(std::string_view head);
  /// Names of its columns. @throws UserError
  std::vector<std::string> (*names)(const std::filesystem::path& path, const LogStyle& style);
  /// The columns `wanted`, which are among its names but for letter case.
  /// @throws UserError "file:line: ..." on anything torn
  LogTable (*read)(const std::filesystem::path& path, const std::vector<std::string>& wanted,
                   const LogStyle& style);
  bool has_header = false;  ///< a line of text that names the columns, which rows may precede
};

/// Every format; the first that recognises a file reads it. csv is the last and takes all.
std::span<const LogReader> log_readers();

/// @param format     name of a reader, or "auto"
/// @param skip_rows  lines above the header
/// @throws UserError when the file cannot be read, or is of a format without a header to skip to
const LogReader& reader_for(const std::filesystem::path& path, std::string_view format,
                            int skip_rows = 0);

}  // namespace fricid::data
