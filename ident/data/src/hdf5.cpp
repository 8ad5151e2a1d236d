#include "fricid/data/hdf5.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <optional>
#include <utility>

#include "file_format.hpp"
#include "fricid/base/csv.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/recording_file.hpp"
#include "hdf5_library.hpp"
#include "hdf5_trial.hpp"

namespace fricid::data {
namespace {

namespace fs = std::filesystem;
using namespace hdf5;

// The first bytes of a file, which HDF5 leaves to its user: what it is, and the checksum of the
// rest.
constexpr std::size_t kHeader = 512;
constexpr std::string_view kHdf5Signature("\x89HDF\r\n\x1a\n", 8);

std::string make_header(const std::string& format, std::string_view rest) {
  std::string header =
      fmt::format("{}\nsha256 from byte {} on: {}\n", format, kHeader, sha256_of_text(rest));
  header.resize(kHeader, '\0');
  return header;
}

// Opens a file after looking for the mistakes that the library reports poorly. Files with our
// header must match their checksum; files of other programs have none.
Id open_file(const fs::path& path) {
  const std::string name = path.string();
  require_regular_file(path);
  const std::string bytes = read_recording(path);
  if (bytes.empty()) throw UserError("{}: an empty file", name);
  if (!bytes.starts_with(kHdf5Signature)) {
    if (bytes.size() < kHeader ||
        bytes.compare(kHeader, kHdf5Signature.size(), kHdf5Signature) != 0)
      throw UserError(
          "{}: not an HDF5 file, or torn; `fricid import` makes one of a log in a format of "
          "docs/your_own_log.md",
          name);
    const std::string format = bytes.substr(0, std::min(bytes.find('\n'), kHeader));
    if (bytes.compare(0, kHeader, make_header(format, std::string_view(bytes).substr(kHeader))) !=
        0)
      throw UserError("{}: torn: its checksum does not match", name);
  }
  try_to_read(name);
  Id file = open_to_read(name);
  if (!file.ok())
    throw UserError(
        "{}: not an HDF5 file, or torn; `fricid import` makes one of a log in a format of "
        "docs/your_own_log.md",
        name);
  return file;
}

}  // namespace

void H5Writer::matrix(const std::string& name, const RowMatrix& values, const std::string& unit) {
  write_table(file_, name, values.data(),
              {static_cast<hsize_t>(values.rows()), static_cast<hsize_t>(values.cols())}, unit);
}

void H5Writer::vector(const std::string& name, const Eigen::VectorXd& values,
                      const std::string& unit) {
  write_table(file_, name, values.data(), {static_cast<hsize_t>(values.size())}, unit);
}

void H5Writer::attribute(const std::string& name, const std::string& value) {
  write_texts(file_, name.c_str(), {value.c_str()}, true);
}

void H5Writer::attribute(const std::string& name, double value) {
  write_numbers(file_, name.c_str(), &value, 1, true);
}

void H5Writer::attribute(const std::string& name, const std::vector<std::string>& values) {
  std::vector<const char*> texts;
  for (const std::string& value : values) texts.push_back(value.c_str());
  write_texts(file_, name.c_str(), texts, false);
}

void H5Writer::attribute(const std::string& name, const std::vector<double>& values) {
  write_numbers(file_, name.c_str(), values.data(), values.size(), false);
}

namespace {

void fill_file(const std::string& name, const std::string& format,
               const std::function<void(hid_t)>& write) {
  const Session session;
  errno = 0;
  const Id create = creation_properties(H5P_FILE_CREATE);
  H5Pset_userblock(create, kHeader);
  const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
  Id file(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, create, access), H5Fclose);
  demand(file.ok(), "cannot be created");
  write_texts(file, "format", {format.c_str()}, true);
  write(file);
  demand(file.close(), "cannot be written");
}

}  // namespace

void write_hdf5(const fs::path& path, const std::string& format,
                const std::function<void(H5Writer&)>& write) {
  write_file_atomically(path, [&](const fs::path& temporary) {
    try {
      fill_file(temporary.string(), format, [&](hid_t file) {
        H5Writer writer(file);
        write(writer);
      });
    } catch (const UserError&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw UserError("{}: {}", path.string(), error.what());
    }
    const std::string bytes = read_recording(temporary);
    std::fstream file(temporary, std::ios::binary | std::ios::in | std::ios::out);
    file << make_header(format, std::string_view(bytes).substr(kHeader)) << std::flush;
    if (!file) throw UserError("{}: cannot be written", path.string());
  });
}

H5Reader::H5Reader(const fs::path& path, const std::string& format) : path_(path.string()) {
  const Session session;
  Id file = open_file(path);
  if (format.empty()) {  // any file, also one of another program
    file_ = file.release();
    return;
  }
  std::vector<std::string> texts;
  const bool has_format = read_texts(file, "format", path_, texts) && texts.size() == 1;
  if (!has_format) throw UserError("{}: attribute format is missing; allowed: {}", path_, format);
  const FileFormat found(texts[0]), known(format);
  if (found.name == known.name && found.version >= 1 && found.version <= known.version) {
    file_ = file.release();
    return;
  }
  refuse_newer(path_, texts[0], format);
  throw UserError("{}: format = \"{}\"; allowed: {}", path_, texts[0], format);
}

H5Reader::~H5Reader() {
  const Session session;
  H5Fclose(file_);
}

bool H5Reader::has(const std::string& name) const {
  const Session session;
  return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
}

TableShape H5Reader::shape(const std::string& name) const {
  const Session session;
  const Id table = open_table(file_, name, path_);
  return table.ok() ? shape_of_numbers(table).value_or(TableShape{}) : TableShape{};
}

RowMatrix H5Reader::matrix(const std::string& name, int columns) const {
  const Session session;
  if (!has(name)) throw UserError("{}: /{} is missing", path_, name);
  const Id table = open_table(file_, name, path_);
  if (!table.ok()) throw UserError("{}: /{} is not a table, or torn", path_, name);
  const std::optional<TableShape> numbers = shape_of_numbers(table);
  if (!numbers) throw UserError("{}: /{} is not a table of numbers", path_, name);
  const TableShape& found = *numbers;
  if (columns >= 0 && found.columns != columns)
    throw UserError("{}: /{} has {} columns; allowed: {}", path_, name, found.columns, columns);
  require_memory_for(table, found, name, path_);
  require_within(limits::kColumns, static_cast<std::uint64_t>(std::min(found.rows, found.columns)),
                 path_);
  RowMatrix values(found.rows, found.columns);
  if (values.size() > 0 &&
      H5Dread(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw UserError("{}: /{} is torn", path_, name);
  return values;
}

Eigen::VectorXd H5Reader::vector(const std::string& name) const { return matrix(name, 1).col(0); }

std::string H5Reader::unit(const std::string& name) const {
  const Session session;
  const Id table = open_table(file_, name, path_);
  std::vector<std::string> texts;
  if (!table.ok() || !read_texts(table, "unit", path_, texts) || texts.size() != 1)
    throw UserError("{}: attribute unit of /{} is missing", path_, name);
  return texts[0];
}

std::string H5Reader::text_attribute(const std::string& name) const {
  const std::vector<std::string> texts = texts_attribute(name);
  if (texts.size() != 1)
    throw UserError("{}: attribute {} has {} texts; allowed: 1", path_, name, texts.size());
  return texts[0];
}

std::vector<std::string> H5Reader::texts_attribute(const std::string& name) const {
  const Session session;
  std::vector<std::string> texts;
  if (!read_texts(file_, name.c_str(), path_, texts))
    throw UserError("{}: attribute {} is missing or not a text", path_, name);
  return texts;
}

std::vector<std::string> H5Reader::joint_names() const {
  std::vector<std::string> names = texts_attribute("joint_names");
  for (const std::string& name : names) require_name(Named::kJoint, name, path_);
  return names;
}

double H5Reader::number_attribute_or_zero(const std::string& name) const {
  const bool present = [&] {
    const Session session;
    return H5Aexists(file_, name.c_str()) > 0;
  }();
  return present ? number_attribute(name) : 0;
}

double H5Reader::number_attribute(const std::string& name) const {
  const std::vector<double> numbers = numbers_attribute(name);
  if (numbers.size() != 1)
    throw UserError("{}: attribute {} has {} numbers; allowed: 1", path_, name, numbers.size());
  return numbers[0];
}

std::vector<double> H5Reader::numbers_attribute(const std::string& name) const {
  const Session session;
  std::vector<double> numbers;
  if (!read_numbers(file_, name.c_str(), path_, numbers))
    throw UserError("{}: attribute {} is missing or not a number", path_, name);
  return numbers;
}

std::vector<std::string> H5Reader::names() const {
  const Session session;
  H5G_info_t group{};
  if (H5Gget_info(file_, &group) >= 0) require_within(limits::kTables, group.nlinks, path_);
  std::vector<std::string> names;
  H5Literate(
      file_, H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
        static_cast<std::vector<std::string>*>(list)->emplace_back(name);
        return 0;
      },
      &names);
  return names;
}

std::string column_name(const std::string& table, std::int64_t columns, std::int64_t j) {
  return columns == 1 ? table : table + std::to_string(j + 1);
}

void print_tables(const H5Reader& file, const std::function<void(const std::string&)>& print) {
  std::vector<RowMatrix> tables;
  std::string line;
  std::uint64_t columns = 0;
  const auto add = [&](const std::string& cell) { line += (line.empty() ? "" : ",") + cell; };
  const auto end = [&] {
    print(line + "\n");
    line.clear();
  };
  for (const std::string& name : file.names()) {
    RowMatrix table = file.matrix(name);
    if (table.cols() == 0) continue;
    require_within(limits::kColumns, columns += static_cast<std::uint64_t>(table.cols()),
                   file.path());
    if (!tables.empty() && table.rows() != tables[0].rows())
      throw UserError("{}: table {} has {} rows; allowed beside the first: {}", file.path(), name,
                      table.rows(), tables[0].rows());
    for (Eigen::Index j = 0; j < table.cols(); ++j)
      add(csv_cell(column_name(name, table.cols(), j), false));
    tables.push_back(std::move(table));
  }
  end();
  for (Eigen::Index k = 0; !tables.empty() && k < tables[0].rows(); ++k) {
    for (const RowMatrix& table : tables)
      for (Eigen::Index j = 0; j < table.cols(); ++j) add(fmt::format("{}", table(k, j)));
    end();
  }
}

std::string hdf5_format(const fs::path& path) {
  const Session session;
  const Id file = open_file(path);
  std::vector<std::string> texts;
  if (!read_texts(file, "format", path.string(), texts) || texts.size() != 1)
    throw UserError("{}: attribute format is missing", path.string());
  return texts[0];
}

}  // namespace fricid::data
