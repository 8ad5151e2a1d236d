#pragma once

#include <nanobind/nanobind.h>

#include "fricid/data/dataset.hpp"

namespace fricid::python {

/// Log: a recording as arrays.
void bind_log(nanobind::module_& m);

}  // namespace fricid::python
