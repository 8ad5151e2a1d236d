// What the fuzz targets share: a folder of their own, and the judge of what a reader does with a
// damaged file.
#pragma once

#include <stdlib.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>
#include <string_view>

#include "fricid/base/error.hpp"

namespace fricid::fuzz {

/// A new folder in memory, and the current one from here on; goes with the process.
class Folder {
 public:
  Folder() {
    std::string name =
        std::filesystem::is_directory("/dev/shm") ? "/dev/shm/fuzz_XXXXXX" : "/tmp/fuzz_XXXXXX";
    if (::mkdtemp(name.data()) == nullptr || ::chdir(name.c_str()) != 0) std::abort();
    path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

 private:
  std::filesystem::path path_;
};

inline void write(const char* name, std::string_view bytes) {
  std::ofstream(name, std::ios::binary) << bytes;
}

inline std::string_view text_of(const unsigned char* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

[[noreturn]] inline void fail(std::string_view what, std::string_view why) {
  std::fprintf(stderr, "FAILED: %.*s: %.*s\n", static_cast<int>(what.size()), what.data(),
               static_cast<int>(why.size()), why.data());
  std::abort();
}

inline void require_same(std::string_view what, const std::string& one, const std::string& other) {
  if (one != other) fail(what, "\n" + one + "\nbecame\n" + other);
}

/// Runs a reader. It may refuse a file in one line that begins with the name of one of `files`.
/// @return whether it read the file
template <class Read>
bool reads(std::initializer_list<std::string_view> files, Read read) {
  try {
    read();
    return true;
  } catch (const UserError& error) {
    const std::string_view said = error.what();
    for (const std::string_view file : files)
      if (said.starts_with(file)) return false;
    fail("a message that names no file", said);
  }
}

}  // namespace fricid::fuzz
