#include "log_import.hpp"

#include <fmt/format.h>

#include <optional>

#include "fricid/data/contract.hpp"
#include "fricid/data/log_part.hpp"

namespace fricid::workflow {

namespace fs = std::filesystem;

std::vector<data::Dataset> import_logs(const scene::Problem& part,
                                       const std::vector<std::string>& logs, RecordingName name,
                                       const std::function<void(const std::string&)>& say) {
  std::optional<data::Contract> contract;
  if (!part.contract_path.empty()) contract = data::load_contract(part.contract_path);
  std::vector<data::Dataset> sets;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const fs::path path = scene::find_log(part, logs[i]);
    const data::Dataset part_of_log =
        data::cut(contract ? data::import_log(path, *contract) : data::load_dataset(path),
                  data::log_part(logs[i]), path.string());
    sets.push_back(
        data::of_joints(part_of_log, part.scene.joints, part.scene.robot.fix, path.string()));
    for (const std::string& warning : data::check_dataset(sets.back(), path.string())) say(warning);
    sets.back().name = name(static_cast<int>(i));
  }
  return sets;
}

void declare_contract(Inputs& inputs, const scene::Problem& problem) {
  if (!problem.contract_path.empty()) inputs.file("contract", problem.contract_path);
}

// Two logs may have one name in different folders.
void declare_logs(Inputs& inputs, const scene::Problem& problem,
                  const std::vector<std::string>& logs, RecordingName name) {
  for (std::size_t i = 0; i < logs.size(); ++i)
    inputs.file(fmt::format("log of {}", name(static_cast<int>(i))),
                scene::find_log(problem, logs[i]));
}

}  // namespace fricid::workflow
