// The stage that evaluates fits: gathers held-out data, truth and models; scoring is evaluate's.
#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include <span>

#include "fitted_model.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/training_part.hpp"
#include "fricid/estimate/rigid_body/held_out.hpp"
#include "fricid/evaluate/evaluate.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/recordings.hpp"
#include "fricid/workflow/section.hpp"
#include "held_out.hpp"

namespace fricid::workflow {
namespace {

namespace fs = std::filesystem;
using enum Section;

constexpr Section kEvaluated[] = {kName, kRobot, kFriction, kPlant, kIdentify, kEvaluate};

/// Input of the stage's work: the declared part of the scene, and the fits to evaluate.
struct Task {
  scene::Problem problem;
  std::vector<FitRequest> fits;
  std::vector<FurtherData> further_data;
  int jobs;
  std::function<void(const std::string&)> say;
};

/// The truth rolled out by the simulator at its own step times `share`, one rollout per planned
/// start.
std::vector<evaluate::Rollout> simulator_rollouts(const Task& task, const HeldOut& held_out,
                                                  std::span<const evaluate::Start> starts,
                                                  double share) {
  const sim::MujocoArm arm = sim::make_arm(task.problem, task.problem.scene.plant.step_s * share);
  std::vector<evaluate::Rollout> rollouts(starts.size());
  parallel_for(static_cast<int>(starts.size()), task.jobs, [&](int i) {
    const evaluate::Start& start = starts[static_cast<std::size_t>(i)];
    const auto trajectory = static_cast<std::size_t>(start.trajectory);
    const sim::Trace trace =
        sim::oracle_rollout(task.problem, arm, held_out.truths[trajectory],
                            held_out.trajectories[trajectory].data, start.begin, start.steps + 1);
    rollouts[static_cast<std::size_t>(i)] = {start, false, trace.q, trace.v, trace.tau_f};
  });
  return rollouts;
}

/// What of the recordings the models were fitted to, under both filters.
struct Training {
  std::vector<evaluate::Trajectory> fitted;  ///< with the motion that fits see
  std::vector<evaluate::Trajectory> judged;  ///< with that of held-out recordings
};

Training training_of(const Task& task, std::vector<data::Dataset> recordings) {
  Training training;
  const std::vector<data::Dataset> all =
      first_seconds(std::move(recordings), task.problem.scene.identify.first_s);
  for (data::Dataset& dataset : data::training_part(all).recordings) {
    signals::Recording recording =
        signals::make_recording(dataset, task.problem.scene.identify.cutoff_hz);
    training.judged.push_back({dataset,
                               std::move(recording.narrow.q),
                               std::move(recording.narrow.v),
                               std::move(recording.narrow.a),
                               {}});
    training.fitted.push_back(
        {std::move(dataset), std::move(recording.wide.q), std::move(recording.wide.v), {}, {}});
  }
  return training;
}

/// In what held-out recordings differ from the training data, of which alone models are.
void add_differences(const Task& task, std::span<const evaluate::Trajectory> training,
                     std::span<const evaluate::Trajectory> held_out,
                     evaluate::Evaluation& evaluation) {
  const auto datasets = [](std::span<const evaluate::Trajectory> trajectories) {
    std::vector<data::Dataset> sets;
    for (const evaluate::Trajectory& trajectory : trajectories) sets.push_back(trajectory.data);
    return sets;
  };
  const auto found = estimate::find_differences_from_training(
      task.problem.robot, datasets(training), datasets(held_out), task.problem.scene.identify,
      task.jobs);
  for (std::size_t i = 0; i < found.size(); ++i)
    for (const estimate::Fault& fault : found[i])
      if (!fault.without_temperature)
        evaluation.unexplained.push_back(
            {.recording = held_out[i].data.name, .joint = fault.joint, .difference = fault.found});
}

/// Parts of the training recordings, with arms that were not fitted to them.
std::vector<evaluate::LeftOut> left_out_of(const data::FitFile& file, const std::string& place,
                                           const data::ModelFile& model,
                                           std::span<const evaluate::Trajectory> training) {
  std::vector<evaluate::LeftOut> parts;
  for (const data::FittedWithout& fit : file.without) {
    const auto of = std::ranges::find(training, fit.recording,
                                      [](const auto& recording) { return recording.data.name; });
    const std::size_t parameters = model.arm.friction.theta.size();
    if (of == training.end() || fit.begin >= fit.end || fit.end > of->data.length() ||
        fit.pi.size() != model.arm.robot.pi.size() ||
        fit.theta.size() != static_cast<Eigen::Index>(parameters))
      throw UserError(
          "{}: found a fit without samples {} to {} of {} with {} + {} parameters, "
          "expected a part of a training recording and {} + {}",
          place, fit.begin, fit.end, fit.recording, fit.pi.size(), fit.theta.size(),
          model.arm.robot.pi.size(), parameters);
    Arm arm = model.arm;
    arm.robot.pi = fit.pi;
    arm.friction.theta.assign(fit.theta.begin(), fit.theta.end());
    const auto same = [&](const Arm& other) {
      return other.robot.pi == arm.robot.pi && other.friction.theta == arm.friction.theta;
    };
    if (parts.empty() || !same(parts.back().arm)) parts.push_back({{}, std::move(arm)});
    parts.back().recordings.push_back(evaluate::part_of(*of, fit.begin, fit.end));
  }
  return parts;
}

/// Arms that the data of a fit might as well have given.
std::vector<Arm> draws_of(const data::FitFile& fit, const std::string& place,
                          const data::ModelFile& model) {
  std::vector<Arm> arms;
  const auto& draws = fit.draws;
  if (!draws) return arms;
  const auto parameters = std::ssize(model.arm.friction.theta);
  if (draws->pi.cols() != model.arm.robot.pi.size() || draws->theta.cols() != parameters)
    throw UserError("{}: found draws of {} + {} parameters, expected {} + {}", place,
                    draws->pi.cols(), draws->theta.cols(), model.arm.robot.pi.size(), parameters);
  for (Eigen::Index i = 0; i < draws->pi.rows(); ++i) {
    Arm& arm = arms.emplace_back(model.arm);
    arm.robot.pi = draws->pi.row(i);
    Eigen::RowVectorXd::Map(arm.friction.theta.data(), parameters) = draws->theta.row(i);
  }
  return arms;
}

data::ModelFile oracle_model(const scene::Problem& problem) {
  data::ModelFile model;
  model.name = model.label = "oracle";
  model.arm = {problem.robot, *problem.scene.friction};
  model.is_oracle = true;
  return model;
}

/// Faults that a fit found in itself, one line each.
std::vector<std::string> faults_of(const data::FitFile& fit) {
  std::vector<std::string> lines;
  for (const data::FittedFault& fault : fit.faults)
    lines.push_back(
        fmt::format("fit: {}{}{}", fault.joint, fault.joint.empty() ? "" : ": ", fault.found));
  if (lines.empty() && !fit.usable) lines.push_back("fit: " + fit.message);
  return lines;
}

/// Whether a fit is conventional: a law without networks, fitted by a conventional method.
bool is_conventional(const FitRequest& fit, const data::ModelFile& model) {
  if (fit.model.method != estimate::Method::kConventional || model.arm.friction.model.has_whole())
    return false;
  for (const friction::JointSpec& joint : model.arm.friction.model.joints())
    for (const friction::LawSpec& law : joint.laws)
      if (friction::is_learned(law.law)) return false;
  return true;
}

/// Writes the tables, evaluation.json and the signals. @return all files
std::vector<fs::path> save(const evaluate::Evaluation& evaluation,
                           std::span<const evaluate::Trajectory> trajectories,
                           std::span<const dynamics::Joint> joints, const RunFolder& out) {
  std::vector<fs::path> files;
  const auto add = [&](fs::path path) { return files.emplace_back(std::move(path)); };
  for (const evaluate::ModelResult& model : evaluation.models) {
    const FitId id{model.name, model.seed};
    for (const evaluate::Rollout& rollout : model.rollouts) {
      const auto& trajectory = trajectories[static_cast<std::size_t>(rollout.start.trajectory)];
      evaluate::save_rollout(rollout, trajectory, model.name, model.seed,
                             add(out.rollout(id, trajectory.data.name)));
    }
    for (std::size_t i = 0; i < model.torque.size(); ++i)
      evaluate::save_prediction(model.torque[i], trajectories[i].data, trajectories[i].q,
                                trajectories[i].v,
                                add(out.prediction(id, trajectories[i].data.name)));
  }
  for (const evaluate::Summary& summary : evaluation.summary)
    for (std::size_t i = 0; i < summary.bands.size(); ++i)
      evaluate::save_band(summary.bands[i], trajectories[i].data, summary.name,
                          add(out.band(summary.name, trajectories[i].data.name)));
  std::string note;
  if (!trajectories.empty())
    if (const auto of_torque = data::warning_of_torque(trajectories.front().data);
        !of_torque.empty())
      note = fmt::format("\nOf the friction here: {}.\n", of_torque);
  write_file_atomically(add(out.table()), evaluate::to_markdown(evaluation) + note);
  write_file_atomically(add(out.torque_table()),
                        evaluate::to_torque_markdown(evaluation, joints) + note);
  write_file_atomically(add(out.table_csv()), evaluate::to_csv(evaluation));
  data::save(evaluation, add(out.evaluation()));
  return files;
}

Done work(const Task& task, const RunFolder& visible, const RunFolder& out) {
  std::vector<data::Dataset> training =
      load_recordings(visible, RunFolder::training, task.problem.scene.joints);
  const HeldOut held_out =
      load_held_out(task.problem, task.further_data, visible, training, task.say);
  for (const auto& [file, name] : task.further_data)
    if (name != file.stem()) task.say(fmt::format("--data {}: called {}", file.string(), name));
  const evaluate::EvaluateOptions& options = task.problem.scene.evaluate;
  const auto starts =
      evaluate::plan_starts(held_out.trajectories, options.horizons_s, options.starts);
  // first, since other programs make the rollouts in external/ from it
  write_file_atomically(out.starts(), evaluate::starts_csv(held_out.trajectories, starts));

  evaluate::Contest contest;
  contest.scene = task.problem.scene.name;
  contest.trajectories = held_out.trajectories;
  Training learnt = training_of(task, std::move(training));
  contest.training = std::move(learnt.fitted);
  contest.learnt = std::move(learnt.judged);
  contest.robot = task.problem.robot;
  const std::optional<data::ModelFile> oracle =
      held_out.truths.empty() ? std::nullopt : std::optional(oracle_model(task.problem));
  for (const FitRequest& fit : task.fits) {
    contest.models.push_back(load_fitted(visible, fit.id(), task.problem.scene.joints));
    const data::ModelFile& model = contest.models.back();
    const fs::path path = visible.fit(fit.id());
    const auto file = data::load<data::FitFile>(path);
    contest.faults.push_back(faults_of(file));
    contest.left_out.push_back(left_out_of(file, path.string(), model, contest.training));
    contest.draws.push_back(draws_of(file, path.string(), model));
    if (oracle) contest.intervals.emplace_back(evaluate::count_intervals(model, file, oracle->arm));
    if (!is_conventional(fit, contest.models.back()))
      contest.unconventional.push_back(fit.model.name);
  }
  for (const fs::path& folder : external_folders(out, task.fits))
    contest.externals.push_back(
        evaluate::load_external_model(folder, held_out.trajectories, starts));
  if (oracle) {
    contest.models.insert(contest.models.begin(), *oracle);
    contest.faults.insert(contest.faults.begin(), std::vector<std::string>());
    contest.left_out.emplace(contest.left_out.begin());
    contest.draws.emplace(contest.draws.begin());
    contest.intervals.emplace(contest.intervals.begin());
    contest.simulator_oracle = simulator_rollouts(task, held_out, starts, 1.0);
    const auto of_first = std::ranges::count(starts, 0, &evaluate::Start::trajectory);
    contest.simulator_halved = simulator_rollouts(
        task, held_out, std::span(starts).first(static_cast<std::size_t>(of_first)), 0.5);
  }
  evaluate::Evaluation evaluation = evaluate::evaluate(contest, options, task.jobs);
  add_differences(task, contest.learnt, contest.trajectories, evaluation);
  Done done{save(evaluation, contest.trajectories, contest.robot.joints, out)};
  done.files.push_back(out.starts());
  return done;
}

}  // namespace

Stage evaluation_stage(const Job& job, const std::vector<fs::path>& files) {
  const std::vector<FitRequest> fits = fits_of(job).counted;
  const std::vector<FurtherData> further_data = named_apart(job, fits, files);
  Stage stage{"evaluate", Inputs(job.run.folder()), {}};
  declare(stage.inputs, job.problem, kEvaluated);
  stage.inputs.text("MJCF", job.mjcf);
  stage.inputs.outputs_of(job.run.results_of("data"));
  std::string methods;
  for (const FitRequest& fit : fits) {
    const std::string fitted = fit_stage(job, fit).name;
    stage.inputs.outputs_of(job.run.results_of(fitted), "models/");
    stage.inputs.outputs_of(job.run.results_of(fitted), "fit/");
    methods += fmt::format("{}={}\n", fit.model.name, name_of(fit.model.method.value()));
  }
  stage.inputs.text("methods of the fits", methods);
  for (std::size_t i = 0; i < further_data.size(); ++i) {
    const std::string name = fmt::format("--data {}", i);
    stage.inputs.file(name, further_data[i].file);
    stage.inputs.text("name of " + name, further_data[i].name);
    if (const fs::path truth = truth_beside(further_data[i].file); fs::exists(truth))
      stage.inputs.file("truth of " + name, truth);
  }
  stage.inputs.files_below(job.run.folder().external());
  stage.work =
      [task = Task{part_of(job.problem, kEvaluated), fits, further_data, job.jobs, job.say},
       out = job.run.folder()](const RunFolder& visible) { return work(task, visible, out); };
  return stage;
}

evaluate::Evaluation evaluate(Job& job, const std::vector<fs::path>& further_data) {
  const bool logs = scene::logs_are_there(job.problem);
  if (!job.run.intact("data") || (logs && !job.run.stands(data_stage(job))))
    throw UserError(
        "{}: the data are damaged, or made from another scene, robot or logs; `fricid run {}` "
        "makes them again",
        (job.run.folder().path() / "data").string(), job.run.folder().path().string());
  const Fits fits = fits_of(job);
  for (const Fits::LeftOut& fit : fits.left_out)
    job.say(fmt::format("{}: left out: {}", fit.id, fit.why));
  if (fits.counted.empty())
    throw UserError("{}: found no models; run `fricid identify` first",
                    (job.run.folder().path() / "models").string());
  if (!job.run.perform(evaluation_stage(job, further_data))) job.say("evaluate: up to date");
  return data::load<evaluate::Evaluation>(job.run.folder().evaluation());
}

}  // namespace fricid::workflow
