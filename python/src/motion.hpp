#pragma once

#include <nanobind/nanobind.h>

#include "model.hpp"

namespace fricid::python {

/// A model along a log: Motion of an open loop, Filter and Estimate of the online estimator, and
/// the functions of Model that make them.
void bind_motion(nanobind::module_& m, nanobind::class_<Model>& model);

}  // namespace fricid::python
