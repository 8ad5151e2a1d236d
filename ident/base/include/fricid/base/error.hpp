#pragma once

#include <fmt/format.h>

#include <stdexcept>

#include "fricid/base/names.hpp"

namespace fricid {

/// Something the user can fix: a file, an option, a data set. `what()` says
/// where, what was found and what is allowed, in one line, lower case, without a
/// full stop. Never thrown inside a time loop. The program exits with 2.
class UserError : public std::runtime_error {
 public:
  template <class... Args>
  explicit UserError(fmt::format_string<Args...> format, Args&&... args)
      : std::runtime_error(printable(fmt::format(format, std::forward<Args>(args)...))) {}
};

}  // namespace fricid
