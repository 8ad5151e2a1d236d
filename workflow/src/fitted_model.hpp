// Models of a run folder, checked before they are used.
#pragma once

#include <string>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::workflow {

/// @param joints  of the scene's robot
/// @throws UserError when a file is that of another model or robot, or is named as the truth
data::ModelFile load_fitted(const RunFolder& folder, const FitId& id,
                            const std::vector<std::string>& joints);

}  // namespace fricid::workflow
