// The steps of a run, as the commands of the program do them.
#include "run.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <variant>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/cli/command_line.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/manifest.hpp"
#include "fricid/workflow/run_folder.hpp"
#include "job.hpp"

namespace fricid::python {
namespace {

namespace fs = std::filesystem;

/// Input of a run and its folder: the text of a scene, or a scene file or run folder.
struct Source {
  std::variant<std::string, fs::path> scene;
  fs::path folder;
  std::optional<std::uint64_t> seed;
  bool fresh;
  int jobs;

  scene::Problem problem() const {
    if (const auto* text = std::get_if<std::string>(&scene))
      return workflow::load_problem_text(*text, seed);
    return workflow::load_problem(std::get<fs::path>(scene), seed);
  }
  workflow::Job open(scene::Problem problem) const {
    return workflow::open_job(std::move(problem), folder, fresh, jobs, say);
  }
};

void simulate(const Source& source, const nb::object& progress) {
  do_job(progress, [&] {
    scene::Problem problem = source.problem();
    if (!problem.scene.simulates())
      throw UserError("{}: found no [friction]; the scene imports logs: identify it",
                      problem.scene.name);
    workflow::require_memory(problem, {}, source.jobs);
    workflow::Job job = source.open(std::move(problem));
    workflow::make_data(job);
  });
}

/// @return whether data and fits may be trusted
bool identify(const Source& source, const std::vector<std::string>& models,
              const std::vector<int>& seeds, const nb::object& progress) {
  return job(progress, [&] {
    scene::Problem problem = source.problem();
    if (models.empty()) workflow::require_models(problem.scene);
    scene::require_logs(problem);
    const auto requests = workflow::requested_fits(problem.scene, models, seeds);
    workflow::require_memory(problem, requests, source.jobs);
    workflow::Job job = source.open(std::move(problem));
    workflow::make_data(job);
    const bool sound = workflow::data_are_sound(job);
    const bool healthy = workflow::identify(job, requests, !models.empty() || !seeds.empty());
    return sound && healthy;
  });
}

/// @return whether the evaluation may be trusted and ranks models
bool evaluate(const Source& source, const std::vector<fs::path>& data, const nb::object& progress) {
  return job(progress, [&] {
    workflow::require_run_folder(source.folder);
    scene::Problem problem = source.problem();
    if (data.empty()) workflow::require_validation(problem.scene);
    workflow::Job job = source.open(std::move(problem));
    const evaluate::Evaluation evaluation = workflow::evaluate(job, data);
    return evaluation.trusted() && evaluation.meaningful();
  });
}

/// @return why plots could not be made; empty if they were
std::string draw(const Source& source, const nb::object& progress) {
  return job(progress, [&] {
    workflow::require_run_folder(source.folder);
    workflow::Job job = source.open(source.problem());
    const std::string missed = workflow::draw_plots(job);
    workflow::make_report(job);
    return missed;
  });
}

std::string outdated(const workflow::RunFolder& run, const fs::path& file) {
  return workflow::outdated(run, data::load<workflow::Manifest>(run.manifest()), file);
}

}  // namespace

void bind_run(nb::module_& m) {
  using nb::literals::operator""_a;
  using workflow::RunFolder;
  nb::class_<RunFolder>(m, "RunFolder", "Paths of the files of a run.")
      .def(nb::init<fs::path>(), "path"_a)
      .def_prop_ro("manifest", &RunFolder::manifest)
      .def_prop_ro("evaluation", &RunFolder::evaluation)
      .def_prop_ro("payload", &RunFolder::payload)
      .def_prop_ro("models",
                   [](const RunFolder& run) { return run.files_in(run.models(), ".json"); })
      .def_prop_ro("fits", [](const RunFolder& run) { return run.files_in(run.fits(), ".json"); })
      .def_prop_ro("recordings",
                   [](const RunFolder& run) { return run.files_in(run.recordings(), ".h5"); })
      .def("outdated", &outdated, "file"_a,
           "Why a result of the run is not of its present data and fits; empty: it is.")
      .def_static("diagnosis_beside", &RunFolder::diagnosis_beside, "recording"_a,
                  "What the doctor found in a recording.");
  nb::class_<Source>(m, "Source", "A scene, and the folder of its run.")
      .def(
          "__init__",
          [](Source* self, std::variant<std::string, fs::path> scene, const fs::path& folder,
             std::optional<std::uint64_t> seed, bool fresh, int jobs) {
            if (seed) require_within(limits::kSeed, *seed, "seed");
            new (self) Source{std::move(scene), folder, seed, fresh, jobs};
          },
          "scene"_a, "folder"_a, "seed"_a = nb::none(), "fresh"_a = false, "jobs"_a = 0);
  m.def("simulate", &simulate, "source"_a, "progress"_a = nb::none());
  m.def("identify", &identify, "source"_a, "models"_a, "seeds"_a, "progress"_a = nb::none());
  m.def("evaluate", &evaluate, "source"_a, "data"_a, "progress"_a = nb::none());
  m.def("draw", &draw, "source"_a, "progress"_a = nb::none());
  m.def(
      "command_line",
      [](std::vector<std::string> arguments) {
        std::vector<char*> words;
        for (std::string& argument : arguments) words.push_back(argument.data());
        words.push_back(nullptr);
        const nb::gil_scoped_release released;
        return cli::run_command_line(static_cast<int>(arguments.size()), words.data(), {});
      },
      "arguments"_a, "The program `fricid`; handles Ctrl-C. Returns its exit code.");
}

}  // namespace fricid::python
