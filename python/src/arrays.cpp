#include "arrays.hpp"

#include <nanobind/stl/string.h>

#include <cmath>
#include <optional>
#include <utility>

#include "fricid/base/error.hpp"

namespace fricid::python {
namespace {

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

/// @throws UserError when numpy cannot convert it to numbers
Array doubles(const ArrayLike& array, const char* name) {
  Array found;
  if (nb::try_cast(array.value, found, false)) return found;
  try {
    const nb::object numpy = nb::module_::import_("numpy");
    return nb::cast<Array>(numpy.attr("asarray")(
        array.value, nb::arg("dtype") = numpy.attr("float64"), nb::arg("order") = "C"));
  } catch (const nb::python_error& error) {
    throw UserError("{}: {}; allowed: an array of numbers", name,
                    nb::cast<std::string>(nb::str(error.value())));
  }
}

std::string shape_of(const Array& array) {
  std::string text = "(";
  for (std::size_t i = 0; i < array.ndim(); ++i)
    text += fmt::format("{}{}", i > 0 ? ", " : "", array.shape(i));
  return text + ")";
}

nb::capsule owner_of(RowMatrix* values) {
  return {values, [](void* p) noexcept { delete static_cast<RowMatrix*>(p); }};
}

}  // namespace

Rows::Rows(const ArrayLike& array, const char* name, int width) : array_(doubles(array, name)) {
  is_one_ = array_.ndim() == 1;
  const bool fits = array_.ndim() == 1 || array_.ndim() == 2;
  if (!fits || (width >= 0 && array_.shape(array_.ndim() - 1) != static_cast<std::size_t>(width)))
    throw UserError("{} has the shape {}; allowed: ({}) or (N, {})", name, shape_of(array_),
                    width >= 0 ? std::to_string(width) : "n",
                    width >= 0 ? std::to_string(width) : "n");
  const auto columns = static_cast<Eigen::Index>(array_.shape(array_.ndim() - 1));
  const auto rows = is_one_ ? 1 : static_cast<Eigen::Index>(array_.shape(0));
  new (&rows_) Eigen::Map<const RowMatrix>(array_.data(), rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      if (!std::isfinite(rows_(i, j)))
        throw UserError("{}[{}] = {}; allowed: finite values", name,
                        is_one_ ? fmt::format("{}", j) : fmt::format("{}, {}", i, j), rows_(i, j));
}

Rows::Rows(const double value, int width) : own_(RowMatrix::Constant(1, width, value)) {
  new (&rows_) Eigen::Map<const RowMatrix>(own_.data(), 1, width);
}

RowMatrix samples(const ArrayLike& array, const char* name) {
  const Array found = doubles(array, name);
  if (found.ndim() != 2)
    throw UserError("{} has the shape {}; allowed: (T, n), one row per sample", name,
                    shape_of(found));
  return Eigen::Map<const RowMatrix>(found.data(), static_cast<Eigen::Index>(found.shape(0)),
                                     static_cast<Eigen::Index>(found.shape(1)));
}

RowMatrix one_sample(const ArrayLike& array, const char* name, int n) {
  const Array found = doubles(array, name);
  if (found.ndim() != 1 || found.shape(0) != static_cast<std::size_t>(n))
    throw UserError("{} has the shape {}; allowed: ({})", name, shape_of(found), n);
  return Eigen::Map<const RowMatrix>(found.data(), 1, n);
}

View view(nb::handle owner, const RowMatrix& signal) {
  return {signal.data(),
          {static_cast<std::size_t>(signal.rows()), static_cast<std::size_t>(signal.cols())},
          owner};
}
View view(nb::handle owner, const Eigen::VectorXd& signal) {
  return {signal.data(), {static_cast<std::size_t>(signal.size())}, owner};
}

nb::ndarray<nb::numpy, double> to_numpy(RowMatrix values, bool is_one) {
  auto* kept = new RowMatrix(std::move(values));
  const std::size_t shape[] = {static_cast<std::size_t>(kept->rows()),
                               static_cast<std::size_t>(kept->cols())};
  return {kept->data(), is_one ? 1u : 2u, is_one ? shape + 1 : shape, owner_of(kept)};
}

}  // namespace fricid::python
