#include "fricid/render/figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/hdf5.hpp"

namespace fricid::render {
namespace {

using data::RowMatrix;

constexpr int kPointsPerCurve = 1500;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A model as it appears in figures.
struct Actor {
  std::string name, label, colour;
  int seed = 1;
  bool is_oracle = false;
};

/// What the figures share: the evaluation and the signals of the first held-out trajectory.
struct Run {
  std::filesystem::path folder;
  nlohmann::json evaluation;
  std::string trajectory;
  data::Dataset measured;
  std::vector<Actor> actors;  ///< first seed of each model, the oracle first

  std::filesystem::path file(const std::string& kind, const Actor& actor) const {
    return folder / kind / fmt::format("{}_s{}_{}.h5", actor.name, actor.seed, trajectory);
  }
};

Run read_run(const std::filesystem::path& folder) {
  Run run;
  run.folder = folder;
  run.evaluation = nlohmann::json::parse(read_file(folder / "evaluation.json"), nullptr, false);
  if (run.evaluation.is_discarded() || !run.evaluation.contains("models"))
    throw UserError("{}: found no evaluation; run `fricid evaluate` first",
                    (folder / "evaluation.json").string());
  run.trajectory = run.evaluation["trajectories"].at(0);
  run.measured = data::load_dataset(folder / "data" / (run.trajectory + ".h5"));
  for (const auto& model : run.evaluation["models"]) {
    const std::string name = model["name"];
    if (model["is_oracle"] && name != "oracle") continue;  // the simulator's, equal to the engine's
    const bool known = std::any_of(run.actors.begin(), run.actors.end(),
                                   [&](const Actor& actor) { return actor.name == name; });
    if (known) continue;
    run.actors.push_back({name, model["label"],
                          colour_of(name, static_cast<int>(run.actors.size())), model["seed"],
                          model["is_oracle"]});
  }
  return run;
}

/// Every k-th row of a column, at most kPointsPerCurve points.
std::vector<double> thinned(const Eigen::Ref<const Eigen::VectorXd>& x) {
  const Eigen::Index stride = 1 + (x.size() - 1) / kPointsPerCurve;
  std::vector<double> points;
  for (Eigen::Index k = 0; k < x.size(); k += stride) points.push_back(x[k]);
  return points;
}

Series curve(const Actor& actor, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y) {
  return {.label = actor.label,
          .colour = actor.colour,
          .x = thinned(x),
          .y = thinned(y),
          .dashed = actor.is_oracle};
}

const Actor kMeasured{"truth", "measured", "#000000"};
const Actor kTruth{"truth", "truth", "#b0b0b0"};

Figure tracking(const Run& run) {
  Figure figure{.name = "tracking"};
  for (int j = 0; j < run.measured.n(); ++j) {
    figure.panels.push_back(
        {run.measured.joint_names[static_cast<std::size_t>(j)], "t [s]", "q [rad]"});
    figure.panels.back().series.push_back(curve(kMeasured, run.measured.t, run.measured.q.col(j)));
  }
  for (const Actor& actor : run.actors) {
    const auto path = run.file("rollouts", actor);
    if (actor.is_oracle || !std::filesystem::exists(path)) continue;
    const data::H5Reader file(path, "fricid.rollout/1");
    const RowMatrix q = file.matrix("/q");
    for (int j = 0; j < q.cols(); ++j)
      figure.panels[static_cast<std::size_t>(j)].series.push_back(
          curve(actor, file.vector("/t"), q.col(j)));
  }
  return figure;
}

Figure error_time(const Run& run) {
  Figure figure{.name = "error_time", .columns = 1, .panel_height_cm = 6};
  Panel panel{"open loop on " + run.trajectory, "t [s]", "mean |q error| [rad]", false, true, {}};
  for (const Actor& actor : run.actors) {
    const auto path = run.file("rollouts", actor);
    if (!std::filesystem::exists(path)) continue;
    const data::H5Reader file(path, "fricid.rollout/1");
    const RowMatrix q = file.matrix("/q");
    Eigen::VectorXd error(q.rows());
    for (Eigen::Index k = 0; k < q.rows(); ++k) {
      double sum = 0;
      for (Eigen::Index j = 0; j < q.cols(); ++j) sum += std::abs(q(k, j) - run.measured.q(k, j));
      error[k] = std::max(sum / static_cast<double>(q.cols()), 1e-9);
    }
    panel.series.push_back(curve(actor, file.vector("/t"), error));
  }
  figure.panels.push_back(std::move(panel));
  return figure;
}

Figure error_horizon(const Run& run) {
  Figure figure{.name = "error_horizon", .columns = 1, .width_cm = 12, .panel_height_cm = 7};
  Panel panel{
      run.evaluation["scene"], "horizon [s]", "MSE(q) [rad²], geometric mean", true, true, {}};
  const auto numbers = [](const nlohmann::json& values) {
    std::vector<double> result;
    for (const auto& value : values)
      result.push_back(value.is_number() ? value.get<double>() : kNaN);
    return result;
  };
  const std::vector<double> horizons = numbers(run.evaluation["horizons_s"]);
  for (const auto& model : run.evaluation["summary"])
    for (const Actor& actor : run.actors)
      if (actor.name == model["name"])
        panel.series.push_back({.label = actor.label,
                                .colour = actor.colour,
                                .x = horizons,
                                .y = numbers(model["q_mse_geometric_mean"]),
                                .width = 1.6,
                                .dashed = actor.is_oracle,
                                .markers = true});
  const std::vector<double> floor = numbers(run.evaluation["floor"]);
  if (std::any_of(floor.begin(), floor.end(), [](double x) { return std::isfinite(x); }))
    panel.series.push_back({.label = "floor", .colour = "#999999", .x = horizons, .y = floor});
  figure.panels.push_back(std::move(panel));
  return figure;
}

Figure torque(const Run& run, const Actor& actor) {
  Figure figure{.name = "torque_" + actor.name};
  const data::H5Reader file(run.file("predictions", actor), "fricid.prediction/1");
  const Eigen::VectorXd t = file.vector("/t");
  const RowMatrix measured = file.matrix("/tau"), predicted = file.matrix("/tau_predicted");
  const Actor residual{"residual", "measured - predicted", "#999999"};
  for (int j = 0; j < measured.cols(); ++j)
    figure.panels.push_back(
        {run.measured.joint_names[static_cast<std::size_t>(j)],
         "t [s]",
         "tau [N m]",
         false,
         false,
         {curve(residual, t, measured.col(j) - predicted.col(j)),
          curve(kMeasured, t, measured.col(j)), curve(actor, t, predicted.col(j))}});
  return figure;
}

/// Friction torque against velocity of every model at one joint, driven by the measured motion.
Figure friction_loop(const Run& run, int joint) {
  const std::string& name = run.measured.joint_names[static_cast<std::size_t>(joint)];
  Figure figure{.name = "friction_" + name};

  Series truth;
  const auto truth_path = run.folder / "truth" / (run.trajectory + ".h5");
  if (std::filesystem::exists(truth_path)) {
    const data::H5Reader file(truth_path, "fricid.truth/1");
    truth = curve(kTruth, file.matrix("/v").col(joint), file.matrix("/tau_f").col(joint));
    truth.width = 2.2;
  }
  for (const Actor& actor : run.actors) {
    const auto path = run.file("predictions", actor);
    if (actor.is_oracle || !std::filesystem::exists(path)) continue;
    const data::H5Reader file(path, "fricid.prediction/1");
    Panel panel{actor.label + ", " + name, "v [rad/s]", "friction [N m]"};
    if (!truth.x.empty()) panel.series.push_back(truth);
    panel.series.push_back(
        curve(actor, file.matrix("/v").col(joint), file.matrix("/tau_f").col(joint)));
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace

std::vector<Figure> figures_of_run(const std::filesystem::path& folder) {
  const Run run = read_run(folder);
  std::vector<Figure> figures{tracking(run), error_time(run), error_horizon(run)};
  for (const Actor& actor : run.actors)
    if (!actor.is_oracle && std::filesystem::exists(run.file("predictions", actor)))
      figures.push_back(torque(run, actor));
  for (int j = 0; j < run.measured.n(); ++j) figures.push_back(friction_loop(run, j));
  std::erase_if(figures, [](const Figure& figure) { return figure.panels.empty(); });
  return figures;
}

}  // namespace fricid::render
