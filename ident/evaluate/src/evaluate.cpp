#include "fricid/evaluate/evaluate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/evaluate/constant_friction.hpp"
#include "fricid/evaluate/ensemble.hpp"
#include "fricid/evaluate/statistics.hpp"
#include "planned_rollouts.hpp"

namespace fricid::evaluate {
namespace {

RolloutScore score_of(const Rollout& rollout, const Trajectory& trajectory,
                      const RowMatrix& driven_tau_f, std::span<const dynamics::Joint> joints,
                      std::span<const double> horizons_s) {
  const data::Dataset& data = trajectory.data;
  const Start& start = rollout.start;
  RolloutScore score;
  score.trajectory = start.trajectory;
  score.name = data.name;
  score.start_s = start.begin * data.dt();
  score.diverged = rollout.diverged;
  for (const double h : horizons_s)
    score.error.add(horizon_error(rollout, trajectory, horizon_steps(h, data.dt(), data.length())));
  if (!trajectory.truth) return score;
  if (driven_tau_f.size() > 0)
    score.friction = friction_error(driven_tau_f.bottomRows(driven_tau_f.rows() - start.begin),
                                    trajectory, start.begin, joints);
  if (rollout.tau_f.size() > 0)
    score.friction_rollout = friction_error(rollout.tau_f, trajectory, start.begin, joints);
  return score;
}

/// Friction of every model driven by the measured motion, [model][trajectory].
std::vector<std::vector<Driven>> drive_all(const Contest& contest, const Plan& plan, int jobs) {
  const std::size_t models = contest.models.size(), trajectories = contest.trajectories.size();
  std::vector driven(models, std::vector<Driven>(trajectories));
  parallel_for(static_cast<int>(models * trajectories), jobs, [&](int task) {
    const auto m = static_cast<std::size_t>(task) / trajectories;
    const auto i = static_cast<std::size_t>(task) % trajectories;
    driven[m][i] =
        drive(contest.models[m], contest.robot, contest.trajectories[i], plan.by_trajectory[i]);
  });
  return driven;
}

/// Rollouts of every model from where its friction was driven to, [model][start].
std::vector<std::vector<Rollout>> roll_out_all(const Contest& contest,
                                               std::span<const std::vector<Driven>> driven,
                                               const Plan& plan, const EvaluateOptions& options,
                                               int jobs) {
  const std::size_t models = contest.models.size();
  std::vector rollouts(models, std::vector<Rollout>(plan.starts.size()));
  std::vector<std::vector<OpenLoop>> loops;
  for (std::size_t m = 0; m < models; ++m)
    loops.push_back(open_loops(contest.models[m].arm, contest.trajectories, plan, driven[m]));
  // Batches outermost: the long ones start first, whoever they belong to.
  parallel_for(static_cast<int>(models * plan.batches.size()), jobs, [&](int task) {
    throw_if_stopped();
    const auto m = static_cast<std::size_t>(task) % models;
    const std::vector<int>& batch = plan.batches[static_cast<std::size_t>(task) / models];
    std::vector<Rollout> made =
        roll_out_batch(loops[m], batch,
                       {{options.substeps},
                        options.diverged_rad,
                        0,
                        constant_friction(contest.models[m].arm.robot, contest.robot)});
    for (std::size_t l = 0; l < batch.size(); ++l)
      rollouts[m][static_cast<std::size_t>(batch[l])] = std::move(made[l]);
  });
  return rollouts;
}

/// Torque that every fitted model predicts, [model][trajectory]; none of a trajectory without an
/// acceleration.
std::vector<std::vector<TorquePrediction>> predict_all(const Contest& contest,
                                                       std::span<const Trajectory> recordings,
                                                       int jobs) {
  const std::size_t models = contest.models.size(), trajectories = recordings.size();
  std::vector predictions(models, std::vector<TorquePrediction>(trajectories));
  parallel_for(static_cast<int>(models * trajectories), jobs, [&](int task) {
    throw_if_stopped();
    const auto m = static_cast<std::size_t>(task) / trajectories;
    const auto i = static_cast<std::size_t>(task) % trajectories;
    const Trajectory& trajectory = recordings[i];
    if (contest.models[m].is_oracle || trajectory.a.size() == 0) return;
    predictions[m][i] = torque_prediction(contest.models[m].arm, contest.robot, trajectory.data,
                                          trajectory.q, trajectory.v, trajectory.a);
  });
  return predictions;
}

/// Held-out torque that no model explains whose fit found no fault in itself.
std::vector<Unexplained> unexplained_of(const Contest& contest,
                                        std::span<const std::vector<TorquePrediction>> predictions,
                                        int jobs) {
  const std::vector<std::vector<TorquePrediction>> learnt =
      predict_all(contest, contest.learnt, jobs);
  std::vector<Judge> judges;
  for (std::size_t m = 0; m < contest.models.size(); ++m) {
    const bool is_faulty = m < contest.faults.size() && !contest.faults[m].empty();
    if (!contest.models[m].is_oracle && !is_faulty && predictions[m].front().tau.size() > 0)
      judges.push_back({predictions[m], learnt[m]});
  }
  return find_unexplained(contest.trajectories, contest.learnt, judges);
}

/// Adds doubts from open loops and the torque along held-out motion.
void add_doubts(const Contest& contest, ModelResult& result) {
  if (!result.is_oracle && !result.scores.empty() &&
      std::ranges::all_of(result.scores, &RolloutScore::diverged))
    result.doubts.push_back(
        fmt::format("all of its {} held-out rollouts diverged", result.scores.size()));
  for (std::size_t i = 0; i < result.torque.size(); ++i) {
    const data::Dataset& recording = contest.trajectories[i].data;
    for (std::size_t j = 0; j < result.torque[i].r2.size(); ++j)
      if (const double r2 = result.torque[i].r2[j]; !std::isfinite(result.torque[i].rmse.all[j]))
        result.doubts.push_back(fmt::format("{}: the torque of {} has no finite value",
                                            recording.name, recording.joint_names[j]));
      else if (r2 < 0)
        result.doubts.push_back(fmt::format(
            "{}: R2 {:.2g} of the torque of {}: worse than predicting its mean; train on motion as "
            "fast and of this kind",
            recording.name, r2, recording.joint_names[j]));
  }
}

/// Scores every rollout; keeps those from the first sample.
void add_scores(ModelResult& result, std::vector<Rollout>& rollouts, std::span<const Driven> driven,
                std::span<const Trajectory> trajectories, std::span<const dynamics::Joint> joints,
                std::span<const double> horizons_s) {
  for (Rollout& rollout : rollouts) {
    const auto i = static_cast<std::size_t>(rollout.start.trajectory);
    result.scores.push_back(score_of(rollout, trajectories[i],
                                     driven.empty() ? RowMatrix() : driven[i].tau_f, joints,
                                     horizons_s));
    if (rollout.start.begin == 0) result.rollouts.push_back(std::move(rollout));
  }
}

double mean_squared_difference(const RowMatrix& a, const RowMatrix& b, Eigen::Index rows) {
  double sum = 0;
  for (Eigen::Index k = 0; k < rows; ++k)
    for (Eigen::Index j = 0; j < a.cols(); ++j) {
      const double e = a(k, j) - b(k, j);
      sum += e * e;
    }
  return sum / static_cast<double>(rows * a.cols());
}

/// Geometric mean over starts of the mean squared difference of two sets of rollouts, per horizon.
std::vector<double> difference(std::span<const Rollout> a, std::span<const Rollout> b,
                               std::span<const Trajectory> trajectories,
                               std::span<const double> horizons_s) {
  std::vector<double> result;
  for (const double h : horizons_s) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const data::Dataset& data =
          trajectories[static_cast<std::size_t>(a[i].start.trajectory)].data;
      const int steps = horizon_steps(h, data.dt(), data.length());
      if (steps < a[i].q.rows())
        errors.push_back(mean_squared_difference(a[i].q, b[i].q, steps + 1));
    }
    result.push_back(geometric_mean(errors));
  }
  return result;
}

/// Open-loop error that torque noise alone causes: half the mean squared difference between
/// rollouts under the torques of two successive periods of a repeating motion, for the model with
/// the smallest difference.
std::vector<double> repeat_floor(const Contest& contest, std::span<const Repeats> repeats,
                                 const Plan& plan, std::span<const std::vector<Driven>> driven,
                                 std::span<const std::vector<Rollout>> rollouts,
                                 const EvaluateOptions& options, int jobs) {
  Contest shifted = contest;
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    Trajectory& trajectory = shifted.trajectories[i];
    if (trajectory.truth || repeats[i].period_s == 0) return {};
    const auto period = static_cast<int>(std::lround(repeats[i].period_s / trajectory.data.dt()));
    trajectory.data.tau = other_passage(held_torque(trajectory.data), period);
  }
  const std::vector<std::vector<Rollout>> other =
      roll_out_all(shifted, driven, plan, options, jobs);
  std::vector<double> least(options.horizons_s.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t m = 0; m < contest.models.size(); ++m) {
    const std::vector<double> own =
        difference(rollouts[m], other[m], contest.trajectories, options.horizons_s);
    for (std::size_t h = 0; h < own.size(); ++h) least[h] = std::fmin(least[h], own[h] / 2);
  }
  return least;
}

/// Scores the seeds of every model that has enough of them as one.
void add_ensembles(std::span<const Trajectory> trajectories, std::span<const double> horizons_s,
                   Evaluation& report) {
  for (Summary& summary : report.summary) {
    if (summary.seeds < kFewestMembers) continue;
    for (const double h : horizons_s) {
      std::vector<double> errors, coverage;
      for (std::size_t i = 0; i < trajectories.size(); ++i) {
        std::vector<const Rollout*> members;
        for (const ModelResult& model : report.models)
          if (model.name == summary.name) members.push_back(&model.rollouts[i]);
        const data::Dataset& data = trajectories[i].data;
        const EnsembleScore score =
            ensemble_score(members, trajectories[i], horizon_steps(h, data.dt(), data.length()));
        errors.push_back(score.q_mse);
        coverage.push_back(score.coverage);
      }
      summary.ensemble_q_mse.push_back(geometric_mean(errors));
      summary.ensemble_coverage.push_back(mean(coverage));
    }
  }
}

std::span<const Arm> draws_of(const Contest& contest, std::size_t model) {
  return model < contest.draws.size() ? contest.draws[model] : std::span<const Arm>();
}

/// Estimates the torque error of every fitted model and scores the resulting bands.
void add_bands(const Contest& contest, const EvaluateOptions& options, int jobs,
               Evaluation& report) {
  if (contest.training.empty() || options.draws == 0) return;
  std::vector<FittedTorqueError> errors(contest.models.size());
  parallel_for(static_cast<int>(errors.size()), jobs, [&](int i) {
    const auto m = static_cast<std::size_t>(i);
    const data::ModelFile& model = contest.models[m];
    if (model.is_oracle) return;
    const std::span<const LeftOut> left_out =
        m < contest.left_out.size() ? contest.left_out[m] : std::span<const LeftOut>();
    errors[m] = fit_torque_error(model, contest.robot, contest.training, left_out, options, jobs);
  });
  for (Summary& summary : report.summary) {
    std::vector<Member> members;
    for (std::size_t m = 0; m < contest.models.size(); ++m) {
      const data::ModelFile& model = contest.models[m];
      if (!model.is_oracle && model.name == summary.name)
        members.push_back({&model, errors[m], draws_of(contest, m)});
    }
    if (members.empty()) continue;
    for (ModelResult& result : report.models)
      for (const Member& member : members)
        if (result.name == member.model->name && result.seed == member.model->seed)
          result.torque_error = member.fitted.error;
    summary.bands = open_loop_bands(members, contest.trajectories, options, jobs);
    for (const double h : options.horizons_s) {
      std::vector<double> coverage, squares;
      for (std::size_t i = 0; i < contest.trajectories.size(); ++i) {
        const data::Dataset& data = contest.trajectories[i].data;
        const BandScore of_band = score(summary.bands[i], contest.trajectories[i],
                                        horizon_steps(h, data.dt(), data.length()));
        coverage.push_back(of_band.coverage);
        squares.push_back(of_band.half_width * of_band.half_width);
      }
      summary.band_coverage.push_back(mean(coverage));
      summary.band_half_width.push_back(std::sqrt(mean(squares)));
    }
  }
}

void check_plan(std::span<const Rollout> rollouts, std::span<const Start> starts,
                const std::string& what) {
  bool agree = rollouts.size() == starts.size();
  for (std::size_t i = 0; agree && i < rollouts.size(); ++i)
    agree = rollouts[i].start.trajectory == starts[i].trajectory &&
            rollouts[i].start.begin == starts[i].begin &&
            rollouts[i].q.rows() == starts[i].steps + 1;
  if (!agree)
    throw UserError("rollouts of {}: found {}, expected the {} planned starts", what,
                    rollouts.size(), starts.size());
}

std::vector<Rollout> settled(std::vector<Rollout> rollouts,
                             std::span<const Trajectory> trajectories, double diverged_rad) {
  for (Rollout& rollout : rollouts)
    settle_divergence(rollout, trajectories[static_cast<std::size_t>(rollout.start.trajectory)],
                      diverged_rad);
  return rollouts;
}

}  // namespace

Evaluation evaluate(const Contest& contest, const EvaluateOptions& options, int jobs) {
  if (contest.trajectories.empty()) throw UserError("evaluate: no held-out data");
  for (const Trajectory& trajectory : contest.trajectories)
    if (trajectory.data.n() != contest.robot.n())
      throw UserError("evaluate: {} has {} joints, the robot {}", trajectory.data.name,
                      trajectory.data.n(), contest.robot.n());
  const Plan plan = make_plan(contest.trajectories, options);
  if (plan.starts.empty()) throw UserError("evaluate: horizons_s is empty");
  if (!contest.simulator_oracle.empty())
    check_plan(contest.simulator_oracle, plan.starts, "the simulator's oracle");
  if (!contest.simulator_halved.empty())
    check_plan(contest.simulator_halved, plan.by_trajectory.front(),
               "the simulator at half its step");
  for (const ExternalModel& external : contest.externals)
    check_plan(external.rollouts, plan.starts, external.name);

  Evaluation report;
  report.scene = contest.scene;
  double longest = 0;
  std::vector<std::vector<double>> rms;
  for (const Trajectory& trajectory : contest.trajectories) {
    report.trajectories.push_back(trajectory.data.name);
    longest = std::max(longest, (trajectory.data.length() - 1) * trajectory.data.dt());
    report.repeats.push_back(find_repeats(trajectory.data));
    if (trajectory.truth) rms.push_back(friction_rms(trajectory));
  }
  if (rms.size() < contest.trajectories.size()) rms.clear();
  for (const double h : options.horizons_s) report.horizons_s.push_back(h == 0 ? longest : h);

  const std::vector<std::vector<Driven>> driven = drive_all(contest, plan, jobs);
  std::vector<std::vector<Rollout>> rollouts = roll_out_all(contest, driven, plan, options, jobs);
  std::vector<std::vector<TorquePrediction>> predictions =
      predict_all(contest, contest.trajectories, jobs);
  report.unexplained = unexplained_of(contest, predictions, jobs);

  const auto settle = [&](const std::vector<Rollout>& made) {
    return settled(made, contest.trajectories, options.diverged_rad);
  };
  std::vector<Rollout> simulated = settle(contest.simulator_oracle);
  const std::vector<Rollout> halved = settle(contest.simulator_halved);

  // Differences of whole sets of rollouts, before scoring keeps only some of them.
  if (!halved.empty() && !simulated.empty())
    report.halving = difference(std::span(simulated).first(halved.size()), halved,
                                contest.trajectories, options.horizons_s);
  const auto engine_oracle = std::find_if(contest.models.begin(), contest.models.end(),
                                          [](const data::ModelFile& m) { return m.is_oracle; });
  if (engine_oracle != contest.models.end() && !simulated.empty())
    report.integration = difference(
        simulated, rollouts[static_cast<std::size_t>(engine_oracle - contest.models.begin())],
        contest.trajectories, options.horizons_s);
  report.repeat = repeat_floor(contest, report.repeats, plan, driven, rollouts, options, jobs);

  if (!simulated.empty()) {
    ModelResult& oracle = report.models.emplace_back();
    oracle.name = "simulator";
    oracle.label = "oracle (simulator)";
    oracle.is_oracle = true;
    add_scores(oracle, simulated, {}, contest.trajectories, contest.robot.joints,
               options.horizons_s);
  }
  for (const bool oracles : {true, false})
    for (std::size_t m = 0; m < contest.models.size(); ++m) {
      const data::ModelFile& model = contest.models[m];
      if (model.is_oracle != oracles) continue;
      ModelResult& result = report.models.emplace_back();
      result.name = model.name;
      result.label = model.label;
      result.seed = model.seed;
      result.parameters = model.free_parameters;
      result.budget = model.budget;
      result.is_oracle = model.is_oracle;
      result.friction_states = model.arm.friction.model.state_size();
      result.is_conventional =
          !model.is_oracle &&
          std::find(contest.unconventional.begin(), contest.unconventional.end(), model.name) ==
              contest.unconventional.end();
      add_scores(result, rollouts[m], driven[m], contest.trajectories, contest.robot.joints,
                 options.horizons_s);
      if (!model.is_oracle && predictions[m].front().tau.size() > 0)
        result.torque = std::move(predictions[m]);
      if (m < contest.faults.size()) result.doubts = contest.faults[m];
      if (m < contest.intervals.size()) result.intervals = contest.intervals[m];
      add_doubts(contest, result);
    }
  for (const ExternalModel& external : contest.externals) {
    ModelResult& result = report.models.emplace_back();
    result.name = external.name;
    result.label = external.label;
    result.parameters = external.parameters;
    result.stated_fit_seconds = external.fit_seconds;
    std::vector<Rollout> made = settle(external.rollouts);
    add_scores(result, made, {}, contest.trajectories, contest.robot.joints, options.horizons_s);
  }
  summarise(report, options.min_headroom, rms);
  add_ensembles(contest.trajectories, options.horizons_s, report);
  add_bands(contest, options, jobs, report);
  return report;
}

}  // namespace fricid::evaluate
