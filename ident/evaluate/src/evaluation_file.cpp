#include "fricid/evaluate/evaluation_file.hpp"

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/names.hpp"

namespace fricid::evaluate {
namespace {

using Json = nlohmann::json;

void check_names(const Json& evaluation, const std::string& file) {
  if (evaluation.contains("scene"))
    require_name(Named::kScene, evaluation.at("scene").get<std::string>(), file);
  for (const Json& name : evaluation.value("trajectories", Json::array()))
    require_name(Named::kTrajectory, name.get<std::string>(), file);
  for (const char* list : {"models", "summary"})
    for (const Json& model : evaluation.value(list, Json::array())) {
      const auto name = model.at("name").get<std::string>();
      require_written_name(Named::kModel, name, file);
      require_label(model.value("label", name), "label", file);
    }
}

}  // namespace

Json load_evaluation(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "evaluation.json";
  const std::string file = path.string();
  if (!std::filesystem::exists(path))
    throw UserError("{}: found no evaluation; run `fricid evaluate` first", file);
  const Json evaluation = Json::parse(read_file(path), nullptr, false);
  if (evaluation.is_discarded()) throw UserError("{}: found no JSON", file);
  try {
    if (evaluation.value("format", "") != "fricid.evaluation/1")
      throw UserError("{}: found no \"format\": \"fricid.evaluation/1\"", file);
    check_names(evaluation, file);
  } catch (const Json::exception& error) {
    throw UserError("{}: {}", file, error.what());
  }
  return evaluation;
}

}  // namespace fricid::evaluate
