#pragma once

#include <string>
#include <string_view>

namespace fricid::estimate {

/// How a fit ended. Numerical trouble is reported, not thrown: best-so-far values stay usable.
enum class Outcome {
  kConverged,       ///< the stopping rule was met
  kIterationLimit,  ///< best so far within the budget of evaluations
  kIllConditioned,  ///< the data do not determine the parameters; see `condition`
  kFailed           ///< no finite result
};

/// "converged", "iteration limit", "ill conditioned", "failed".
std::string_view to_string(Outcome outcome);

}  // namespace fricid::estimate
