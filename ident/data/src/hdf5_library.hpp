// The C library of HDF5: identifiers that close themselves, attributes and tables.
#pragma once

#include <hdf5.h>

#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fricid/data/hdf5.hpp"

namespace fricid::data::hdf5 {

/// One use of the library: locked, without its own messages on stderr, and without its clean-up at
/// exit, which crashes on a file that a full disk kept it from finishing.
class Session {
 public:
  Session();

 private:
  std::lock_guard<std::recursive_mutex> lock_;
};

/// Owns an identifier of any kind.
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

/// Opens a file to read; not ok when the library cannot. Its end closes whatever is open in it,
/// also what the library lost of a damaged file: a file that stays open is not read again when it
/// has changed.
Id open_to_read(const std::string& path);

/// @throws std::runtime_error unless `ok`. The library reports no reason; a full or broken disk has
///         left one in errno.
void demand(bool ok, const char* what);

/// Of objects that carry no times, so that the same content gives the same bytes.
Id creation_properties(hid_t kind);

/// Writes an attribute. @throws std::runtime_error
void write_texts(hid_t object, const char* name, const std::vector<const char*>& values,
                 bool scalar);
void write_numbers(hid_t object, const char* name, const double* values, hsize_t size, bool scalar);
/// Writes a table with the attribute `unit`. @throws std::runtime_error
void write_table(hid_t file, const std::string& name, const double* values,
                 const std::vector<hsize_t>& shape, const std::string& unit);

/// Reads an attribute. Texts may be of variable or fixed length.
/// @param path  the file, for messages
/// @return false when it is absent or of another kind
/// @throws UserError on more values than limits::kHdf5AttributeValues, or too much memory
bool read_texts(hid_t object, const char* name, const std::string& path,
                std::vector<std::string>& values);
bool read_numbers(hid_t object, const char* name, const std::string& path,
                  std::vector<double>& values);

/// The table of a name; not ok when there is none.
/// @throws UserError on one that lies, or whose numbers lie, in another file: it could be any
Id open_table(hid_t file, const std::string& name, const std::string& path);
/// Bytes that the library takes to read one chunk of a table; 0 of a table without chunks.
double bytes_of_chunk(hid_t table);

/// Rows and columns of a table of numbers, as the file declares them; nothing of another table.
std::optional<TableShape> shape_of_numbers(hid_t table);

/// @throws UserError when reading all numbers of a table would take too much memory
void require_memory_for(hid_t table, const TableShape& shape, const std::string& name,
                        const std::string& path);

}  // namespace fricid::data::hdf5
