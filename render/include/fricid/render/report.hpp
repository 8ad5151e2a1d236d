// The report of a run: one page for a browser.
#pragma once

#include <filesystem>
#include <string>

namespace fricid::render {

/// The run folder as one HTML page without scripts that needs no network: summary, tables, videos,
/// plots (SVG inside the page), every model with its parameters, warnings and their remedies, data,
/// scene, how to reproduce. Made from the folder's files alone; what is not there (truth, videos,
/// plots) is left out. Videos and files of plots are linked relative to the folder.
/// @throws UserError when the folder holds no evaluation.json, or what is there is broken
std::string report_of_run(const std::filesystem::path& folder);

/// Writes report_of_run to FOLDER/report.html, atomically. @throws UserError
void write_report(const std::filesystem::path& folder);

}  // namespace fricid::render
