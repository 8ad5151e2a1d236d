#pragma once

#include <string>
#include <utility>

#include "fricid/base/error.hpp"

namespace fricid {

/// Runs several independent tasks, goes on after a failure, and reports the failures at the end.
class Attempts {
 public:
  /// Calls `thing`; a UserError that it throws is kept for `finish`.
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

  /// @throws UserError with the first reason and the number of others, if any task failed
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
