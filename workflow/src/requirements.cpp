// Checks before any work of a run.
#include "fricid/base/error.hpp"
#include "fricid/estimate/memory.hpp"
#include "fricid/sim/simulation_size.hpp"
#include "fricid/workflow/job.hpp"

namespace fricid::workflow {

void require_models(const scene::Scene& scene) {
  if (scene.models.empty())
    throw UserError("{}: no [[model]]; allowed: one or more to fit", scene.name);
}

void require_validation(const scene::Scene& scene) {
  if (scene.simulates() && scene.excitation.validation == 0)
    throw UserError("{}: excitation.validation = 0; allowed: 1 or more to evaluate",
                    scene.origin.place("excitation.validation"));
  if (!scene.simulates() && scene.data.validation.empty())
    throw UserError("{}: data.validation is empty; allowed: one log or more to evaluate",
                    scene.name);
}

void require_memory(const scene::Problem& problem, const std::vector<FitRequest>& requests,
                    int jobs) {
  if (!problem.scene.simulates()) return;
  sim::require_memory_of_simulation(problem);
  const sim::SimulationSize size = sim::size_of_simulation(problem);
  const estimate::TrainingSize training{.samples = size.training * size.samples,
                                        .longest = size.samples,
                                        .rate_hz = problem.scene.sensors.rate_hz};
  for (const FitRequest& fit : requests)
    estimate::require_memory_of_fit(fit.model, problem.robot, training, jobs, problem.scene.name);
}

}  // namespace fricid::workflow
