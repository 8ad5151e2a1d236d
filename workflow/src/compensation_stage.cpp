// The stage that simulates the arm with the friction of models fed forward.
#include <fmt/format.h>

#include <cmath>

#include "fricid/base/files.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/evaluate/compensation.hpp"
#include "fricid/evaluate/constant_friction.hpp"
#include "fricid/sim/closed_loop.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/section.hpp"
#include "loop_models.hpp"

namespace fricid::workflow {
namespace {

using enum Section;

constexpr Section kCompensated[] = {kName,       kSeed,       kRobot,   kFriction,    kPlant,
                                    kController, kExcitation, kSensors, kCompensation};

/// One loop to simulate, and whether its signals are kept.
struct Planned {
  evaluate::LoopScore score;  ///< with all that the signals do not tell
  sim::LoopTask task;
  bool kept;
};

/// Nothing, then every model at every gain, along every path by every controller.
std::vector<Planned> plan(const scene::Problem& problem, const sim::MujocoArm& arm,
                          const std::vector<data::ModelFile>& models) {
  const sim::CompensationOptions& options = problem.scene.compensation;
  std::vector<Planned> loops;
  for (std::size_t p = 0; p < options.sizes.size(); ++p) {
    const sim::Fourier path = sim::random_path(problem, arm, 0, options.sizes[p]);
    for (std::size_t c = 0; c < options.bandwidths_hz.size(); ++c) {
      evaluate::LoopScore score;
      score.model = score.label = evaluate::kNoModel;
      score.controller = static_cast<int>(c);
      score.path = static_cast<int>(p);
      score.bandwidth_hz = options.bandwidths_hz[c];
      score.size = options.sizes[p];
      sim::LoopTask task{.path = path,
                         .controller = problem.scene.controller,
                         .rest_s = options.rest_s,
                         .number = score.path};
      task.controller.bandwidth_hz = score.bandwidth_hz;
      loops.push_back({score, task, true});
      for (const data::ModelFile& model : models) {
        score.model = model.name;
        score.label = model.label;
        for (const double gain : options.gains) {
          score.gain = gain;
          task.forward = sim::FeedForward{
              .friction = model.arm.friction,
              .constant = evaluate::constant_friction(model.arm.robot, problem.robot),
              .gain = gain,
              .drive = options.drive};
          loops.push_back({score, task, gain == options.gains.front()});
        }
      }
    }
  }
  return loops;
}

/// Takes what the signals tell into a score.
void add_scores(const data::LoopSignals& signals, double path_s, int planned_samples,
                evaluate::LoopScore& score) {
  evaluate::LoopScore found = evaluate::score_loop(signals, path_s);
  score.peak_rad_s = found.peak_rad_s;
  score.diverged = signals.t.size() < planned_samples;
  score.reversal_rad = std::move(found.reversal_rad);
  score.sliding_rad = std::move(found.sliding_rad);
  score.feedback_J = found.feedback_J;
  score.limit_cycles = std::move(found.limit_cycles);
}

Done compensate_all(const scene::Problem& problem, const std::vector<FitId>& fits,
                    const RunFolder& visible, const RunFolder& out, int jobs) {
  const sim::MujocoArm arm = sim::make_arm(problem);
  std::vector<Planned> loops = plan(problem, arm, models_for_loops(problem, visible, fits));
  const sim::CompensationOptions& options = problem.scene.compensation;
  const double path_s = loops.front().task.path.period();
  const int samples =
      static_cast<int>(std::lround((path_s + options.rest_s) * problem.scene.sensors.rate_hz));
  const auto file_of = [&](const evaluate::LoopScore& score) {
    return out.loop(score.model, score.path, score.controller);
  };
  Progress progress("compensate", static_cast<double>(loops.size()));
  parallel_for(static_cast<int>(loops.size()), jobs, [&](int i) {
    throw_if_stopped();
    auto& [score, task, kept] = loops[static_cast<std::size_t>(i)];
    data::LoopSignals signals = sim::simulate_loop(problem, arm, task);
    signals.model = task.forward ? score.model : std::string();
    add_scores(signals, path_s, samples, score);
    if (kept) data::save_signals(signals, file_of(score));
    progress.advance(1, score.model);
  });

  evaluate::CompensationFile file{std::string(name_of(options.drive)), path_s, {}};
  Done done;
  for (const Planned& loop : loops) {
    file.loops.push_back(loop.score);
    if (loop.kept) done.files.push_back(file_of(loop.score));
  }
  done.files.push_back(out.compensation_table());
  write_file_atomically(done.files.back(), evaluate::to_markdown(file));
  done.files.push_back(out.compensation());
  data::save(file, done.files.back());
  return done;
}

}  // namespace

Stage compensation_stage(const Job& job) {
  Stage stage{"compensate", Inputs(job.run.folder()), {}};
  declare(stage.inputs, job.problem, kCompensated);
  stage.inputs.text("MJCF", job.mjcf);
  declare_models(stage.inputs, job);
  stage.work = [part = part_of(job.problem, kCompensated), fits = fits_for_loops(job),
                out = job.run.folder(), jobs = job.jobs](const RunFolder& visible) {
    return compensate_all(part, fits, visible, out, jobs);
  };
  return stage;
}

bool compensate(Job& job) {
  if (!job.problem.scene.compensation.wanted()) return false;
  if (!job.run.perform(compensation_stage(job))) job.say("compensate: up to date");
  return true;
}

}  // namespace fricid::workflow
