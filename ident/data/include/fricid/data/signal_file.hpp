// Sampled signals as HDF5. Each kind is one struct that names its attributes and tables once, in
// `visit(archive)`, and its format in `kFormat`; writing, reading, the check of what was read and
// docs/run_folder.md come from that.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/field.hpp"
#include "fricid/data/hdf5.hpp"

namespace fricid::data {

/// The writing archive.
class SignalWriter {
 public:
  explicit SignalWriter(H5Writer& file) : file_(file) {}

  void joints(const std::vector<std::string>& names) { file_.attribute("joint_names", names); }
  template <class Value>
  void attribute(std::string_view key, const Value& value, const Field& /*field*/) {
    file_.attribute(std::string(key), value);
  }
  /// Left out where it is zero.
  void attribute_or_zero(std::string_view key, double value, const Field& field) {
    if (value != 0) attribute(key, value, field);
  }
  /// Written for other programs, never read.
  template <class Value>
  void stamp(std::string_view key, const Value& value, const Field& field) {
    attribute(key, value, field);
  }
  /// An attribute that is text in the file: `write()` gives it, `read(text, place)` takes it.
  template <class Write, class Read>
  void text_attribute(std::string_view key, Write&& write, Read&& /*read*/, const Field& field) {
    attribute(key, std::string(write()), field);
  }
  void times(const Eigen::VectorXd& t) { file_.vector("t", t, "s"); }
  void column(std::string_view key, const Eigen::VectorXd& values, const Field& field) {
    file_.vector(std::string(key), values, std::string(field.unit));
  }
  /// (T, n)
  void of_joints(std::string_view key, const RowMatrix& values, const Field& field) {
    file_.matrix(std::string(key), values, std::string(field.unit));
  }
  /// (T, n); left out when empty.
  void of_joints_or_none(std::string_view key, const RowMatrix& values, const Field& field) {
    if (values.size() > 0) of_joints(key, values, field);
  }
  /// (T, n_z)
  void of_states(std::string_view key, const RowMatrix& values, const Field& field) {
    of_joints(key, values, field);
  }
  /// (T, n_z); left out when empty.
  void of_states_or_none(std::string_view key, const RowMatrix& values, const Field& field) {
    of_joints_or_none(key, values, field);
  }

 private:
  H5Writer& file_;
};

/// The reading archive: every table has as many rows as /t, those of joints a column per joint.
/// Errors: "file: table tau_f has 2 rows; allowed: 6, as t".
class SignalReader {
 public:
  /// @param n  number of joints that the caller expects, whose files may come from other programs:
  ///           names and units are not looked at; -1: the file's own, which must have both
  SignalReader(const std::filesystem::path& path, std::string_view format, int n)
      : path_(path.string()), file_(path, std::string(format)), n_(n), is_strict_(n < 0) {}

  void joints(std::vector<std::string>& names) {
    if (!is_strict_) return;
    names = file_.joint_names();
    n_ = static_cast<int>(names.size());
  }
  void attribute(std::string_view key, double& value, const Field& /*field*/) {
    value = file_.number_attribute(std::string(key));
  }
  void attribute(std::string_view key, std::string& value, const Field& /*field*/) {
    value = file_.text_attribute(std::string(key));
  }
  void attribute_or_zero(std::string_view key, double& value, const Field& /*field*/) {
    value = file_.number_attribute_or_zero(std::string(key));
  }
  template <class Value>
  void stamp(std::string_view /*key*/, const Value& /*value*/, const Field& /*field*/) {}
  template <class Write, class Read>
  void text_attribute(std::string_view key, Write&& /*write*/, Read&& read,
                      const Field& /*field*/) {
    read(file_.text_attribute(std::string(key)), fmt::format("{}: attribute {}", path_, key));
  }
  void times(Eigen::VectorXd& t) {
    t = file_.vector("t");
    rows_ = t.size();
  }
  void column(std::string_view key, Eigen::VectorXd& values, const Field& field) {
    values = file_.vector(std::string(key));
    check(key, values.size(), field);
  }
  void of_joints(std::string_view key, RowMatrix& values, const Field& field) {
    read(key, values, n_, field);
  }
  void of_joints_or_none(std::string_view key, RowMatrix& values, const Field& field) {
    if (file_.has(std::string(key))) read(key, values, n_, field);
  }
  void of_states(std::string_view key, RowMatrix& values, const Field& field) {
    read(key, values, -1, field);
  }
  void of_states_or_none(std::string_view key, RowMatrix& values, const Field& field) {
    if (file_.has(std::string(key))) read(key, values, -1, field);
  }

 private:
  void read(std::string_view key, RowMatrix& values, int columns, const Field& field) {
    values = file_.matrix(std::string(key), columns);
    check(key, values.rows(), field);
  }
  void check(std::string_view key, Eigen::Index rows, const Field& field) const {
    if (is_strict_)
      if (const std::string found = file_.unit(std::string(key)); found != field.unit)
        throw UserError("{}: unit of /{} = \"{}\"; allowed: {}", path_, key, found, field.unit);
    if (rows != rows_)
      throw UserError("{}: table {} has {} rows; allowed: {}, as t", path_, key, rows, rows_);
  }

  std::string path_;
  H5Reader file_;
  int n_;
  bool is_strict_;
  Eigen::Index rows_ = 0;
};

/// Writes the signals atomically. @throws UserError
template <class Signals>
void save_signals(const Signals& signals, const std::filesystem::path& path) {
  write_hdf5(path, std::string(Signals::kFormat), [&](H5Writer& file) {
    SignalWriter writer(file);
    const_cast<Signals&>(signals).visit(writer);  // a writer only reads, `visit` serves readers too
  });
}

/// @param n  as SignalReader
/// @throws UserError naming the file when it is missing, torn, of another format, or a table is not
///         of its rows and columns
template <class Signals>
Signals load_signals(const std::filesystem::path& path, int n = -1) {
  Signals signals;
  SignalReader reader(path, Signals::kFormat, n);
  signals.visit(reader);
  return signals;
}

}  // namespace fricid::data
