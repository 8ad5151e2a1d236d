#pragma once

#include "commands.hpp"
#include "fricid/workflow/job.hpp"

namespace fricid::cli {

/// Opens or creates the run folder: `output`, by default run/NAME, or the one that is the target.
/// @throws UserError
workflow::Job open_job(scene::Problem problem, const RunOptions& options,
                       const CommonOptions& common);

}  // namespace fricid::cli
