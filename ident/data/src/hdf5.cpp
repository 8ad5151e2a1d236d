#include "fricid/data/hdf5.hpp"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <mutex>
#include <optional>
#include <utility>

#include "fricid/base/csv.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/recording_file.hpp"

namespace fricid::data {
namespace {

namespace fs = std::filesystem;

// The library is not thread safe as distributions build it.
std::recursive_mutex& library_mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

// One use of the library: locked, without its own messages on stderr, and without its clean-up at
// exit, which crashes on a file that a full disk kept it from finishing.
class Session {
 public:
  Session() : lock_(library_mutex()) {
    [[maybe_unused]] static const herr_t no_cleanup = H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }

 private:
  std::lock_guard<std::recursive_mutex> lock_;
};

// Owns an identifier of any kind.
class Id {
 public:
  Id(hid_t id, herr_t (*closer)(hid_t)) : id_(id), close_(closer) {}
  ~Id() {
    if (id_ >= 0) close_(id_);
  }
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  operator hid_t() const { return id_; }
  bool close() { return close_(release()) >= 0; }
  hid_t release() { return std::exchange(id_, -1); }
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// The library reports no reason; a full or broken disk has left one in errno.
void demand(bool ok, const char* what) {
  if (ok) return;
  const bool disk = errno == ENOSPC || errno == EDQUOT || errno == EFBIG || errno == EIO;
  throw std::runtime_error(disk ? fmt::format("{}: {}", what, std::strerror(errno)) : what);
}

Id text_type() {
  Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

// Objects carry no times, so that the same content gives the same bytes.
Id creation_properties(hid_t kind) {
  Id properties(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  return properties;
}

void write_texts(hid_t object, const char* name, const std::vector<const char*>& values,
                 bool scalar) {
  const Id type = text_type();
  const hsize_t size = values.size();
  const Id space(scalar ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Id attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  demand(attribute.ok() && (size == 0 || H5Awrite(attribute, type, values.data()) >= 0),
         "cannot write an attribute");
}

void write_numbers(hid_t object, const char* name, const double* values, hsize_t size,
                   bool scalar) {
  const Id space(scalar ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Id attribute(H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                     H5Aclose);
  demand(attribute.ok() && (size == 0 || H5Awrite(attribute, H5T_NATIVE_DOUBLE, values) >= 0),
         "cannot write an attribute");
}

void write_table(hid_t file, const std::string& name, const double* values,
                 const std::vector<hsize_t>& shape, const std::string& unit) {
  const Id space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
  const Id properties = creation_properties(H5P_DATASET_CREATE);
  const Id table(
      H5Dcreate2(file, name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT),
      H5Dclose);
  demand(table.ok(), "cannot create a table");
  demand(H5Dwrite(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0,
         "cannot write a table");
  write_texts(table, "unit", {unit.c_str()}, true);
}

std::vector<hsize_t> shape_of(hid_t space) {
  const int rank = H5Sget_simple_extent_ndims(space);
  std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(rank, 0)));
  if (rank > 0) H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  return shape;
}

// Values of an attribute. @throws UserError when they are too many
std::size_t size_of(hid_t space, const std::string& path) {
  const hssize_t count = std::max<hssize_t>(H5Sget_simple_extent_npoints(space), 0);
  require_within(limits::kHdf5AttributeValues, static_cast<std::uint64_t>(count), path);
  return static_cast<std::size_t>(count);
}

// Texts of an attribute, of variable or fixed length; nothing when it is absent or of another kind.
bool read_texts(hid_t object, const char* name, const std::string& path,
                std::vector<std::string>& values) {
  if (H5Aexists(object, name) <= 0) return false;
  const Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute.ok()) return false;
  const Id stored(H5Aget_type(attribute), H5Tclose);
  const Id space(H5Aget_space(attribute), H5Sclose);
  if (H5Tget_class(stored) != H5T_STRING) return false;
  const std::size_t size = size_of(space, path);
  if (H5Tis_variable_str(stored) > 0) {
    const Id type(H5Tcopy(stored), H5Tclose);
    std::vector<char*> texts(size, nullptr);
    if (size > 0 && H5Aread(attribute, type, texts.data()) < 0) return false;
    for (const char* text : texts) values.emplace_back(text ? text : "");
    if (size > 0) H5Dvlen_reclaim(type, space, H5P_DEFAULT, texts.data());
    return true;
  }
  const std::size_t length = H5Tget_size(stored);
  require_memory(static_cast<double>(size) * static_cast<double>(length), path,
                 fmt::format("attribute {}", name));
  std::vector<char> buffer(size * length + 1, '\0');
  if (size > 0 && H5Aread(attribute, stored, buffer.data()) < 0) return false;
  for (std::size_t i = 0; i < size; ++i) {
    const char* begin = buffer.data() + i * length;
    values.emplace_back(begin, std::find(begin, begin + length, '\0'));
  }
  return true;
}

// The table of a name; not ok when there is none.
// @throws UserError on one that lies, or whose numbers lie, in another file: it could be any
Id open_table(hid_t file, const std::string& name, const std::string& path) {
  H5L_info_t link{};
  if (H5Lget_info(file, name.c_str(), &link, H5P_DEFAULT) >= 0 && link.type != H5L_TYPE_HARD)
    throw UserError("{}: /{} is a link; allowed: a table", path, name);
  Id table(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!table.ok()) return table;
  const Id properties(H5Dget_create_plist(table), H5Pclose);
  if (H5Pget_layout(properties) == H5D_VIRTUAL || H5Pget_external_count(properties) > 0)
    throw UserError("{}: the numbers of /{} are in another file; allowed: in this one", path, name);
  return table;
}

// Bytes that the library takes to read one chunk of a table; 0 of a table without chunks.
double bytes_of_chunk(hid_t table) {
  const Id properties(H5Dget_create_plist(table), H5Pclose);
  std::array<hsize_t, H5S_MAX_RANK> shape{};
  const int rank = H5Pget_layout(properties) == H5D_CHUNKED
                       ? H5Pget_chunk(properties, static_cast<int>(shape.size()), shape.data())
                       : 0;
  if (rank < 1) return 0;
  const Id type(H5Dget_type(table), H5Tclose);
  double bytes = static_cast<double>(H5Tget_size(type));
  for (int i = 0; i < rank; ++i) bytes *= static_cast<double>(shape[static_cast<std::size_t>(i)]);
  return bytes;
}

// Rows and columns of a table of numbers, as the file declares them; nothing of another table.
std::optional<TableShape> shape_of_numbers(hid_t table) {
  const Id space(H5Dget_space(table), H5Sclose);
  const Id type(H5Dget_type(table), H5Tclose);
  const std::vector<hsize_t> shape = shape_of(space);
  const H5T_class_t kind = H5Tget_class(type);
  if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || shape.empty() || shape.size() > 2)
    return std::nullopt;
  const auto size = [](hsize_t extent) {
    return static_cast<std::int64_t>(std::min(extent, hsize_t{1} << 62));
  };
  return TableShape{size(shape[0]), shape.size() == 2 ? size(shape[1]) : 1};
}

bool read_numbers(hid_t object, const char* name, const std::string& path,
                  std::vector<double>& values) {
  if (H5Aexists(object, name) <= 0) return false;
  const Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute.ok()) return false;
  const Id stored(H5Aget_type(attribute), H5Tclose);
  const Id space(H5Aget_space(attribute), H5Sclose);
  const H5T_class_t kind = H5Tget_class(stored);
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) return false;
  values.resize(size_of(space, path));
  return values.empty() || H5Aread(attribute, H5T_NATIVE_DOUBLE, values.data()) >= 0;
}

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
hid_t open_file(const fs::path& path) {
  const std::string name = path.string();
  require_regular_file(path);
  const std::string bytes = read_recording(path);
  if (bytes.empty()) throw UserError("{}: an empty file", name);
  if (!bytes.starts_with(kHdf5Signature)) {
    if (bytes.size() < kHeader ||
        bytes.compare(kHeader, kHdf5Signature.size(), kHdf5Signature) != 0)
      throw UserError("{}: not an HDF5 file, or torn", name);
    const std::string format = bytes.substr(0, std::min(bytes.find('\n'), kHeader));
    if (bytes.compare(0, kHeader, make_header(format, std::string_view(bytes).substr(kHeader))) !=
        0)
      throw UserError("{}: torn: its checksum does not match", name);
  }
  const hid_t file = H5Fopen(name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0) throw UserError("{}: not an HDF5 file, or torn", name);
  return file;
}

// "fricid.dataset/1" -> {"fricid.dataset", 1}
std::pair<std::string, int> split_format(const std::string& format) {
  const std::size_t slash = format.rfind('/');
  int version = 0;
  if (slash != std::string::npos)
    std::from_chars(format.data() + slash + 1, format.data() + format.size(), version);
  return {format.substr(0, slash), version};
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
  const auto [wanted, newest] = split_format(format);
  Id file(open_file(path), H5Fclose);
  if (format.empty()) {  // any file, also one of another program
    file_ = file.release();
    return;
  }
  std::vector<std::string> texts;
  const bool has_format = read_texts(file, "format", path_, texts) && texts.size() == 1;
  const auto [kind, version] = split_format(has_format ? texts[0] : "");
  if (kind == wanted && version >= 1 && version <= newest) {
    file_ = file.release();
    return;
  }
  if (!has_format) throw UserError("{}: attribute format is missing; allowed: {}", path_, format);
  if (kind == wanted && version > newest)
    throw UserError("{}: format {} is newer than {}, which this program reads", path_, texts[0],
                    format);
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
  require_memory(8.0 * static_cast<double>(found.rows) * static_cast<double>(found.columns) +
                     bytes_of_chunk(table),
                 path_,
                 fmt::format("table /{} of {} x {} numbers", name, found.rows, found.columns));
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
  if (H5Gget_info(file_, &group) >= 0) require_within(limits::kHdf5Tables, group.nlinks, path_);
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
  const auto add = [&](const std::string& cell) { line += (line.empty() ? "" : ",") + cell; };
  const auto end = [&] {
    print(line + "\n");
    line.clear();
  };
  for (const std::string& name : file.names()) {
    RowMatrix table = file.matrix(name);
    if (table.cols() == 0) continue;
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
  const Id file(open_file(path), H5Fclose);
  std::vector<std::string> texts;
  if (!read_texts(file, "format", path.string(), texts) || texts.size() != 1)
    throw UserError("{}: attribute format is missing", path.string());
  return texts[0];
}

}  // namespace fricid::data
