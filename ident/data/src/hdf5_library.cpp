#include "hdf5_library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"

namespace fricid::data::hdf5 {
namespace {

// The library is not thread safe as distributions build it.
std::recursive_mutex& library_mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

Id text_type() {
  Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
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

}  // namespace

Session::Session() : lock_(library_mutex()) {
  [[maybe_unused]] static const herr_t no_cleanup = H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Id open_to_read(const std::string& path) {
  const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose};
}

void demand(bool ok, const char* what) {
  if (ok) return;
  const bool disk = errno == ENOSPC || errno == EDQUOT || errno == EFBIG || errno == EIO;
  throw std::runtime_error(disk ? fmt::format("{}: {}", what, std::strerror(errno)) : what);
}

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

void require_memory_for(hid_t table, const TableShape& shape, const std::string& name,
                        const std::string& path) {
  const double numbers = static_cast<double>(shape.rows) * static_cast<double>(shape.columns);
  require_memory(8 * numbers + bytes_of_chunk(table), path,
                 fmt::format("table /{} of {} x {} numbers", name, shape.rows, shape.columns));
}

}  // namespace fricid::data::hdf5
