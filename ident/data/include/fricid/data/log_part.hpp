// A log named in a scene: a file, or a time interval of one.
#pragma once

#include <limits>
#include <string>

#include "fricid/data/dataset.hpp"

namespace fricid::data {

/// "log.csv", or "log.csv[10:20]" for the samples from 10 s on and before 20 s, counted from the
/// first; either end may be left out.
struct LogPart {
  std::string file;
  double from_s = 0;
  double to_s = std::numeric_limits<double>::infinity();

  bool overlaps(const LogPart& other) const { return from_s < other.to_s && other.from_s < to_s; }
};

/// @throws UserError unless from < to, both numbers
LogPart log_part(const std::string& text);

/// The samples of a part. @throws UserError naming `where` when there are fewer than two
Dataset cut(const Dataset& dataset, const LogPart& part, const std::string& where);

}  // namespace fricid::data
