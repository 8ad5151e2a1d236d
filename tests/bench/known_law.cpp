// What do the data allow? For every run folder of a simulated scene: the truth's own law is trained
// like any other on the folder's training data, from the true friction and the rigid body of least
// squares, by either optimiser; the better one on held-out rollouts counts. The model goes into the
// folder, where `fricid evaluate` gives it a row, "known law". What a learned law has above that
// row is its own, what the row has above the oracle is the data's.
//
//     fricid_known_law run/benchmark/kr6_gms_1 && fricid evaluate run/benchmark/kr6_gms_1
#include <filesystem>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/scene/problem.hpp"

namespace fricid {
namespace {

void fit_known_law(const std::filesystem::path& folder) {
  const scene::Problem problem = scene::load_problem(folder / "scene.toml");
  if (!problem.scene.friction) throw UserError("{}: no friction is injected", folder.string());
  std::vector<data::Dataset> train;
  for (int i = 0;; ++i) {
    const auto file = folder / "data" / fmt::format("train_{}.h5", i);
    if (!std::filesystem::exists(file)) break;
    train.push_back(data::load_dataset(file));
  }
  const estimate::Prepared prepared =
      estimate::prepare(problem.robot, problem.scene.identify, train, 0);
  estimate::ModelOptions config;
  config.name = "known";
  config.label = "known law";
  config.law = "coulomb_viscous";
  const auto seed = static_cast<int>(problem.scene.seed);
  estimate::FitReport report = estimate::fit_conventional(prepared, config, seed, 0);
  report.model.arm.friction = *problem.scene.friction;

  const auto error_of = [](const estimate::MultiStepReport& trained) {
    return trained.history.best_held_out();
  };
  estimate::MultiStepOptions options;
  options.torque_scale = estimate::torque_rms(prepared.recordings);
  options.seed = problem.scene.seed;
  for (const auto optimiser : {estimate::Optimiser::kAdam, estimate::Optimiser::kGaussNewton}) {
    options.optimiser = optimiser;
    const auto trained =
        estimate::train_multi_step(report.model.arm, prepared.recordings, options, config.label, 0);
    if (!report.multi_step || error_of(trained) < error_of(*report.multi_step))
      report.multi_step = trained;
  }
  report.method = estimate::Method::kMultiStep;
  report.model.arm = report.multi_step->arm;
  report.message = report.multi_step->message;
  report.joints.clear();
  const auto file = fmt::format("known_s{}.json", seed);
  data::save_model(report.model, folder / "models" / file);
  data::save(estimate::fit_file(report), folder / "fit" / file);
  fmt::print("{}: {}\n", folder.string(), report.message);
}

}  // namespace
}  // namespace fricid

int main(int argc, char** argv) {
  try {
    for (int i = 1; i < argc; ++i) fricid::fit_known_law(argv[i]);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return EXIT_FAILURE;
  }
}
