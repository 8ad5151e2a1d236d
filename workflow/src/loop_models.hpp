// The models that closed loops compare.
#pragma once

#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/workflow/job.hpp"

namespace fricid::workflow {

/// The first seed of every fit that counts.
std::vector<FitId> fits_for_loops(const Job& job);

/// Declares their model files.
void declare_models(Inputs& inputs, const Job& job);

/// The models of these fits, then the truth, called evaluate::kTruthModel.
std::vector<data::ModelFile> models_for_loops(const scene::Problem& problem,
                                              const RunFolder& visible,
                                              const std::vector<FitId>& fits);

}  // namespace fricid::workflow
