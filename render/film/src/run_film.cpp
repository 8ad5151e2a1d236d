#include "fricid/film/run_film.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/loop_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/evaluate/compensation.hpp"
#include "fricid/evaluate/evaluation.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/trajectory.hpp"
#include "fricid/render/palette.hpp"
#include "fricid/sim/truth.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::film {
namespace {

constexpr std::size_t kModelsShown = 3;
constexpr const char* kBareColour = "#3f5fbf";  // an arm without compensation
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A rollout with all signals of a film; those of other programs may lack tau_f.
std::optional<evaluate::RolloutSignals> whole_rollout(const std::filesystem::path& file, int n) {
  auto rollout = workflow::if_there(
      file, [n](const std::filesystem::path& path) { return evaluate::load_rollout(path, n); });
  if (rollout && rollout->tau_f.size() == 0) rollout.reset();
  return rollout;
}

std::vector<double> mse_of(const evaluate::Evaluation& evaluation, const std::string& name) {
  const auto row = std::ranges::find(evaluation.summary, name, &evaluate::Summary::name);
  return row == evaluation.summary.end() ? std::vector<double>() : row->q_mse_geometric_mean;
}

/// The best model at the last horizon, the first of the scene, then the next best.
std::vector<std::string> telling_models(std::vector<FilmRow> rows,
                                        const std::vector<std::string>& names) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < rows.size(); ++i) order.push_back(i);
  const auto last = [&](std::size_t i) {
    const double mse = rows[i].mse.empty() ? kNaN : rows[i].mse.back();
    return std::isfinite(mse) ? mse : HUGE_VAL;
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return last(a) < last(b); });
  if (const auto first = std::find(order.begin(), order.end(), 0u); first - order.begin() > 1)
    std::rotate(order.begin() + 1, first, first + 1);
  if (order.size() > kModelsShown)
    order.erase(order.begin() + static_cast<std::ptrdiff_t>(kModelsShown), order.end());
  std::sort(order.begin(), order.end());
  std::vector<std::string> chosen;
  for (const std::size_t i : order) chosen.push_back(names[i]);
  return chosen;
}

void keep_rows(RowMatrix& values, Eigen::Index rows) {
  if (values.rows() > rows) values = values.topRows(rows).eval();
}

}  // namespace

int RunFilm::row(double at) const {
  const auto* end = t.data() + t.size();
  const auto* found = std::lower_bound(t.data(), end, at - 1e-9);
  return static_cast<int>(std::min<std::ptrdiff_t>(found - t.data(), t.size() - 1));
}

std::string describe(const friction::Friction& friction) {
  std::vector<std::string> parts;
  for (const friction::JointSpec& joint : friction.model.joints())
    for (const friction::LawSpec& law : joint.laws) {
      std::string part = law.law;
      if (law.elements > 0) part += fmt::format(", {} elements", law.elements);
      for (std::size_t m = 0; m < law.modifiers.size(); ++m)
        part += fmt::format("{}{}",
                            m == 0                         ? ", with "
                            : m + 1 < law.modifiers.size() ? ", "
                                                           : " and ",
                            law.modifiers[m].name);
      if (std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
    }
  if (const friction::RobotLawSpec& whole = friction.model.whole(); friction.model.has_whole())
    parts.push_back(fmt::format("{}, {} elements", whole.law, whole.elements));
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text.empty() ? "none" : text;
}

RunFilm read_film(const workflow::RunFolder& folder, const scene::Problem& problem) {
  const auto evaluation = data::load<evaluate::Evaluation>(folder.evaluation());
  const std::vector<render::RunModel> models = render::models_of_run(evaluation, folder);

  RunFilm film;
  film.scene = problem.scene.name;
  film.description = problem.scene.description;
  if (problem.scene.friction) film.friction = describe(*problem.scene.friction);
  film.trajectory = evaluation.trajectories.front();
  film.layout = problem.scene.render.layout;
  film.words.motion =
      fmt::format("open loop on {}: the recorded torques, no correction", film.trajectory);
  film.horizons = evaluation.horizons_s;
  const data::Dataset measured = data::load_dataset(folder.recording(film.trajectory));
  film.joint_names = measured.joint_names;
  film.t = measured.t.array() - measured.t[0];
  film.q = measured.q;
  film.tau = evaluate::held_torque(measured);
  film.temperature = measured.temperature;
  if (auto truth = workflow::if_there(folder.truth(film.trajectory), sim::load_truth)) {
    if (truth->joint_names.size() != film.joint_names.size())
      throw UserError("{}: found {} joints; allowed: {}, as {} has",
                      folder.truth(film.trajectory).string(), truth->joint_names.size(), film.n(),
                      film.trajectory);
    film.q = std::move(truth->trace.q);
    film.v = std::move(truth->trace.v);
    film.tau_f = std::move(truth->trace.tau_f);
  }

  // the table has all models, the film the chosen ones that have a rollout
  std::vector<std::optional<evaluate::RolloutSignals>> rollouts;
  std::vector<std::string> names;
  std::vector<FilmRow> candidates;
  for (const render::RunModel& model : models) {
    film.table.push_back(
        {model.label, model.look.colour, mse_of(evaluation, model.name), model.is_oracle});
    rollouts.push_back(whole_rollout(folder.rollout(model.first_fit(), film.trajectory), film.n()));
    if (model.is_oracle || !rollouts.back()) continue;
    names.push_back(model.name);
    candidates.push_back(film.table.back());
  }
  std::vector<std::string> chosen = problem.scene.render.models;
  for (const std::string& name : chosen)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UserError("[render] models: found {}, which has no rollout in {}; allowed: {}", name,
                      folder.path().string(), fmt::join(names, ", "));
  if (chosen.empty()) chosen = telling_models(candidates, names);
  if (chosen.empty())
    throw UserError("{}: found no rollout of a model on {}", folder.path().string(),
                    film.trajectory);

  Eigen::Index rows = std::min(film.t.size(), film.q.rows());
  for (std::size_t m = 0; m < models.size(); ++m) {
    const render::RunModel& model = models[m];
    const bool shown = std::find(chosen.begin(), chosen.end(), model.name) != chosen.end();
    if (!(shown || model.is_oracle) || !rollouts[m]) continue;
    evaluate::RolloutSignals& rollout = *rollouts[m];
    rows = std::min(rows, rollout.t.size());
    film.table[m].shown = shown;
    FilmModel rolled{model.name,
                     model.label,
                     model.look.colour,
                     std::move(rollout.q),
                     std::move(rollout.v),
                     std::move(rollout.tau_f),
                     folder.model(model.first_fit())};
    if (model.is_oracle)
      film.oracle = std::move(rolled);
    else
      film.models.push_back(std::move(rolled));
  }
  film.words.base = film.has_truth() ? "truth" : "measured";
  film.words.error = film.oracle.q.size() > 0
                         ? "distance of the tip from the truth (dashed: oracle)"
                         : "distance of the tip from what was measured";
  film.t = film.t.head(rows).eval();
  for (RowMatrix* values :
       {&film.q, &film.v, &film.tau_f, &film.tau, &film.temperature, &film.oracle.q})
    keep_rows(*values, rows);
  for (FilmModel& model : film.models)
    for (RowMatrix* values : {&model.q, &model.v, &model.tau_f}) keep_rows(*values, rows);
  return film;
}

std::optional<RunFilm> read_compensation_film(const workflow::RunFolder& folder,
                                              const scene::Problem& problem) {
  const auto file =
      workflow::if_there(folder.compensation(), data::load<evaluate::CompensationFile>);
  if (!file || file->loops.empty()) return {};
  const evaluate::LoopScore& first = file->loops.front();
  const auto signals_of = [&](const std::string& model) {
    return workflow::if_there(folder.loop(model, first.path, first.controller),
                              [](const std::filesystem::path& path) {
                                return data::load_signals<data::LoopSignals>(path);
                              });
  };

  // the model that errs least at reversals
  const evaluate::LoopScore* best = nullptr;
  for (const evaluate::LoopScore& loop : file->loops) {
    if (loop.model == evaluate::kNoModel || loop.model == evaluate::kTruthModel || loop.diverged ||
        loop.path != first.path || loop.controller != first.controller)
      continue;
    if (best == nullptr || (loop.gain == best->gain &&
                            evaluate::rms(loop.reversal_rad) < evaluate::rms(best->reversal_rad)))
      best = &loop;
  }
  if (best == nullptr) return {};
  auto bare = signals_of(evaluate::kNoModel), fed = signals_of(best->model),
       truth = signals_of(evaluate::kTruthModel);
  if (!bare || !fed || !truth) return {};

  const auto look = [&](const std::string& model) {
    const auto evaluation = data::load<evaluate::Evaluation>(folder.evaluation());
    const auto models = render::models_of_run(evaluation, folder);
    const auto found = std::ranges::find(models, model, &render::RunModel::name);
    return found == models.end() ? render::Look() : found->look;
  };
  RunFilm film;
  film.scene = problem.scene.name;
  film.description = problem.scene.description;
  film.trajectory = "compensation";
  film.layout = Layout::kSideBySide;
  film.enlarged_flange = true;
  film.words = {.motion = fmt::format("friction fed forward to a controller of {:g} Hz, up to "
                                      "{:.2g} rad/s",
                                      first.bandwidth_hz, first.peak_rad_s),
                .base = "desired",
                .torque = "fed forward, and true friction",
                .error = "distance of the tip from the desired"};
  film.joint_names = bare->joint_names;
  const Eigen::Index rows = std::min({bare->t.size(), fed->t.size(), truth->t.size()});
  film.t = truth->t.head(rows).array() - truth->t[0];
  film.q = truth->q_desired.topRows(rows);
  film.v = truth->v_desired.topRows(rows);
  film.tau_f = truth->tau_f.topRows(rows);
  const auto add = [&](const std::string& label, const std::string& colour,
                       const data::LoopSignals& loop) {
    film.models.push_back({label, label, colour, loop.q.topRows(rows), loop.v_desired.topRows(rows),
                           loop.tau_forward.topRows(rows)});
  };
  add("nothing fed forward", kBareColour, *bare);
  add(best->label + " fed forward", look(best->model).colour, *fed);
  return film;
}

int most_telling_joint(const RunFilm& film) {
  int best = 0;
  double largest = -1;
  for (int j = 0; film.has_truth() && j < film.n(); ++j) {
    double missed = 0;
    for (const FilmModel& model : film.models)
      missed += (model.tau_f.col(j) - film.tau_f.col(j)).squaredNorm();
    missed /= std::max(film.tau_f.col(j).squaredNorm(), 1e-12);
    if (missed > largest) {
      largest = missed;
      best = j;
    }
  }
  return best;
}

}  // namespace fricid::film
