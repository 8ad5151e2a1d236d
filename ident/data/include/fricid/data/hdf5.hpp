// HDF5 files of this project: a format string, attributes, and tables of doubles with a unit. Safe
// to use from several threads (one at a time inside HDF5). The same content gives the same bytes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "fricid/signals/matrix.hpp"

namespace fricid::data {

using fricid::RowMatrix;

/// Fills a file that is being written; made by `write_hdf5`.
class H5Writer {
 public:
  /// Table `name` (rows, columns) with attribute `unit`.
  void matrix(const std::string& name, const RowMatrix& values, const std::string& unit);
  void vector(const std::string& name, const Eigen::VectorXd& values, const std::string& unit);
  /// Root attributes.
  void attribute(const std::string& name, const std::string& value);
  void attribute(const std::string& name, double value);
  void attribute(const std::string& name, const std::vector<std::string>& values);
  void attribute(const std::string& name, const std::vector<double>& values);

 private:
  friend void write_hdf5(const std::filesystem::path&, const std::string&,
                         const std::function<void(H5Writer&)>&);
  explicit H5Writer(std::int64_t file) : file_(file) {}
  std::int64_t file_;
};

/// Creates or replaces `path` atomically; `write` fills it. Root attribute format = `format`, a
/// name and a version, e.g. "fricid.truth/1".
/// @throws UserError naming the path when it cannot be written
void write_hdf5(const std::filesystem::path& path, const std::string& format,
                const std::function<void(H5Writer&)>& write);

/// Size of a table of numbers; a vector has one column. 0 columns: not a table of numbers.
struct TableShape {
  std::int64_t rows = 0, columns = 0;
};

/// An open file. Members throw UserError naming the file and the table or attribute that is
/// missing, of another shape, or unreadable.
class H5Reader {
 public:
  /// @throws UserError when the file is missing, a folder, empty, torn, not HDF5, of another
  /// format, or
  ///         of a newer version than `format`
  H5Reader(const std::filesystem::path& path, const std::string& format);
  ~H5Reader();
  H5Reader(const H5Reader&) = delete;
  H5Reader& operator=(const H5Reader&) = delete;

  const std::string& path() const { return path_; }
  bool has(const std::string& name) const;
  /// Size of a table, without reading its values.
  TableShape shape(const std::string& name) const;
  /// @param columns  expected number of columns; -1: any
  /// @throws UserError also when the table takes more than memory_budget()
  RowMatrix matrix(const std::string& name, int columns = -1) const;
  Eigen::VectorXd vector(const std::string& name) const;
  std::string unit(const std::string& name) const;
  std::string text_attribute(const std::string& name) const;
  double number_attribute(const std::string& name) const;
  double number_attribute_or_zero(const std::string& name) const;  ///< 0: it is absent
  std::vector<std::string> texts_attribute(const std::string& name) const;
  std::vector<double> numbers_attribute(const std::string& name) const;
  /// Attribute joint_names, each what names.hpp allows.
  std::vector<std::string> joint_names() const;
  /// Names of the tables, sorted.
  std::vector<std::string> names() const;

 private:
  std::string path_;
  std::int64_t file_ = -1;
};

/// Name of a column of a table: that of the table where it has one column, else NAME1, NAME2, ...
std::string column_name(const std::string& table, std::int64_t columns, std::int64_t j);

/// All tables of a file side by side as comma-separated values, handed over line by line.
/// @throws UserError when they differ in their number of rows
void print_tables(const H5Reader& file, const std::function<void(const std::string&)>& print);

/// The format string of any HDF5 file of this project. @throws UserError as H5Reader
std::string hdf5_format(const std::filesystem::path& path);

}  // namespace fricid::data
