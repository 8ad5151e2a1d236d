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
  std::string mjcf;  ///< what MuJoCo makes of the MJCF, included files and meshes; empty: none
  Run run;
  int jobs;                                     ///< threads; 0: one per core
  std::function<void(const std::string&)> say;  ///< takes one line for the user
};

/// The problem of a scene file or of a run folder, checked as far as it can be without doing any of
/// its work: the simulated arm must be that of the URDF.
/// @param seed  of the data, instead of the scene's
/// @throws UserError
scene::Problem load_problem(const std::filesystem::path& target,
                            std::optional<std::uint64_t> seed = {});

/// The same of the text of a scene, see scene::load_scene_text.
scene::Problem load_problem_text(const std::string& text, std::optional<std::uint64_t> seed = {});

/// Opens or creates a run folder for a problem: the manifest names its sources, scene.toml is
/// the scene as run.
/// @throws UserError as Run::open, and when a source lies where the run writes
Job open_job(scene::Problem problem, const std::filesystem::path& folder, bool fresh, int jobs,
             std::function<void(const std::string&)> say);

/// Simulates or imports the data: data/, truth/, excitation.json. Nothing when they stand.
void make_data(Job& job);

/// Reports faults of the logs of a run that make any fit to them meaningless.
/// @return false if there is one
bool data_are_sound(const Job& job);

/// One fit to make.
struct FitRequest {
  estimate::ModelOptions model;
  int seed = 1;

  FitId id() const { return {model.name, seed}; }
};

/// Fits of the scene's models, or of those named, which may also be laws of the table; with the
/// scene's seeds, or these.
std::vector<FitRequest> requested_fits(const scene::Scene& scene,
                                       const std::vector<std::string>& names,
                                       const std::vector<int>& seeds);

/// @throws UserError on a scene with nothing to fit
void require_models(const scene::Scene& scene);
/// @throws UserError on a scene with nothing to judge by
void require_validation(const scene::Scene& scene);
/// Whatever of the work ahead takes too much memory is refused before the first of it.
/// @throws UserError
void require_memory(const scene::Problem& problem, const std::vector<FitRequest>& requests,
                    int jobs);

/// Makes fits: models/, fit/. @param by_name  beside those of the scene: the evaluation counts them
/// @return false when one failed its own health test
bool identify(Job& job, const std::vector<FitRequest>& requests, bool by_name);

/// The fits of a run folder.
struct Fits {
  /// Those of the scene's models and seeds and those asked for by name, where they were made from
  /// the scene, the robot and the data as they are now: in the order of the scene, then by name.
  std::vector<FitRequest> counted;
  struct LeftOut {
    std::string id;   ///< "lugre_s1"
    std::string why;  ///< "not in the scene", "its files changed", "changed since: [identify]"
  };
  std::vector<LeftOut> left_out;
};
Fits fits_of(const Job& job);

/// Evaluates the fits on held-out data: rollouts/, predictions/, bands/, the tables,
/// evaluation.json; rows also of the models in external/.
/// @param further_data  data sets beside those of the run
evaluate::Evaluation evaluate(Job& job, const std::vector<std::filesystem::path>& further_data);

/// Makes plots/ and video/. Plots and videos that cannot be made (no gnuplot, no renderer, disk
/// full) are left out.
/// @return the reason in one line; empty if all were made
std::string draw_plots(Job& job);
/// @param shown  the problem with the [render] to film by
std::string make_videos(Job& job, const scene::Problem& shown, const std::string& renderer);

/// report.html, from what is there. @throws UserError when it cannot be written
void make_report(Job& job);

// The single stages: their declared inputs and their work.
Stage data_stage(const Job& job);
Stage fit_stage(const Job& job, const FitRequest& request);
Stage evaluation_stage(const Job& job, const std::vector<std::filesystem::path>& further_data);
Stage plots_stage(const Job& job);
Stage film_stage(const Job& job, const scene::Problem& shown, const std::string& renderer);
Stage report_stage(const Job& job);

}  // namespace fricid::workflow
