#include "log_import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>

#include "fricid/data/contract.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/workflow/check.hpp"
#include "fricid/workflow/torque_timing.hpp"

namespace fricid::workflow {

namespace fs = std::filesystem;

std::vector<SceneLog> named(const std::vector<std::string>& logs, std::string (*name)(int)) {
  std::vector<SceneLog> result;
  for (const std::string& log : logs)
    result.push_back({log, name(static_cast<int>(result.size()))});
  return result;
}

std::vector<SceneLog> logs_of_data(const scene::Problem& problem) {
  std::vector<SceneLog> logs = named(problem.scene.data.train, RunFolder::training);
  std::ranges::copy(named(problem.scene.data.validation, RunFolder::validation),
                    std::back_inserter(logs));
  return logs;
}

std::vector<data::Dataset> logs_of_scene(const scene::Problem& part, std::span<const SceneLog> logs,
                                         const std::function<void(const std::string&)>& say) {
  std::optional<data::Contract> contract;
  if (!part.contract_path.empty())
    contract = of_robot(data::load_contract(part.contract_path), part.robot);
  std::map<fs::path, std::vector<std::size_t>> parts_of;
  for (std::size_t i = 0; i < logs.size(); ++i)
    parts_of[scene::find_log(part, logs[i].log)].push_back(i);
  std::vector<data::Dataset> sets(logs.size());
  for (const auto& [path, parts] : parts_of) {
    const data::Dataset whole =
        contract ? data::import_log(path, *contract, say) : data::load_dataset(path);
    for (const std::size_t i : parts) {
      sets[i] = data::of_joints(data::cut(whole, data::log_part(logs[i].log), path.string()),
                                part.scene.joints, part.scene.robot.fix, path.string());
      for (const std::string& warning : data::check_dataset(sets[i], path.string())) say(warning);
      sets[i].name = logs[i].recording;
    }
  }
  if (contract) settle_torque_timing(sets, part.robot, contract->torque, say);
  return sets;
}

void declare_contract(Inputs& inputs, const scene::Problem& problem) {
  if (!problem.contract_path.empty()) inputs.file("contract", problem.contract_path);
}

// Two logs may have one name in different folders.
void declare_logs(Inputs& inputs, const scene::Problem& problem, std::span<const SceneLog> logs) {
  for (const SceneLog& log : logs)
    inputs.file(fmt::format("log of {}", log.recording), scene::find_log(problem, log.log));
}

}  // namespace fricid::workflow
