// Files on which the HDF5 library would crash, found out in a process that may.
#pragma once

#include <string>

namespace fricid::data::hdf5 {

/// Reads every attribute and every chunked table of a file in a child process. The library follows
/// lengths and addresses of the file that it does not check, in heaps of texts, indices of chunks
/// and filters, and crashes on some or goes on for ever. Tables in one piece hold nothing of that
/// kind and are left out. The caller holds a Session.
/// @throws UserError when the child crashed or took too long for a file of that size
void try_to_read(const std::string& path);

}  // namespace fricid::data::hdf5
