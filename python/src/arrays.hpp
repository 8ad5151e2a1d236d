// Arrays of numpy as rows of samples or of a batch, in and out.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <string>

#include "fricid/signals/matrix.hpp"

namespace fricid::python {

namespace nb = nanobind;

/// Anything that numpy converts to an array of numbers.
struct ArrayLike {
  nb::object value;
};

/// A read-only (n) or (N, n) array of doubles. Arrays of doubles in C order are not copied.
class Rows {
 public:
  /// @param name   for messages
  /// @param width  n, the number of columns, or -1: any
  /// @throws UserError when the shape is another or a value is not finite
  Rows(const ArrayLike& array, const char* name, int width);

  /// One row for the whole batch.
  Rows(const double value, int width);

  Eigen::Index count() const { return rows_.rows(); }
  bool is_one() const { return is_one_; }  ///< given as (n)
  /// Row i of a batch; the single row if `is_one`.
  const double* row(Eigen::Index i) const { return rows_.row(count() == 1 ? 0 : i).data(); }
  Eigen::Map<const RowMatrix> matrix() const { return rows_; }

 private:
  nb::ndarray<const double, nb::c_contig, nb::device::cpu> array_;
  RowMatrix own_;
  Eigen::Map<const RowMatrix> rows_{nullptr, 0, 0};
  bool is_one_ = true;
};

/// Samples (T, n), NaN where a value is missing. @throws UserError on another shape
RowMatrix samples(const ArrayLike& array, const char* name);
/// One sample (n) as a row, NaN where a value is missing. @throws UserError on another shape
RowMatrix one_sample(const ArrayLike& array, const char* name, int n);

/// A read-only view of a signal in a Python object, which it keeps alive.
using View = nb::ndarray<nb::numpy, const double>;
View view(nb::handle owner, const RowMatrix& signal);
View view(nb::handle owner, const Eigen::VectorXd& signal);

/// A new array that owns the numbers; of the first row alone where `is_one`.
nb::ndarray<nb::numpy, double> to_numpy(RowMatrix values, bool is_one = false);

}  // namespace fricid::python

namespace nanobind::detail {

template <>
struct type_caster<fricid::python::ArrayLike> {
  NB_TYPE_CASTER(fricid::python::ArrayLike, const_name("numpy.typing.ArrayLike"))
  bool from_python(handle source, uint8_t /*flags*/, cleanup_list* /*cleanup*/) noexcept {
    value.value = borrow(source);
    return true;
  }
};

}  // namespace nanobind::detail
