#pragma once

#include <nanobind/nanobind.h>

#include <memory>

#include "fricid/data/model_file.hpp"

namespace fricid::python {

/// A model file, shared with what was taken from it.
struct Model {
  std::shared_ptr<const data::ModelFile> file;
};

nanobind::class_<Model> bind_model(nanobind::module_& m);

}  // namespace fricid::python
