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
/// scene, how to reproduce. Made from these alone; what is not there (truth, videos, plots) is left
/// out. Videos and files of plots are linked relative to the folder.
/// @param folder    files that are not shown are as if they were not there
/// @param scene     as run
/// @param manifest  what was done; its stages are shown, so the report's own must not be among them
/// @throws UserError when the folder holds no evaluation.json, or what is there is broken
std::string report_of_run(const workflow::RunFolder& folder, const scene::Scene& scene,
                          const workflow::Manifest& manifest);

/// Writes report_of_run to a file of that folder, atomically. @throws UserError
void write_report(const workflow::RunFolder& folder, const scene::Scene& scene,
                  const workflow::Manifest& manifest, const std::filesystem::path& file);

}  // namespace fricid::render
