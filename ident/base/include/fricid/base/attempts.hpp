#pragma once

#include <string>
#include <utility>

#include "fricid/base/error.hpp"

namespace fricid {

/// Does what can be done of several things, and says in the end what could not.
class Attempts {
 public:
  /// Calls `thing`; a UserError of it is kept for `finish`.
  template <class Thing>
  void try_to(Thing&& thing) {
    try {
      std::forward<Thing>(thing)();
    } catch (const UserError& error) {
      const std::string reason = error.what();
      if (first_.empty())
        first_ = reason;
      else if (reason != first_)
        ++others_;
    }
  }

  /// @throws UserError with the first reason, and how many others there are, unless all was done
  void finish() const {
    if (first_.empty()) return;
    if (others_ == 0) throw UserError("{}", first_);
    throw UserError("{}; {} more likewise", first_, others_);
  }

 private:
  std::string first_;
  int others_ = 0;
};

}  // namespace fricid
