// Log: the signals of a recording, from arrays or files.
#include "log.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <utility>

#include "arrays.hpp"
#include "fricid/base/error.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_part.hpp"

namespace fricid::python {
namespace {

namespace fs = std::filesystem;
using data::Dataset;

/// @throws UserError when a signal has another shape than q
RowMatrix of_shape(const std::optional<ArrayLike>& array, const char* name, const RowMatrix& q) {
  if (!array) return {};
  RowMatrix values = samples(*array, name);
  if (values.rows() != q.rows() || values.cols() != q.cols())
    throw UserError("{} has the shape ({}, {}); allowed: ({}, {}), as q", name, values.rows(),
                    values.cols(), q.rows(), q.cols());
  return values;
}

Dataset make_log(const ArrayLike& q, const ArrayLike& tau, double rate_hz,
                 const std::optional<ArrayLike>& v, const std::optional<ArrayLike>& temperature,
                 std::optional<std::vector<std::string>> joint_names, std::string name) {
  Dataset d;
  d.name = std::move(name);
  d.source = "arrays";
  if (!(rate_hz > 0)) throw UserError("rate_hz = {}; allowed: above 0 Hz", rate_hz);
  d.rate_hz = rate_hz;
  d.q = samples(q, "q");
  d.tau = of_shape(tau, "tau", d.q);
  d.v = of_shape(v, "v", d.q);
  d.temperature = of_shape(temperature, "temperature", d.q);
  d.t = Eigen::VectorXd::LinSpaced(d.q.rows(), 0, static_cast<double>(d.q.rows() - 1) / rate_hz);
  if (joint_names && std::ssize(*joint_names) != d.n())
    throw UserError("joint_names: {} names; allowed: {}, one per column of q", joint_names->size(),
                    d.n());
  d.joint_names = joint_names ? std::move(*joint_names) : default_names(d.n());
  warn(data::check_dataset(d, d.name));
  return d;
}

std::optional<View> optional_view(nb::handle log, const RowMatrix& signal) {
  return signal.size() > 0 ? std::optional(view(log, signal)) : std::nullopt;
}
const Dataset& of(nb::handle log) { return nb::cast<const Dataset&>(log); }

}  // namespace

void warn(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw nb::python_error();
}

std::vector<std::string> default_names(int n) {
  std::vector<std::string> names;
  for (int j = 0; j < n; ++j) names.push_back(fmt::format("joint_{}", j + 1));
  return names;
}

void bind_log(nb::module_& m) {
  using nb::literals::operator""_a;
  nb::class_<Dataset>(
      m, "Log",
      "The signals of a recording: T samples of n joints. tau is held until the next sample; "
      "missing values are NaN.")
      .def(
          "__init__",
          [](Dataset* self, const ArrayLike& q, const ArrayLike& tau, double rate_hz,
             const std::optional<ArrayLike>& v, const std::optional<ArrayLike>& temperature,
             std::optional<std::vector<std::string>> joint_names, std::string name) {
            new (self) Dataset(
                make_log(q, tau, rate_hz, v, temperature, std::move(joint_names), std::move(name)));
          },
          "q"_a, "tau"_a, "rate_hz"_a, nb::kw_only(), "v"_a = nb::none(),
          "temperature"_a = nb::none(), "joint_names"_a = nb::none(), "name"_a = "log",
          "q (T, n) [rad], tau (T, n) [N m], v (T, n) [rad/s], temperature (T, n) [K].")
      .def_static("load", &data::load_dataset, "path"_a,
                  "A data set (HDF5), such as those in data/ of a run.")
      .def_static(
          "read",
          [](const fs::path& path, const fs::path& contract) {
            std::vector<std::string> warnings;
            Dataset log =
                data::import_log(path, data::load_contract(contract),
                                 [&](const std::string& warning) { warnings.push_back(warning); });
            warn(warnings);
            warn(data::check_dataset(log, path.string()));
            return log;
          },
          "path"_a, "contract"_a, "A log of another program, read by its contract.")
      .def(
          "save", [](const Dataset& log, const fs::path& path) { data::save_dataset(log, path); },
          "path"_a, "Writes a data set (HDF5).")
      .def(
          "of_joints",
          [](const Dataset& log, const std::vector<std::string>& joint_names) {
            return data::of_joints(log, joint_names, {}, log.name);
          },
          "joint_names"_a, "The log with its joints in this order.")
      .def_ro("name", &Dataset::name, "\"train_0\", \"validation_0\" in a run.")
      .def_ro("source", &Dataset::source, "Where the signals are from.")
      .def_ro("joint_names", &Dataset::joint_names, "In the order of the columns.")
      .def_ro("rate_hz", &Dataset::rate_hz, "Samples per second [Hz].")
      .def_prop_ro("n", &Dataset::n, "Number of joints.")
      .def("__len__", &Dataset::length, "Number of samples.")
      .def_prop_ro(
          "t", [](nb::handle log) { return view(log, of(log).t); }, "(T) [s]")
      .def_prop_ro(
          "q", [](nb::handle log) { return view(log, of(log).q); }, "Positions (T, n) [rad].")
      .def_prop_ro(
          "tau", [](nb::handle log) { return view(log, of(log).tau); },
          "Motor torques (T, n) [N m].")
      .def_prop_ro(
          "v", [](nb::handle log) { return optional_view(log, of(log).v); },
          "Measured velocities (T, n) [rad/s], if there are any.")
      .def_prop_ro(
          "temperature", [](nb::handle log) { return optional_view(log, of(log).temperature); },
          "(T, n) [K], if measured.")
      .def("__repr__", [](const Dataset& log) {
        return fmt::format("<fricid.Log {}: {} samples of {} joints at {:g} Hz>", log.name,
                           log.length(), log.n(), log.rate_hz);
      });
}

}  // namespace fricid::python
