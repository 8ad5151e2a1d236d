// The part of a log that a scene uses: all of it, a time interval, some of its joints.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

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

/// The columns of some joints, in their order, by name. The others are welded, those of `welds` at
/// a known position.
/// @throws UserError naming `where` when a joint is not logged, or one of `welds` is elsewhere or
/// moves
Dataset of_joints(const Dataset& dataset, const std::vector<std::string>& joints,
                  const std::map<std::string, double>& welds, const std::string& where);

/// Samples [first, first + length).
Dataset rows_of(const Dataset& dataset, Eigen::Index first, Eigen::Index length);

/// Samples of `dataset` that are those of `other` too, wherever they begin: over 50 rows and more
/// with motion all positions and torques are equal, but for the rounding of an export or a third of
/// their noise, which two measurements of one motion do not share. Of hours, parts of less than a
/// second may be missed. @pre both have the same joints
int samples_in_common(const Dataset& dataset, const Dataset& other);

/// The samples of a part. @throws UserError naming `where` when there are fewer than two
Dataset cut(const Dataset& dataset, const LogPart& part, const std::string& where);

}  // namespace fricid::data
