#pragma once

#include <nanobind/nanobind.h>

namespace fricid::python {

/// The functions behind fricid.check.
void bind_check(nanobind::module_& m);

}  // namespace fricid::python
