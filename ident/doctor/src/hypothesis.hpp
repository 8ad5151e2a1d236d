// A mistake in the columns of a log, and how it is undone.
#pragma once

#include <vector>

#include "fricid/system/transmission.hpp"
#include "sight.hpp"

namespace fricid::doctor {

/// A mistake that the log may contain.
struct Hypothesis {
  FindingKind kind;
  bool moves = false, forces = false;  // concerns q v a, concerns tau
  int joint = 0, other = -1;
  double factor = 1;                      // of the column of `joint`, where there is no other
  const Transmission* coupled = nullptr;  // of columns of motors read as those of joints,
  bool at_joints = false;                 // or the other way round
  bool reversed = false;                  // concerns all columns, from the last to the first
  std::vector<int> axes = {};             // several that turn the other way, instead of `joint`

  /// Whether the joint turns the other way than taken.
  bool mirrors() const { return kind == FindingKind::kSign && moves && forces; }
  /// The joints whose columns it concerns.
  std::vector<int> joints() const;

  Sight undone(Sight s) const;

 private:
  void swap(int one, int two, Sight& s) const;
};

/// The finding that says so, over the whole log.
Finding describe(const data::Dataset& d, const Motion& motion, const Hypothesis& h, double size,
                 const std::string& unit);

}  // namespace fricid::doctor
