#include "loop_models.hpp"

#include "fitted_model.hpp"
#include "fricid/evaluate/compensation.hpp"

namespace fricid::workflow {

std::vector<FitId> fits_for_loops(const Job& job) {
  std::vector<FitId> fits;
  for (const FitRequest& fit : fits_of(job).counted)
    if (fits.empty() || fits.back().model != fit.model.name) fits.push_back(fit.id());
  return fits;
}

void declare_models(Inputs& inputs, const Job& job) {
  for (const FitId& fit : fits_for_loops(job))
    inputs.outputs_of(job.run.results_of(stage_of(fit)), "models/");
}

std::vector<data::ModelFile> models_for_loops(const scene::Problem& problem,
                                              const RunFolder& visible,
                                              const std::vector<FitId>& fits) {
  std::vector<data::ModelFile> models;
  for (const FitId& fit : fits) models.push_back(load_fitted(visible, fit, problem.scene.joints));
  data::ModelFile& truth = models.emplace_back();
  truth.name = truth.label = evaluate::kTruthModel;
  truth.arm = {problem.robot, *problem.scene.friction};
  truth.is_oracle = true;
  return models;
}

}  // namespace fricid::workflow
