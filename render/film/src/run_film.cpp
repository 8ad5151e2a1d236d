#include "fricid/film/run_film.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/evaluate/evaluation_file.hpp"
#include "fricid/evaluate/trajectory.hpp"
#include "fricid/render/palette.hpp"

namespace fricid::film {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kModelsShown = 3;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

fs::path rollout_file(const fs::path& folder, const std::string& trajectory,
                      const render::RunModel& model) {
  return folder / "rollouts" /
         fmt::format("{}_s{}_{}.h5", model.name, model.seeds.front(), trajectory);
}

/// Whether there is a rollout with all that a film shows: other programs may leave tau_f out.
bool has_rollout(const fs::path& file) {
  return fs::exists(file) && data::H5Reader(file, "fricid.rollout/1").has("/tau_f");
}

FilmModel read_model(const fs::path& file, const render::RunModel& model) {
  const data::H5Reader rollout(file, "fricid.rollout/1");
  return {model.name,           model.label,          model.look.colour,
          rollout.matrix("/q"), rollout.matrix("/v"), rollout.matrix("/tau_f")};
}

std::vector<double> mse_of(const nlohmann::json& evaluation, const std::string& name) {
  std::vector<double> mse;
  for (const auto& row : evaluation.at("summary"))
    if (row.at("name") == name)
      for (const auto& value : row.at("q_mse_geometric_mean"))
        mse.push_back(value.is_number() ? value.get<double>() : kNaN);
  return mse;
}

/// The best of all at the last horizon, the first of the scene, then the next best.
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

RunFilm read_film(const fs::path& folder, const data::Problem& problem) {
  const std::vector<render::RunModel> models = render::models_of_run(folder);
  const auto evaluation = evaluate::load_evaluation(folder);

  RunFilm film;
  film.scene = problem.scene.name;
  film.description = problem.scene.description;
  if (problem.scene.friction) film.friction = describe(*problem.scene.friction);
  film.trajectory = evaluation.at("trajectories").at(0).get<std::string>();
  film.horizons = evaluation.at("horizons_s").get<std::vector<double>>();
  const data::Dataset measured = data::load_dataset(folder / "data" / (film.trajectory + ".h5"));
  film.joint_names = measured.joint_names;
  film.t = measured.t.array() - measured.t[0];
  film.q = measured.q;
  film.tau = evaluate::held_torque(measured);
  film.temperature = measured.temperature;
  if (const fs::path truth = folder / "truth" / (film.trajectory + ".h5"); fs::exists(truth)) {
    const data::H5Reader file(truth, "fricid.truth/1");
    film.q = file.matrix("/q");
    film.v = file.matrix("/v");
    film.tau_f = file.matrix("/tau_f");
  }

  // the table has all models, the film those chosen whose rollout is there
  std::vector<std::string> names;
  std::vector<FilmRow> candidates;
  for (const render::RunModel& model : models) {
    film.table.push_back(
        {model.label, model.look.colour, mse_of(evaluation, model.name), model.is_oracle});
    if (model.is_oracle || !has_rollout(rollout_file(folder, film.trajectory, model))) continue;
    names.push_back(model.name);
    candidates.push_back(film.table.back());
  }
  std::vector<std::string> chosen = problem.scene.render.models;
  for (const std::string& name : chosen)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UserError("[render] models: found {}, which has no rollout in {}; allowed: {}", name,
                      folder.string(), fmt::join(names, ", "));
  if (chosen.empty()) chosen = telling_models(candidates, names);
  if (chosen.empty())
    throw UserError("{}: found no rollout of a model", (folder / "rollouts").string());

  Eigen::Index rows = film.t.size();
  for (std::size_t m = 0; m < models.size(); ++m) {
    const fs::path file = rollout_file(folder, film.trajectory, models[m]);
    const bool shown = std::find(chosen.begin(), chosen.end(), models[m].name) != chosen.end();
    if (!(shown || models[m].is_oracle) || !has_rollout(file)) continue;
    FilmModel model = read_model(file, models[m]);
    model.file =
        folder / "models" / fmt::format("{}_s{}.json", models[m].name, models[m].seeds.front());
    rows = std::min(rows, model.q.rows());
    film.table[m].shown = shown;
    if (models[m].is_oracle)
      film.oracle = std::move(model);
    else
      film.models.push_back(std::move(model));
  }
  film.t = film.t.head(rows).eval();
  for (RowMatrix* values :
       {&film.q, &film.v, &film.tau_f, &film.tau, &film.temperature, &film.oracle.q})
    keep_rows(*values, rows);
  for (FilmModel& model : film.models)
    for (RowMatrix* values : {&model.q, &model.v, &model.tau_f}) keep_rows(*values, rows);
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
