// Parameters with their errors, against the truth.
#pragma once

#include "fricid/base/field.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/model_file.hpp"

namespace fricid::evaluate {

/// Intervals of parameters and how many of them hold the truth.
struct IntervalCount {
  int stated = 0, hold = 0;

  void add(double error, double standard_error);
  void add(const IntervalCount& other);

  template <class Archive>
  void visit(Archive& archive) {
    archive("stated", stated, number("", 0, 1e9, "intervals of 1.645 standard errors"));
    archive("hold", hold, number("", 0, 1e9, "of them, those that hold the truth"));
  }
};

/// Nominal 90 % intervals, value +- 1.645 standard errors, of one or several fits.
struct ParameterIntervals {
  IntervalCount base;      ///< base parameters of the rigid body
  IntervalCount friction;  ///< parameters of laws that the truth has at the same place
  /// Of these stiffness, level and share of single elements of a bank. Elements are exchangeable,
  /// and one may do the work of two: a bank is determined, its elements are only in part.
  IntervalCount elements = {};

  void add(const ParameterIntervals& other);

  template <class Archive>
  void visit(Archive& archive) {
    archive.section("base", base, "base parameters of the rigid body");
    archive.section("friction", friction,
                    "friction parameters of laws that the truth has with as many elements and the "
                    "same modifiers");
    archive.section("elements", elements,
                    "of these stiffness, level and share of single elements of a bank");
  }
};

/// Counts the intervals of a fit. A truth with a linear torque (a counterbalance) that the model
/// lacks has other base parameters: none of these is counted then.
ParameterIntervals count_intervals(const data::ModelFile& model, const data::FitFile& fit,
                                   const Arm& truth);

}  // namespace fricid::evaluate
