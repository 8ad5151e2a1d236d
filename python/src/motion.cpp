// Open loops and the online filter of a model.
#include "motion.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "arrays.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/estimate/memory.hpp"
#include "fricid/estimate/online/online_log.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/evaluate/options.hpp"
#include "fricid/evaluate/rollout_of_log.hpp"
#include "fricid/system/transmission.hpp"
#include "fricid/workflow/check.hpp"
#include "job.hpp"
#include "log.hpp"

namespace fricid::python {
namespace {

using Vector = nb::ndarray<nb::numpy, double>;
using OptionalArray = std::optional<ArrayLike>;

evaluate::RolloutOptions rollout_options() {
  evaluate::RolloutOptions options;
  options.step.substeps = evaluate::EvaluateOptions{}.substeps;
  options.diverged_rad = evaluate::EvaluateOptions{}.diverged_rad;
  return options;
}

/// A time as a number of samples. @throws UserError when it is not a whole number
int samples_in(double seconds, const data::Dataset& log, const char* name) {
  const double count = std::round(seconds * log.rate_hz);
  if (!(count >= 0 && count <= log.length() - 1))
    throw UserError("{}: {} = {} s; allowed: 0 to {:.6g} s", log.name, name, seconds,
                    (log.length() - 1) / log.rate_hz);
  return static_cast<int>(count);
}

/// An open loop and its times.
struct Motion {
  evaluate::Rollout rollout;
  Eigen::VectorXd t;

  Motion(evaluate::Rollout a_rollout, double begin_s, double dt)
      : rollout(std::move(a_rollout)),
        t(Eigen::VectorXd::LinSpaced(rollout.q.rows(), begin_s,
                                     begin_s + dt * static_cast<double>(rollout.q.rows() - 1))) {}
};
const Motion& of(nb::handle motion) { return nb::cast<const Motion&>(motion); }

/// The log with its joints in the order of the model; names that nobody gave are those of its
/// order.
data::Dataset for_model(const data::Dataset& log, const data::ModelFile& file) {
  const dynamics::RobotModel& robot = file.arm.robot;
  const bool unnamed = log.joint_names == default_names(log.n()) && log.n() == robot.n() &&
                       std::ranges::none_of(robot.joints, [&](const dynamics::Joint& joint) {
                         return std::ranges::count(log.joint_names, joint.name) > 0;
                       });
  return unnamed ? log : workflow::joints_of(log, robot, "model " + file.name, log.name);
}

/// Says which samples an open loop takes as straight lines between others.
void warn_of_missing(const data::Dataset& log, int begin, int steps) {
  const auto missing = [&](const RowMatrix& signal, int first, int count) {
    int rows = 0;
    for (int k = first; k < first + count; ++k) rows += !signal.row(k).allFinite();
    return rows;
  };
  const int torques = missing(log.tau, begin, steps), positions = missing(log.q, begin, 1);
  if (torques + positions == 0) return;
  warn({fmt::format("{}: {}{}{} missing; the open loop takes values between those beside", log.name,
                    positions > 0 ? "its first position" : "",
                    positions > 0 && torques > 0 ? " and " : "",
                    torques > 0 ? fmt::format("{} of {} torques", torques, steps) : "")});
}

Motion rollout(const Model& model, const data::Dataset& given, double start_s,
               std::optional<double> seconds, double cutoff_hz, const nb::object& progress) {
  const data::Dataset log = for_model(given, *model.file);
  const int begin = samples_in(start_s, log, "start_s");
  const int steps = seconds ? samples_in(*seconds, log, "seconds") : log.length() - 1 - begin;
  warn_of_missing(log, begin, steps);
  return job(progress, [&] {
    return Motion(
        evaluate::roll_out_log(*model.file, log, cutoff_hz, begin, steps, rollout_options()),
        begin * log.dt(), log.dt());
  });
}

/// The arm under a torque, from a state.
Motion simulate(const Model& model, const ArrayLike& tau, double rate_hz, const ArrayLike& q,
                const OptionalArray& v, const OptionalArray& z, const OptionalArray& temperature,
                const nb::object& progress) {
  const int n = model.file->arm.robot.n();
  const int states = model.file->arm.friction.model.state_size();
  if (!(rate_hz > 0)) throw UserError("rate_hz = {}; allowed: above 0 Hz", rate_hz);
  const Rows torque(tau, "tau", n),
      warmth = temperature ? Rows(*temperature, "temperature", n) : Rows(kRoomTemperature, n);
  const Rows first_q(q, "q", n), first_v = v ? Rows(*v, "v", n) : Rows(0, n);
  const Rows first_z = z ? Rows(*z, "z", states) : Rows(0, states);
  const Eigen::Index T = torque.count();
  if (T == 0) throw UserError("tau has 0 rows; allowed: 1 or more");
  for (const auto& [name, rows] : {std::pair{"q", &first_q}, {"v", &first_v}, {"z", &first_z}})
    if (rows->count() != 1)
      throw UserError("{} has {} rows; allowed: one state", name, rows->count());
  if (warmth.count() != 1 && warmth.count() != T)
    throw UserError("temperature has {} rows; allowed: 1 or {}, as tau has", warmth.count(), T);

  evaluate::Trajectory trajectory;
  data::Dataset& d = trajectory.data;
  d.name = "tau";
  d.rate_hz = rate_hz;
  d.t = Eigen::VectorXd::LinSpaced(T + 1, 0, static_cast<double>(T) / rate_hz);
  // torque is held over a sample: the last one up to the state after it
  d.tau.resize(T + 1, n);
  d.tau << torque.matrix(), torque.matrix().bottomRows(1);
  d.temperature = warmth.matrix().row(0).replicate(T + 1, 1);
  if (warmth.count() == T && T > 1) d.temperature.topRows(T) = warmth.matrix();
  d.q = RowMatrix::Constant(T + 1, n, std::nan(""));  // no measured position
  trajectory.q = first_q.matrix().replicate(T + 1, 1);
  trajectory.v = first_v.matrix().replicate(T + 1, 1);
  const evaluate::Start start{.trajectory = 0, .begin = 0, .steps = static_cast<int>(T)};
  const std::vector<double> z0(first_z.row(0), first_z.row(0) + states);
  return job(progress, [&] {
    const evaluate::OpenLoop loop{&model.file->arm, &trajectory, start, z0};
    std::vector<evaluate::Rollout> one = evaluate::roll_out({&loop, 1}, rollout_options());
    return Motion(std::move(one.front()), 0, 1 / rate_hz);
  });
}

/// The online filter of a model.
class Filter {
 public:
  Filter(const Model& model, const ArrayLike& q, double rate_hz, int particles, std::uint64_t seed,
         const OptionalArray& tau)
      : n_(model.file->arm.robot.n()),
        filter_(begin(model, Rows(q, "q", n_), rate_hz, particles, seed,
                      tau ? Rows(*tau, "tau", n_) : Rows(0, 0))) {}

  const estimate::OnlineEstimate& update(const ArrayLike& q, const ArrayLike& tau,
                                         const OptionalArray& temperature) {
    const RowMatrix y = one_sample(q, "q", n_);
    const Rows torque(tau, "tau", n_);
    const Rows warmth = temperature ? Rows(*temperature, "temperature", n_) : Rows(0, 0);
    for (const auto& [name, rows] : {std::pair{"tau", &torque}, {"temperature", &warmth}})
      if (rows->count() != 1)
        throw UserError("{} has {} rows; allowed: one sample", name, rows->count());
    const auto span = [](const double* data, Eigen::Index size) {
      return std::span(data, static_cast<std::size_t>(size));
    };
    return filter_.step(span(torque.row(0), n_), span(y.data(), n_),
                        span(warmth.row(0), warmth.matrix().cols()));
  }

  const estimate::OnlineEstimate& now() const { return filter_.estimate(); }
  void reset() { filter_.reset(); }

 private:
  static estimate::OnlineEstimator begin(const Model& model, const Rows& q, double rate_hz,
                                         int particles, std::uint64_t seed, const Rows& tau) {
    const bool stands = tau.matrix().size() == 0;
    if (stands && q.count() != 1)
      throw UserError("q has {} rows; allowed: one position, or more with tau", q.count());
    if (!stands && tau.count() != q.count())
      throw UserError("tau has {} rows; allowed: {}, as q has", tau.count(), q.count());
    if (particles < 1 || particles > 1'000'000)
      throw UserError("particles = {}; allowed: 1 to 1000000", particles);
    require_within(limits::kSeed, seed, "seed");
    const int states = 2 * model.file->arm.robot.n() + model.file->arm.friction.model.state_size();
    require_memory(2 * estimate::memory_of_filter(particles, states), "filter",
                   fmt::format("{} particles", particles));
    if (Transmission(model.file->arm.robot).coupled())
      throw UserError("model {}: its motors are coupled; allowed: estimate() of a whole log",
                      model.file->name);
    estimate::OnlineOptions options;
    options.particles = particles;
    options.seed = seed;
    const estimate::LogStart start =
        stands ? estimate::LogStart{.q = q.matrix().row(0).transpose()}
               : estimate::log_start(model.file->arm, 1 / rate_hz, q.matrix(), tau.matrix(),
                                     RowMatrix());
    return estimate::begin_online(*model.file, start, rate_hz, options, "filter");
  }
  int n_;
  estimate::OnlineEstimator filter_;
};

const estimate::OnlineEstimate& known(nb::handle estimate) {
  return nb::cast<const estimate::OnlineEstimate&>(estimate);
}

}  // namespace

void bind_motion(nb::module_& m, nb::class_<Model>& model) {
  using nb::literals::operator""_a;
  using estimate::OnlineEstimate;

  nb::class_<Motion>(m, "Motion", "An open loop: the motion of a model driven by a torque.")
      .def_prop_ro(
          "t", [](nb::handle o) { return view(o, of(o).t); }, "(T) [s]")
      .def_prop_ro(
          "q", [](nb::handle o) { return view(o, of(o).rollout.q); }, "(T, n) [rad]")
      .def_prop_ro(
          "v", [](nb::handle o) { return view(o, of(o).rollout.v); }, "(T, n) [rad/s]")
      .def_prop_ro(
          "tau_f", [](nb::handle o) { return view(o, of(o).rollout.tau_f); },
          "Friction torque (T, n) [N m].")
      .def_prop_ro(
          "diverged", [](const Motion& o) { return o.rollout.diverged; },
          "Departed from the log by more than 10 rad; constant from there.");

  nb::class_<OnlineEstimate>(m, "Estimate",
                             "Estimate after a sample: means, and standard deviations (_sd).")
      .def_prop_ro(
          "q", [](nb::handle e) { return view(e, known(e).q); }, "(n) [rad]")
      .def_prop_ro(
          "v", [](nb::handle e) { return view(e, known(e).v); }, "(n) [rad/s]")
      .def_prop_ro(
          "z", [](nb::handle e) { return view(e, known(e).z); },
          "States of the friction (state_size).")
      .def_prop_ro(
          "tau_f", [](nb::handle e) { return view(e, known(e).tau_f); },
          "Friction torque (n) [N m].")
      .def_prop_ro(
          "q_sd", [](nb::handle e) { return view(e, known(e).q_sd); },
          "Standard deviation of q (n) [rad].")
      .def_prop_ro(
          "v_sd", [](nb::handle e) { return view(e, known(e).v_sd); },
          "Standard deviation of v (n) [rad/s].")
      .def_prop_ro(
          "z_sd", [](nb::handle e) { return view(e, known(e).z_sd); },
          "Standard deviation of z (state_size).")
      .def_prop_ro(
          "tau_f_sd", [](nb::handle e) { return view(e, known(e).tau_f_sd); },
          "Standard deviation of tau_f (n) [N m].")
      .def_ro("log_likelihood", &OnlineEstimate::log_likelihood, "Of all samples so far [nat].")
      .def_ro("ess", &OnlineEstimate::ess, "Effective number of particles.")
      .def_ro("lost", &OnlineEstimate::lost,
              "No particle explained the sample: the filter shifted all to the measured motion.");

  nb::class_<Filter>(m, "Filter", "The online filter of a model: one sample in, states out.")
      .def("update", &Filter::update, nb::rv_policy::copy, "q"_a, "tau"_a,
           "temperature"_a = nb::none(),
           "Advances by one sample: tau (n) [N m] was held since the last one, q (n) [rad] is the "
           "present position, NaN if missing.")
      .def_prop_ro("estimate", &Filter::now, nb::rv_policy::copy, "The present estimate.")
      .def("reset", &Filter::reset, "Restarts with the same random numbers.");

  model
      .def("rollout", &rollout, "log"_a, "start_s"_a = 0.0, "seconds"_a = nb::none(),
           "cutoff_hz"_a = estimate::RigidBodyOptions{}.cutoff_hz, nb::kw_only(),
           "progress"_a = nb::none(),
           "Open loop under the torque of a log, as an evaluation does it: from the filtered "
           "position and velocity at start_s, friction washed out by the motion before.")
      .def("simulate", &simulate, "tau"_a, "rate_hz"_a, "q"_a, "v"_a = nb::none(),
           "z"_a = nb::none(), "temperature"_a = nb::none(), nb::kw_only(),
           "progress"_a = nb::none(),
           "Open loop under a torque (T, n) [N m], each row held for a sample, from position q, "
           "velocity v and friction states z (zero if not given). T + 1 samples.")
      .def(
          "filter",
          [](const Model& self, const ArrayLike& q, double rate_hz, int particles,
             std::uint64_t seed, const OptionalArray& tau) {
            return new Filter(self, q, rate_hz, particles, seed, tau);
          },
          "q"_a, "rate_hz"_a, "particles"_a = estimate::OnlineOptions{}.particles,
          "seed"_a = estimate::OnlineOptions{}.seed, nb::kw_only(), "tau"_a = nb::none(),
          "The online filter, from rest at q (n) [rad]; needs a model with noise. With tau, q and "
          "tau are the first .1 s of a log, (T, n) each [rad], [N m]: it begins at the first "
          "sample with the velocity and the friction that these say.");
}

}  // namespace fricid::python
