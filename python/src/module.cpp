// The module fricid._core: models, runs and exceptions of fricid in Python.
#include <nanobind/nanobind.h>

#include <exception>
#include <filesystem>

#include "check.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/progress.hpp"
#include "log.hpp"
#include "model.hpp"
#include "motion.hpp"
#include "run.hpp"

namespace fricid::python {
namespace {

namespace nb = nanobind;

/// A class of the package's errors, for as long as the process lives.
PyObject* error_class(const char* name) {
  return nb::object(nb::module_::import_("fricid._errors").attr(name)).release().ptr();
}

/// Errors become exceptions of the package with the program's messages; other types are left to
/// nanobind.
void translate(const std::exception_ptr& error, void* /*payload*/) {
  static PyObject* const user_error = error_class("UserError");
  static PyObject* const failure = error_class("Failure");
  const auto set = [](PyObject* kind, const std::string& text) {
    PyErr_SetString(kind, printable(text).c_str());
  };
  try {
    std::rethrow_exception(error);
  } catch (const UserError& e) {
    set(user_error, e.what());
  } catch (const std::filesystem::filesystem_error& e) {
    set(user_error, e.path1().string() + ": " + e.code().message());
  } catch (const Stopped&) {
    set(PyExc_KeyboardInterrupt, "stopped; the same call goes on from here");
  } catch (const std::logic_error& e) {
    set(failure, std::string("unexpected failure: ") + e.what());
  }
}

}  // namespace
}  // namespace fricid::python

NB_MODULE(_core, m) {
  m.doc() = "fricid in C++; use the package fricid.";
  nanobind::register_exception_translator(&fricid::python::translate);
  fricid::python::bind_log(m);
  auto model = fricid::python::bind_model(m);
  fricid::python::bind_motion(m, model);
  fricid::python::bind_check(m);
  fricid::python::bind_run(m);
}
