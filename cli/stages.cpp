#include "stages.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <tuple>

#include "fricid/base/error.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::cli {
namespace {

void say(const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); }

bool is_run_folder(const std::filesystem::path& path) {
  return std::filesystem::exists(path / "manifest.json");
}

std::string key_of_fit(const Job& job, const data::ModelConfig& config, int seed) {
  data::Scene read = job.problem.scene;
  read.models = {config};
  read.models[0].seeds = {seed};
  read.evaluate = {};
  read.render = {};
  read.description.clear();
  // fits see the URDF alone; what the MJCF changes, the data show
  return data::to_toml(read) + sha256_of_file(job.problem.urdf_path) +
         job.folder.outputs_of("data");
}

nlohmann::json to_json(const sim::TrajectoryReport& report, const data::Problem& problem) {
  nlohmann::json joints;
  for (std::size_t j = 0; j < report.joints.size(); ++j) {
    const sim::JointMargins& margin = report.joints[j];
    joints[problem.robot.joints[j].name] = {{"position_rad", margin.position_rad},
                                            {"velocity", margin.velocity},
                                            {"acceleration", margin.acceleration},
                                            {"jerk", margin.jerk},
                                            {"torque", margin.torque}};
  }
  return {{"name", report.name},
          {"feasible", report.feasible},
          {"condition", report.condition},
          {"log_det_start", report.log_det_start},
          {"log_det", report.log_det},
          {"evaluations", report.evaluations},
          {"clearance_m", report.clearance_m},
          {"closest", report.closest},
          {"margins", joints}};
}

std::vector<std::string> simulate_data(Job& job) {
  say("simulate: " + job.problem.scene.name);
  const sim::Simulation truth = sim::simulate(job.problem, job.jobs);
  std::vector<std::string> files;
  const auto save = [&](const std::vector<data::Dataset>& sets,
                        const std::vector<sim::Truth>& truths) {
    for (std::size_t i = 0; i < sets.size(); ++i) {
      files.push_back("data/" + sets[i].name + ".h5");
      data::save_dataset(sets[i], job.folder.path() / files.back());
      files.push_back("truth/" + sets[i].name + ".h5");
      sim::save_truth(truths[i], job.folder.path() / files.back());
    }
  };
  save(truth.train, truth.train_truth);
  save(truth.validation, truth.validation_truth);

  nlohmann::json excitation;
  for (const auto& report : truth.excitation.reports)
    excitation.push_back(to_json(report, job.problem));
  files.emplace_back("excitation.json");
  write_file_atomically(job.folder.path() / files.back(), excitation.dump(2) + "\n");
  return files;
}

std::vector<std::string> import_data(Job& job) {
  const data::Problem& problem = job.problem;
  const auto contract = data::load_contract(problem.contract_path);
  std::vector<data::Dataset> sets;
  const auto import = [&](const std::vector<std::string>& logs, const std::string& kind) {
    for (std::size_t i = 0; i < logs.size(); ++i) {
      const auto path = data::find_log(problem, logs[i]);
      sets.push_back(data::import_log(path, contract));
      for (const std::string& warning : data::check_dataset(sets.back(), path.string()))
        say(warning);
      sets.back().name = fmt::format("{}_{}", kind, i);
    }
  };
  import(problem.scene.data.train, "train");
  import(problem.scene.data.validation, "validation");

  std::vector<std::string> files;
  for (const data::Dataset& dataset : sets) {
    const auto findings = doctor::diagnose(dataset, &problem.robot);
    for (const doctor::Finding& finding : findings)
      if (doctor::is_damage(finding)) say(dataset.name + ": " + doctor::to_text(finding, dataset));
    files.push_back("data/" + dataset.name + ".doctor.json");
    write_file_atomically(job.folder.path() / files.back(), doctor::to_json(findings, dataset));
  }
  for (const data::Dataset& dataset : sets) {
    files.push_back("data/" + dataset.name + ".h5");
    data::save_dataset(dataset, job.folder.path() / files.back());
  }
  say(fmt::format("import: {}: {} recordings", problem.scene.name, sets.size()));
  return files;
}

/// Data sets of the folder whose names start with `kind`, in order of their number.
std::vector<data::Dataset> load_datasets(const Job& job, const std::string& kind) {
  std::vector<data::Dataset> sets;
  for (int i = 0;; ++i) {
    const auto path = job.folder.path() / "data" / fmt::format("{}_{}.h5", kind, i);
    if (!std::filesystem::exists(path)) return sets;
    sets.push_back(data::load_dataset(path));
  }
}

std::vector<int> parse_seeds(const std::string& text) {
  std::vector<int> seeds;
  for (std::size_t at = 0; at < text.size();) {
    int first = 0, last = 0, used = 0;
    const char* rest = text.c_str() + at;
    if (std::sscanf(rest, "%d-%d%n", &first, &last, &used) == 2) {
    } else if (std::sscanf(rest, "%d%n", &first, &used) == 1) {
      last = first;
    }
    at += static_cast<std::size_t>(used);
    const bool separated = at == text.size() || text[at] == ',';
    if (used == 0 || !separated || first < 0 || last < first || last - first > 1000)
      throw UserError("--seeds {}: allowed: numbers and ranges such as 1-5 or 1,3", text);
    for (int seed = first; seed <= last; ++seed) seeds.push_back(seed);
    ++at;
  }
  return seeds;
}

/// The models to fit: all of the scene, or those named, which may also be laws of the table.
std::vector<data::ModelConfig> chosen_models(const data::Problem& problem,
                                             const std::vector<std::string>& names) {
  if (names.empty()) return problem.scene.models;
  std::vector<data::ModelConfig> chosen;
  for (const std::string& name : names) {
    const auto known = std::find_if(problem.scene.models.begin(), problem.scene.models.end(),
                                    [&](const auto& model) { return model.name == name; });
    chosen.emplace_back();
    if (known != problem.scene.models.end()) {
      chosen.back() = *known;
    } else {
      chosen.back().name = chosen.back().label = chosen.back().law = name;
      chosen.back().method = friction::is_learned(name) ? "multi_step" : "conventional";
    }
  }
  return chosen;
}

/// Folder of a run that names none.
std::string default_name(const data::Problem& problem, const RunOptions& options) {
  return options.seed ? fmt::format("{}_{}", problem.scene.name, *options.seed)
                      : problem.scene.name;
}

}  // namespace

std::string key_of_robot(const data::Problem& problem) {
  std::string key = sha256_of_file(problem.urdf_path);
  if (!problem.mjcf_path.empty()) key += sha256_of_text(sim::compiled_mjcf(problem.mjcf_path));
  return key;
}

std::string key_of_data(const data::Problem& problem) {
  data::Scene read = problem.scene;
  read.models.clear();
  read.identify = {};
  read.evaluate = {};
  read.render = {};
  read.description.clear();
  std::string key = data::to_toml(read) + key_of_robot(problem);
  if (!problem.contract_path.empty()) key += sha256_of_file(problem.contract_path);
  for (const auto* logs : {&problem.scene.data.train, &problem.scene.data.validation})
    for (const std::string& log : *logs) key += sha256_of_file(data::find_log(problem, log));
  return key;
}

std::string id_of(const std::string& model, int seed) { return fmt::format("{}_s{}", model, seed); }

Fits fits_of(const Job& job) {
  const auto& models = job.problem.scene.models;
  const nlohmann::json by_name = job.folder.described("fitted_by_name");
  constexpr std::string_view kIdentify = "identify ";
  std::vector<std::tuple<std::ptrdiff_t, std::string, int>> counted;
  Fits fits;
  for (const std::string& stage : job.folder.stages()) {
    if (!stage.starts_with(kIdentify)) continue;
    const std::string id = stage.substr(kIdentify.size());
    const std::size_t end = std::min(id.rfind("_s"), id.size());
    const std::string name = id.substr(0, end);
    int seed = 0;
    if (std::sscanf(id.c_str() + end, "_s%d", &seed) != 1) continue;
    const data::ModelConfig config = chosen_models(job.problem, {name}).front();
    const auto place = std::ranges::find(models, name, &data::ModelConfig::name);
    const bool of_scene = place != models.end() && std::ranges::count(config.seeds, seed) > 0;
    const bool asked_for = by_name.is_object() && by_name.contains(id);
    if ((of_scene || asked_for) && job.folder.stands(stage, key_of_fit(job, config, seed)))
      counted.emplace_back(place - models.begin(), name, seed);
    else
      fits.left_out.push_back(id);
  }
  std::ranges::sort(counted);
  for (const auto& [place, name, seed] : counted) fits.counted.push_back(id_of(name, seed));
  return fits;
}

data::Problem load_problem(const RunOptions& options) {
  const bool again = is_run_folder(options.target);
  data::Scene scene = data::load_scene(again ? options.target / "scene.toml" : options.target);
  if (options.seed) scene.seed = *options.seed;
  data::Problem problem = data::resolve(std::move(scene));
  if (!again && problem.scene.simulates()) sim::make_arm(problem);
  return problem;
}

void require_run_folder(const std::filesystem::path& path) {
  if (!is_run_folder(path))
    throw UserError("{}: found no manifest.json; allowed: the folder of a run", path.string());
}

Job open_job(data::Problem problem, const RunOptions& options, const CommonOptions& common) {
  std::filesystem::path folder = options.output;
  if (folder.empty())
    folder = is_run_folder(options.target)
                 ? options.target
                 : std::filesystem::path("run") / default_name(problem, options);

  Job job{std::move(problem), RunFolder(folder, common.fresh), common.jobs};
  const std::string scene = data::to_toml(job.problem.scene);
  if (!std::filesystem::exists(folder / "scene.toml") || read_file(folder / "scene.toml") != scene)
    write_file_atomically(folder / "scene.toml", scene);
  job.folder.describe("scene", job.problem.scene.name);
  job.folder.describe("seed", job.problem.scene.seed);
  nlohmann::json inputs;
  for (const auto& path : job.problem.inputs) inputs[path.string()] = sha256_of_file(path);
  job.folder.describe("inputs", inputs);
  return job;
}

void make_data(Job& job) {
  const bool ran = job.folder.stage("data", key_of_data(job.problem), [&] {
    return job.problem.scene.simulates() ? simulate_data(job) : import_data(job);
  });
  if (!ran) say("data: up to date");
}

bool identify_models(Job& job, const std::vector<std::string>& names, const std::string& seeds) {
  std::optional<estimate::Prepared> prepared;
  bool healthy = true;
  for (const data::ModelConfig& config : chosen_models(job.problem, names))
    for (const int seed : seeds.empty() ? config.seeds : parse_seeds(seeds)) {
      const std::string id = id_of(config.name, seed);
      if (!names.empty() || !seeds.empty()) {
        nlohmann::json by_name = job.folder.described("fitted_by_name");
        by_name[id] = true;
        job.folder.describe("fitted_by_name", by_name);
      }
      const std::string key = key_of_fit(job, config, seed);
      const bool ran = job.folder.stage("identify " + id, key, [&] {
        if (!prepared)
          prepared = estimate::prepare(job.problem, load_datasets(job, "train"), job.jobs);
        const estimate::FitReport report = estimate::fit_model(
            job.problem, *prepared, config, seed, job.jobs,
            {job.folder.path() / "checkpoint" / (id + ".json"), job.folder.key_of(key)});
        std::vector<std::string> files{"models/" + id + ".json", "fit/" + id + ".json"};
        data::save_model(report.model, job.folder.path() / files[0]);
        estimate::save_fit_report(report, job.folder.path() / files[1]);
        say(report.brief());
        return files;
      });
      if (!ran) say("identify " + id + ": up to date");
      const auto fit = nlohmann::json::parse(read_file(job.folder.path() / "fit" / (id + ".json")));
      healthy = healthy && fit.value("usable", false);
    }
  return healthy;
}

}  // namespace fricid::cli
