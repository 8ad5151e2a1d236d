#include "job.hpp"

#include <nanobind/stl/string.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/progress.hpp"

namespace fricid::python {
namespace {

constexpr std::chrono::milliseconds kSignalPeriod{50};

// Whether this thread is in a Python progress callback.
thread_local bool telling = false;

/// The one job of the process.
std::timed_mutex& turn() {
  static std::timed_mutex mutex;
  return mutex;
}

/// Waits for its turn. @throws nb::python_error when a signal arrives
std::unique_lock<std::timed_mutex> take_turn() {
  std::unique_lock lock(turn(), std::defer_lock);
  for (;;) {
    bool mine = false;
    {
      const nb::gil_scoped_release released;
      mine = lock.try_lock_for(kSignalPeriod);
    }
    if (mine) return lock;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

/// The first exception that Python raised during a job.
class Raised {
 public:
  void keep(nb::python_error&& error) {
    if (!error_) error_.emplace(std::move(error));
    request_stop();
  }
  void raise_if_any() {
    if (error_) throw nb::python_error(std::move(*error_));
  }

 private:
  std::optional<nb::python_error> error_;  // guarded by the interpreter's lock
};

/// Reports progress to a Python function during its lifetime.
class Listening {
 public:
  Listening(const nb::object& progress, Raised& raised) {
    Progress::set_listener([&progress, &raised](const Progress::Report& report) {
      if (progress.is_none()) return;
      const nb::gil_scoped_acquire python;
      telling = true;
      try {
        progress(nb::str(report.stage.data(), report.stage.size()), report.done, report.total,
                 report.seconds, nb::str(report.figure.data(), report.figure.size()));
      } catch (nb::python_error& error) {
        raised.keep(std::move(error));
      }
      telling = false;
    });
  }
  ~Listening() { Progress::set_listener({}); }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;
};

}  // namespace

void do_job(const nb::object& progress, const std::function<void()>& work) {
  if (telling)
    throw UserError("a run cannot start in the progress callback of another; return from it first");
  const std::unique_lock lock = take_turn();
  forget_stop_request();
  Raised raised;
  std::exception_ptr failure;
  {
    const Listening listening(progress, raised);
    std::mutex mutex;
    std::condition_variable condition;
    bool done = false;
    std::thread worker([&] {
      try {
        work();
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard own(mutex);
      done = true;
      condition.notify_one();
    });
    for (bool over = false; !over;) {
      {
        const nb::gil_scoped_release released;
        std::unique_lock own(mutex);
        over = condition.wait_for(own, kSignalPeriod, [&] { return done; });
      }
      if (PyErr_CheckSignals() != 0) raised.keep(nb::python_error());
    }
    worker.join();
  }
  forget_stop_request();
  raised.raise_if_any();
  if (failure) std::rethrow_exception(failure);
}

void say(const std::string& line) {
  const nb::gil_scoped_acquire python;
  try {
    nb::module_::import_("logging").attr("getLogger")("fricid").attr("info")("%s", printable(line));
  } catch (const nb::python_error&) {
    // a failing logging handler must not stop the work
  }
}

}  // namespace fricid::python
