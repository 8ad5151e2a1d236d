// Long work on a thread of its own, so that Python can handle signals meanwhile.
#pragma once

#include <nanobind/nanobind.h>

#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace fricid::python {

namespace nb = nanobind;

/// Does `work` without the interpreter's lock, one such job at a time per process, since progress
/// and the stop request are global. Exceptions are passed on; Ctrl-C, and an exception of
/// `progress`, stop the work at its next step and are raised then.
/// @param progress  None, or called with (stage, done, total, seconds, figure) as the work goes on
void do_job(const nb::object& progress, const std::function<void()>& work);

/// The same for work with a result.
template <class Work>
auto job(const nb::object& progress, Work work) {
  std::optional<decltype(work())> result;
  do_job(progress, [&] { result.emplace(work()); });
  return std::move(*result);
}

/// Sends a message of the work to Python's logger "fricid". From any thread.
void say(const std::string& line);

}  // namespace fricid::python
