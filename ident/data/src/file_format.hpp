// Formats of files and their versions.
#pragma once

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "fricid/base/error.hpp"

namespace fricid::data {

/// "fricid.model/2": name and version, 0 without one.
struct FileFormat {
  std::string_view name;
  int version = 0;

  explicit FileFormat(std::string_view text) {
    const std::size_t slash = std::min(text.rfind('/'), text.size());
    name = text.substr(0, slash);
    if (slash < text.size())
      std::from_chars(text.data() + slash + 1, text.data() + text.size(), version);
  }
};

/// @throws UserError where a file is of a later version than the one that is read
inline void refuse_newer(const std::string& file, std::string_view found, std::string_view known) {
  if (FileFormat(found).name == FileFormat(known).name &&
      FileFormat(found).version > FileFormat(known).version)
    throw UserError("{}: format {} is newer than {}, which this program reads", file, found, known);
}

}  // namespace fricid::data
