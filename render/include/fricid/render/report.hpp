// The report of a run: one page for a browser.
#pragma once

#include <filesystem>
#include <string>

#include "fricid/scene/scene.hpp"
#include "fricid/workflow/manifest.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::render {

/// The run folder as one HTML page without scripts that needs no network: summary, tables, videos,
/// plots (SVG inside the page), every model with its parameters, warnings and their remedies, data,
/// scene, how to reproduce. Made from the arguments only; missing files (truth, videos, plots) are
/// left out. Videos and files of plots are linked relative to the folder.
/// @param folder    invisible files count as missing
/// @param scene     as run
/// @param manifest  without the report's own stage, since its stages are shown
/// @throws UserError when evaluation.json is missing, or a file is damaged
std::string report_of_run(const workflow::RunFolder& folder, const scene::Scene& scene,
                          const workflow::Manifest& manifest);

/// Writes report_of_run to a file of that folder, atomically. @throws UserError
void write_report(const workflow::RunFolder& folder, const scene::Scene& scene,
                  const workflow::Manifest& manifest, const std::filesystem::path& file);

}  // namespace fricid::render
