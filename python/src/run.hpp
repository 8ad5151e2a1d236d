#pragma once

#include <nanobind/nanobind.h>

namespace fricid::python {

/// The steps of a run: the functions behind fricid.simulate, identify, evaluate.
void bind_run(nanobind::module_& m);

}  // namespace fricid::python
