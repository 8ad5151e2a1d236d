// The stage that pushes the simulated arm and scores what observers make of it.
#include <fmt/format.h>

#include <cmath>

#include "fricid/base/files.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/estimate/contact/contact_log.hpp"
#include "fricid/evaluate/contact.hpp"
#include "fricid/sim/closed_loop.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/section.hpp"
#include "loop_models.hpp"

namespace fricid::workflow {
namespace {

using enum Section;

constexpr Section kPushed[] = {kName,       kSeed,       kRobot,   kFriction, kPlant,
                               kController, kExcitation, kSensors, kContact};
constexpr int kQuietPeriods = 4;    // of each path without contact
constexpr double kPushEvery = 1.5;  // [s]

/// A model and what filters its friction; 0: nothing.
struct Observer {
  data::ModelFile model;
  int particles = 0;
};

/// Every model alone, then with particles those that say how noisy they are.
std::vector<Observer> observers_of(const sim::ContactOptions& options,
                                   const std::vector<data::ModelFile>& models) {
  std::vector<Observer> observers;
  for (const data::ModelFile& model : models) observers.push_back({model, 0});
  if (options.particles > 0)
    for (const data::ModelFile& model : models)
      if (model.noise) observers.push_back({model, options.particles});
  return observers;
}

/// A recording, its truth, and what every observer makes of it.
struct Felt {
  data::LoopSignals loop;
  std::vector<data::ContactSignals> estimates;
};

Felt feel(const scene::Problem& problem, const sim::MujocoArm& arm, const sim::LoopTask& task,
          const std::vector<Observer>& observers) {
  Felt felt{sim::simulate_loop(problem, arm, task), {}};
  const data::Dataset log = sim::log_of(felt.loop, problem, task.number);
  for (const Observer& observer : observers)
    felt.estimates.push_back(
        estimate::observe_log(observer.model, log,
                              {.bandwidth_hz = problem.scene.contact.bandwidth_hz,
                               .particles = observer.particles,
                               .seed = static_cast<std::uint64_t>(task.number)}));
  return felt;
}

/// The rows after the observers' first moments.
ConstRowMatrix after_warm_up(const RowMatrix& signal, double rate_hz) {
  return signal.bottomRows(
      std::max<Eigen::Index>(0, signal.rows() - std::lround(evaluate::kContactWarmUp * rate_hz)));
}

/// The motion of recording `number` of the stage, each along a path of its own.
sim::LoopTask task_of(const scene::Problem& problem, const sim::MujocoArm& arm, int number) {
  return {.path = sim::random_path(problem, arm, 1 + number, problem.scene.contact.size),
          .controller = problem.scene.controller,
          .number = 1 + number};
}

/// What every observer saw in hours without contact.
std::vector<evaluate::QuietTorque> listen(const scene::Problem& problem, const sim::MujocoArm& arm,
                                          const std::vector<Observer>& observers, int count,
                                          int jobs) {
  std::vector<std::vector<evaluate::QuietTorque>> parts(static_cast<std::size_t>(count));
  Progress progress("without contact", count);
  parallel_for(count, jobs, [&](int i) {
    throw_if_stopped();
    sim::LoopTask task = task_of(problem, arm, i);
    task.periods = kQuietPeriods;
    auto& part = parts[static_cast<std::size_t>(i)];
    const double rate = problem.scene.sensors.rate_hz;
    for (const data::ContactSignals& estimate : feel(problem, arm, task, observers).estimates)
      part.emplace_back().add(after_warm_up(estimate.tau_ext, rate), rate);
    progress.advance(1);
  });
  std::vector<evaluate::QuietTorque> quiet(observers.size());
  for (const auto& part : parts)
    for (std::size_t m = 0; m < observers.size(); ++m) quiet[m].add(part[m]);
  return quiet;
}

Done find_contact_in_all(const scene::Problem& problem, const std::vector<FitId>& fits,
                         const RunFolder& visible, const RunFolder& out, int jobs) {
  const sim::ContactOptions& options = problem.scene.contact;
  const double rate = problem.scene.sensors.rate_hz,
               period = 2 * std::numbers::pi / problem.scene.excitation.base_rad_s;
  const sim::MujocoArm arm = sim::make_arm(problem);
  const std::vector<Observer> observers =
      observers_of(options, models_for_loops(problem, visible, fits));

  evaluate::ContactFile file;
  file.bandwidth_hz = options.bandwidth_hz;
  const double counted = kQuietPeriods * period - evaluate::kContactWarmUp;  // of a recording [s]
  const int quiet_count = static_cast<int>(std::ceil(3600 * options.hours / counted));
  const auto quiet = listen(problem, arm, observers, quiet_count, jobs);
  file.hours = quiet.front().hours();
  for (std::size_t m = 0; m < observers.size(); ++m) {
    const auto& [model, particles] = observers[m];
    evaluate::ContactScore& score = file.models.emplace_back();
    score.model = model.name;
    score.label = particles > 0 ? model.label + " (particles)" : model.label;
    score.method = particles > 0 ? evaluate::kParticles : evaluate::kObserver;
    score.threshold_sd = quiet[m].threshold();
    for (const double sd : quiet[m].sd()) {
      score.sd_Nm.push_back(sd);
      score.threshold_Nm.push_back(score.threshold_sd * sd);
    }
  }

  // pushes, recording by recording
  const int length = static_cast<int>(std::lround(period * rate));
  const int warm_up = static_cast<int>(std::lround(evaluate::kContactWarmUp * rate));
  const int in_each =
      std::max(1, static_cast<int>((period - evaluate::kContactWarmUp) / kPushEvery));
  const int recordings = (options.pushes + in_each - 1) / in_each;
  std::vector<evaluate::TorqueErrors> errors(observers.size());
  Done done;
  for (std::size_t f = 0; f < options.forces_N.size(); ++f) {
    std::vector<Felt> felt(static_cast<std::size_t>(recordings));
    std::vector<std::vector<evaluate::PushSpan>> spans(felt.size());
    Progress progress("pushes", recordings);
    parallel_for(recordings, jobs, [&](int i) {
      throw_if_stopped();
      const int number = quiet_count + static_cast<int>(f) * recordings + i;
      sim::LoopTask task = task_of(problem, arm, number);
      task.pushes =
          sim::random_pushes(problem, number, std::min(in_each, options.pushes - i * in_each),
                             warm_up, length, options.forces_N[f], options.push_s);
      for (const sim::Push& push : task.pushes)
        spans[static_cast<std::size_t>(i)].push_back({push.begin, push.end});
      felt[static_cast<std::size_t>(i)] = feel(problem, arm, task, observers);
      progress.advance(1);
    });
    file.joint_names = felt.front().loop.joint_names;
    for (std::size_t m = 0; m < observers.size(); ++m) {
      std::vector<double> delays;
      for (std::size_t i = 0; i < felt.size(); ++i) {
        const RowMatrix& estimate = felt[i].estimates[m].tau_ext;
        errors[m].add(after_warm_up(estimate, rate), after_warm_up(felt[i].loop.tau_ext, rate),
                      after_warm_up(felt[i].loop.v_desired, rate), 1 / rate);
        const auto own = evaluate::delays(estimate, spans[i], rate, file.models[m].threshold_Nm);
        delays.insert(delays.end(), own.begin(), own.end());
      }
      file.models[m].forces.push_back(evaluate::score_pushes(options.forces_N[f], delays));
      if (f > 0 || observers[m].particles > 0) continue;
      done.files.push_back(out.external_torque(observers[m].model.name));
      data::save_signals(felt.front().estimates[m], done.files.back());
    }
    if (f > 0) continue;
    done.files.push_back(out.pushed_loop());
    data::save_signals(felt.front().loop, done.files.back());
  }
  for (std::size_t m = 0; m < observers.size(); ++m) errors[m].write(file.models[m]);

  done.files.push_back(out.contact_table());
  write_file_atomically(done.files.back(), evaluate::to_markdown(file));
  done.files.push_back(out.contact());
  data::save(file, done.files.back());
  return done;
}

}  // namespace

Stage contact_stage(const Job& job) {
  Stage stage{"contact", Inputs(job.run.folder()), {}};
  declare(stage.inputs, job.problem, kPushed);
  stage.inputs.text("MJCF", job.mjcf);
  declare_models(stage.inputs, job);
  stage.work = [part = part_of(job.problem, kPushed), fits = fits_for_loops(job),
                out = job.run.folder(), jobs = job.jobs](const RunFolder& visible) {
    return find_contact_in_all(part, fits, visible, out, jobs);
  };
  return stage;
}

bool feel_contacts(Job& job) {
  if (!job.problem.scene.contact.wanted()) return false;
  if (!job.run.perform(contact_stage(job))) job.say("contact: up to date");
  return true;
}

}  // namespace fricid::workflow
