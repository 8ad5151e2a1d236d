// Files on which the HDF5 library would crash, found out in a process that may.
#pragma once

#include <string>

namespace fricid::data::hdf5 {

/// Reads every attribute and every chunked table of a file, which is where the library follows
/// lengths and addresses that it does not check: heaps of texts, indices of chunks and filters. It
/// crashes on some or goes on for ever. Tables in one piece hold nothing of that kind and are left
/// out.
void read_all(const std::string& path);

/// `read_all` in a child process. The caller holds a Session.
/// @throws UserError when the child crashed or took too long for a file of that size
void try_to_read(const std::string& path);

}  // namespace fricid::data::hdf5
