#include "hdf5_trial.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <filesystem>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/processes.hpp"
#include "hdf5_library.hpp"

namespace fricid::data::hdf5 {
namespace {

// Processor time that the library may take, and for each so many bytes as much again.
constexpr std::chrono::seconds kPatience{1};
constexpr std::uintmax_t kSlowest = 4'000'000;
constexpr hsize_t kSlice = 1 << 20;  // numbers read at a time

void read_attributes(hid_t object, const std::string& path) {
  H5Aiterate2(
      object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr,
      [](hid_t from, const char* name, const H5A_info_t*, void* file) -> herr_t {
        std::vector<std::string> texts;
        std::vector<double> numbers;
        const std::string& of = *static_cast<const std::string*>(file);
        try {
          if (!read_texts(from, name, of, texts)) read_numbers(from, name, of, numbers);
        } catch (const std::exception&) {
          return 0;  // too many values: no reader takes them
        }
        return 0;
      },
      const_cast<std::string*>(&path));  // NOLINT: not written to
}

void read_chunks(hid_t table, const std::string& name, const std::string& path) {
  const std::optional<TableShape> shape = shape_of_numbers(table);
  if (!shape || bytes_of_chunk(table) == 0) return;
  require_memory_for(table, *shape, name, path);
  const Id space(H5Dget_space(table), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  const auto rows = static_cast<hsize_t>(shape->rows),
             columns = static_cast<hsize_t>(shape->columns);
  const hsize_t step = std::max<hsize_t>(kSlice / std::max<hsize_t>(columns, 1), 1);
  std::vector<double> numbers(std::min(rows, step) * columns);
  for (hsize_t row = 0; row < rows && columns > 0; row += step) {
    const std::array<hsize_t, 2> start{row, 0}, count{std::min(step, rows - row), columns};
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
    const Id slice(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
    if (H5Dread(table, H5T_NATIVE_DOUBLE, slice, space, H5P_DEFAULT, numbers.data()) < 0) return;
  }
}

void read_object(hid_t file, const char* name, const std::string& path) {
  const Id object(H5Oopen(file, name, H5P_DEFAULT), H5Oclose);
  if (!object.ok()) return;
  read_attributes(object, path);
  if (H5Iget_type(object) == H5I_DATASET) read_chunks(object, name, path);
}

struct Visit {
  const std::string& path;
  std::uint64_t objects = 0;
};

}  // namespace

void read_all(const std::string& path) {
  const Id file = open_to_read(path);
  if (!file.ok()) return;
  Visit visit{path};
  H5Ovisit2(
      file, H5_INDEX_NAME, H5_ITER_NATIVE,
      [](hid_t root, const char* name, const auto*, void* data) -> herr_t {
        auto& of = *static_cast<Visit*>(data);
        try {
          read_object(root, name, of.path);
        } catch (const std::exception&) {
          return 0;  // no reader takes this object
        }
        return ++of.objects > limits::kTables.most ? 1 : 0;
      },
      &visit, H5O_INFO_BASIC);
}

void try_to_read(const std::string& path) {
  static TrialProcess trial(read_all);  // one for the program, under the Session's lock
  const auto pieces = static_cast<int>(std::filesystem::file_size(path) / kSlowest);
  const std::chrono::seconds most = kPatience * (1 + pieces);
  switch (trial(std::filesystem::absolute(path).string(), most)) {
    case Trial::kCrashed:
      throw UserError("{}: damaged: the HDF5 library crashes on it", path);
    case Trial::kTooLong:
      throw UserError("{}: damaged: the HDF5 library reads it for more than {} s", path,
                      most.count());
    case Trial::kEnded:
      break;
  }
}

}  // namespace fricid::data::hdf5
