// The steps of `fricid run` for a scene and its run folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/evaluation.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/workflow/run.hpp"

namespace fricid::workflow {

/// A scene and its run folder.
struct Job {
  scene::Problem problem;
  std::string mjcf;  ///< sim::compiled_mjcf of the scene's MJCF; empty: none
  Run run;
  int jobs;                                     ///< threads; 0: one per core
  std::function<void(const std::string&)> say;  ///< takes one line for the user
};

/// The problem of a scene file or of a run folder, validated before any work: the simulated arm
/// must be that of the URDF.
/// @param seed  replaces the scene's seed
/// @throws UserError
scene::Problem load_problem(const std::filesystem::path& target,
                            std::optional<std::uint64_t> seed = {});

/// The same of the text of a scene, see scene::load_scene_text.
scene::Problem load_problem_text(const std::string& text, std::optional<std::uint64_t> seed = {});

/// Opens or creates a run folder for a problem: the manifest names its sources, scene.toml is
/// the scene as run.
/// @throws UserError as Run::open, and when a source is a file that the run would write
Job open_job(scene::Problem problem, const std::filesystem::path& folder, bool fresh, int jobs,
             std::function<void(const std::string&)> say);

/// Simulates or imports the data unless they are up to date: data/, truth/, excitation.json.
void make_data(Job& job);

/// Reports faults of the logs of a run that would make any fit wrong (doctor::KindInfo::misleads).
/// @return false if there is one
bool data_are_sound(const Job& job);

/// One fit to make.
struct FitRequest {
  estimate::ModelOptions model;
  int seed = 1;

  FitId id() const { return {model.name, seed}; }
};

/// The fits to make.
/// @param names  models of the scene or laws of the table; empty: all models of the scene
/// @param seeds  empty: those of the scene
std::vector<FitRequest> requested_fits(const scene::Scene& scene,
                                       const std::vector<std::string>& names,
                                       const std::vector<int>& seeds);

/// @throws UserError on a scene without models
void require_models(const scene::Scene& scene);
/// @throws UserError on a scene without validation data
void require_validation(const scene::Scene& scene);
/// @throws UserError when a part of the work would take too much memory
void require_memory(const scene::Problem& problem, const std::vector<FitRequest>& requests,
                    int jobs);

/// Makes fits: models/, fit/.
/// @param by_name  include them in the evaluation, even if the scene does not name them
/// @return false when a fit failed its own checks
bool identify(Job& job, const std::vector<FitRequest>& requests, bool by_name);

/// The fits of a run folder.
struct Fits {
  /// Those of the scene's models and seeds and those requested by name, if they were made from the
  /// present scene, robot and data: in the order of the scene, then by name.
  std::vector<FitRequest> counted;
  struct LeftOut {
    std::string id;   ///< "lugre_s1"
    std::string why;  ///< "not in the scene", "its files changed", "changed since: [identify]"
  };
  std::vector<LeftOut> left_out;
};
Fits fits_of(const Job& job);

/// Evaluates the fits on held-out data: rollouts/, predictions/, bands/, the tables,
/// evaluation.json. Includes the models in external/.
/// @param further_data  data sets in addition to those of the run
evaluate::Evaluation evaluate(Job& job, const std::vector<std::filesystem::path>& further_data);

/// Finds the load of [payload] from the training recordings and those with it, if the scene asks
/// for it: payload.json, data/loaded_0.h5, ...
/// @return false when what was found is not to be trusted
bool find_load(Job& job);

/// Simulates the arm with the friction of the fits fed forward, if the scene asks for it: loops/,
/// compensation.json, compensation.md.
/// @return whether it does
bool compensate(Job& job);

/// Simulates pushes and hours without any, and scores what observers with the friction of the fits
/// make of them, if the scene asks for it: contact.json, contact.md, contact/.
/// @return whether it does
bool feel_contacts(Job& job);

/// Makes plots/ and video/. Plots and videos that cannot be made (no gnuplot, no renderer, disk
/// full) are left out.
/// @return the reason in one line; empty if all were made
std::string draw_plots(Job& job);
/// @param shown  the problem with the section [render] to use
std::string make_videos(Job& job, const scene::Problem& shown, const std::string& renderer);

/// report.html from the existing files. @throws UserError when it cannot be written
void make_report(Job& job);

// The single stages: their declared inputs and their work.
Stage data_stage(const Job& job);
Stage fit_stage(const Job& job, const FitRequest& request);
Stage evaluation_stage(const Job& job, const std::vector<std::filesystem::path>& further_data);
Stage payload_stage(const Job& job);
Stage compensation_stage(const Job& job);
Stage contact_stage(const Job& job);
Stage plots_stage(const Job& job);
Stage film_stage(const Job& job, const scene::Problem& shown, const std::string& renderer);
Stage report_stage(const Job& job);

}  // namespace fricid::workflow
