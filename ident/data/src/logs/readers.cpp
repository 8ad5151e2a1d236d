#include <algorithm>
#include <array>
#include <concepts>
#include <fstream>
#include <optional>

#include <fmt/ranges.h>

#include "columns.hpp"
#include "csv.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/recording_file.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/log_reader.hpp"
#include "kuka_trace.hpp"
#include "mat.hpp"
#include "mcap.hpp"
#include "ros_bag.hpp"
#include "rsi.hpp"

namespace fricid::data {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

constexpr std::size_t kHead = 16384;  // bytes that tell a format

std::string first_line(std::string_view head) {
  return lower_case(head.substr(0, std::min(head.find('\n'), head.size())));
}
bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

// Named tables of numbers of a file.
template <class File>
concept TableFile = requires(const File& file, const std::string& table) {
  { file.path() } -> std::convertible_to<std::string>;
  { file.names() } -> std::same_as<Names>;
  { file.shape(table) } -> std::same_as<TableShape>;  // 0 x 0: no numbers
  { file.matrix(table) } -> std::same_as<RowMatrix>;
};

// A MAT-file of version 5 as tables.
class MatFile {
 public:
  explicit MatFile(const fs::path& path)
      : path_(path.string()), arrays_(mat_arrays(read_recording(path), path_)) {}

  const std::string& path() const { return path_; }
  Names names() const {
    Names names;
    for (const MatArray& array : arrays_) names.push_back(array.name);
    return names;
  }
  TableShape shape(const std::string& table) const {
    const MatArray& array = of(table);
    return {array.rows, array.columns};
  }
  RowMatrix matrix(const std::string& table) const {
    const MatArray& array = of(table);
    return Eigen::Map<const Eigen::MatrixXd>(array.values.data(), array.rows, array.columns);
  }

 private:
  const MatArray& of(const std::string& table) const {
    return *std::ranges::find(arrays_, table, &MatArray::name);
  }

  std::string path_;
  std::vector<MatArray> arrays_;
};

// What a file may hold beside tables of numbers, and which ones are read, in words.
struct TableWords {
  std::string_view others, read;
};
TableWords words_of(const H5Reader&) {
  return {"a group, a table of records, or empty", "tables of numbers at the top of the file"};
}
TableWords words_of(const MatFile&) {
  return {"a text, a cell, an object, complex, or empty", "arrays of real numbers"};
}

// Tables as they lie in a file, or the other way round, as MATLAB stores them: rows are samples. A
// vector may lie either way; a matrix is turned if only its other side is as long as the longest
// vector.
template <TableFile File>
class Tables {
 public:
  explicit Tables(const File& file) : file_(file) {
    for (const std::string& table : file.names()) {
      const TableShape shape = file.shape(table);
      if (std::min(shape.rows, shape.columns) == 1)
        longest_ = std::max({longest_, shape.rows, shape.columns});
    }
  }
  std::int64_t columns(const std::string& table) const {
    const TableShape shape = file_.shape(table);
    return is_turned(shape) ? shape.rows : shape.columns;
  }
  RowMatrix matrix(const std::string& table) const {
    RowMatrix values = file_.matrix(table);
    if (is_turned({values.rows(), values.cols()})) values = values.transpose().eval();
    return values;
  }

 private:
  bool is_turned(const TableShape& shape) const {
    return shape.rows != longest_ && shape.columns == longest_;
  }

  const File& file_;
  std::int64_t longest_ = 0;  // vector; 0: none
};

template <TableFile File>
Names columns_of(const File& file, const Tables<File>& tables) {
  Names names;
  for (const std::string& table : file.names()) {
    const std::int64_t columns = tables.columns(table);
    require_within(limits::kColumns, names.size() + static_cast<std::uint64_t>(columns),
                   file.path());
    for (std::int64_t j = 0; j < columns; ++j) names.push_back(column_name(table, columns, j));
  }
  return names;
}

/// "t, q1, q2, and log (a group, a table of records, or empty)": columns, and what has none.
template <TableFile File>
std::string tables_in_words(const File& file, const Names& columns) {
  Names others;
  for (const std::string& table : file.names())
    if (const TableShape shape = file.shape(table); shape.rows == 0 && shape.columns == 0)
      others.push_back(table);
  std::string words = columns.empty() ? "no column" : fmt::format("{}", fmt::join(columns, ", "));
  if (!others.empty())
    words += fmt::format(", and {} ({})", fmt::join(others, ", "), words_of(file).others);
  return words;
}

template <TableFile File>
LogTable read_tables(const File& file, const Names& wanted) {
  const Tables<File> tables(file);
  LogTable log;
  log.columns.resize(wanted.size());
  for (const std::string& table : file.names()) {
    const std::int64_t columns = tables.columns(table);
    std::optional<RowMatrix> values;  // read once a column of it is wanted
    for (std::int64_t j = 0; j < columns; ++j) {
      const std::string name = lower_case(column_name(table, columns, j));
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (lower_case(wanted[i]) != name) continue;
        if (!values) values = tables.matrix(table);
        if (values->rows() == 0) continue;  // Eigen has no column of none
        log.columns[i].assign(values->col(j).begin(), values->col(j).end());
      }
    }
  }
  const Names found = columns_of(file, tables);
  for (const std::string& name : wanted)
    if (std::ranges::none_of(
            found, [&](const std::string& known) { return lower_case(known) == lower_case(name); }))
      throw UserError("{}: {} is missing; found {}; allowed: {}", file.path(), name,
                      tables_in_words(file, found), words_of(file).read);
  for (std::size_t i = 1; i < wanted.size(); ++i)
    if (log.columns[i].size() != log.columns[0].size())
      throw UserError("{}: {} has {} rows; allowed: {}, as {}", file.path(), wanted[i],
                      log.columns[i].size(), log.columns[0].size(), wanted[0]);
  return log;
}

Names hdf5_names(const fs::path& path, const LogStyle&) {
  const H5Reader file(path, "");
  return columns_of(file, Tables(file));
}
LogTable read_hdf5(const fs::path& path, const Names& wanted, const LogStyle&) {
  return read_tables(H5Reader(path, ""), wanted);
}

Names mat_names(const fs::path& path, const LogStyle&) {
  const MatFile file(path);
  return columns_of(file, Tables(file));
}
LogTable read_mat(const fs::path& path, const Names& wanted, const LogStyle&) {
  return read_tables(MatFile(path), wanted);
}

Names names_in_csv(const fs::path& path, const LogStyle& style) {
  return csv_names(read_recording(path), path.string(), style);
}
LogTable read_csv(const fs::path& path, const Names& wanted, const LogStyle& style) {
  return parse_csv(read_recording(path), path.string(), wanted, style);
}

// Columns named as the tags, in some loggers after "Receive.".
constexpr std::string_view kReceived = "Receive.";
Names names_in_rsi_csv(const fs::path& path, const LogStyle& style) {
  return csv_names(read_recording(path), path.string(), style, kReceived);
}
LogTable read_rsi_csv(const fs::path& path, const Names& wanted, const LogStyle& style) {
  return parse_csv(read_recording(path), path.string(), wanted, style, kReceived);
}

constexpr LogDefaults kRsi{
    .time = "IPOC", .time_unit = "ms", .position = "AIPos.A{}", .position_unit = "deg"};

const std::array kReaders{
    LogReader{"mcap",
              "MCAP with ROS 2 joint states",
              {.time = "stamp", .position = "position.{name}", .velocity = "velocity.{name}"},
              [](std::string_view head) { return head.starts_with("\x89MCAP"); },
              [](const fs::path& path, const LogStyle& style) {
                return mcap_names(read_recording(path), path.string(), style);
              },
              [](const fs::path& path, const Names& wanted, const LogStyle& style) {
                return parse_mcap(read_recording(path), path.string(), wanted, style);
              }},
    LogReader{"db3",
              "ROS 2 bag (SQLite) with joint states",
              {.time = "stamp", .position = "position.{name}", .velocity = "velocity.{name}"},
              [](std::string_view head) { return head.starts_with("SQLite format 3"); },
              bag_names,
              read_bag},
    LogReader{"hdf5",
              "HDF5 tables",
              {.time = "t", .position = "q{}"},
              [](std::string_view head) {
                return head.starts_with("\x89HDF") || contains(head, "\x89HDF\r\n\x1a\n");
              },
              hdf5_names,
              read_hdf5},
    LogReader{"mat",
              "MAT-file of version 5",
              {.time = "t", .position = "q{}"},
              [](std::string_view head) { return head.starts_with(kMatMagic); },
              mat_names,
              read_mat},
    LogReader{"kuka_trace",
              "KUKA KRC TRACE, .dat beside .r64",
              {.time = "Zeit|Time", .position = "Istposition{}", .position_unit = "motor_deg"},
              [](std::string_view head) {
                return contains(head, "DIAEXTENDED") || contains(head, "#BEGINGLOBALHEADER");
              },
              [](const fs::path& path, const LogStyle&) { return trace_names(path); },
              [](const fs::path& path, const Names& wanted, const LogStyle&) {
                return read_trace(path, wanted);
              }},
    LogReader{"rsi_xml", "KUKA RSI packets (XML)", kRsi,
              [](std::string_view head) { return contains(head, "<Rob"); },
              [](const fs::path& path, const LogStyle&) {
                return rsi_names(read_recording(path), path.string());
              },
              [](const fs::path& path, const Names& wanted, const LogStyle&) {
                return parse_rsi(read_recording(path), path.string(), wanted);
              }},
    LogReader{"rsi_csv", "KUKA RSI as text columns", kRsi,
              [](std::string_view head) { return contains(first_line(head), "aipos.a1"); },
              names_in_rsi_csv, read_rsi_csv, true},
    LogReader{"ur_csv",
              "Universal Robots RTDE recording",
              {.time = "timestamp", .position = "actual_q_{0}", .velocity = "actual_qd_{0}"},
              [](std::string_view head) { return contains(first_line(head), "actual_q_0"); },
              names_in_csv,
              read_csv,
              true},
    LogReader{"franka_csv",
              "libfranka log",
              {.time = "time|duration",
               .time_unit = "ms",
               .position = "state.q[{0}]|q[{0}]",
               .velocity = "state.dq[{0}]|dq[{0}]"},
              [](std::string_view head) {
                return contains(first_line(head), "tau_j[0]") &&
                       contains(first_line(head), "dq[0]");
              },
              names_in_csv,
              read_csv,
              true},
    LogReader{"csv",
              "text columns",
              {},
              [](std::string_view) { return true; },
              names_in_csv,
              read_csv,
              true},
};

}  // namespace

std::span<const LogReader> log_readers() { return kReaders; }

const LogReader& reader_for(const fs::path& path, std::string_view format, int skip_rows) {
  require_regular_file(path);  // it is read more than once
  std::ifstream file(path, std::ios::binary);
  std::string head(kHead, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  const auto reader_of = [&](std::string_view content) -> const LogReader& {
    return *std::ranges::find_if(kReaders, [&](const LogReader& reader) {
      return format == "auto" ? reader.recognises(content) : reader.name == format;
    });
  };
  if (skip_rows == 0) return reader_of(head);
  if (const LogReader& whole = reader_of(head); !whole.has_header)
    throw UserError("{}: {}: skip_rows = {} in the contract; allowed: 0, there is no header",
                    path.string(), whole.meaning, skip_rows);
  return reader_of(without_lines(head, skip_rows));
}

}  // namespace fricid::data
