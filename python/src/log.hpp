#pragma once

#include <nanobind/nanobind.h>

#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"

namespace fricid::python {

/// Names of joints that nobody named: joint_1, joint_2, ...
std::vector<std::string> default_names(int n);

/// Issues each line as a warning of Python. @throws nb::python_error where warnings are errors
void warn(const std::vector<std::string>& warnings);

/// Log: a recording as arrays.
void bind_log(nanobind::module_& m);

}  // namespace fricid::python
