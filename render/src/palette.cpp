#include "fricid/render/palette.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "fricid/evaluate/evaluation_file.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "json_files.hpp"

namespace fricid::render {
namespace {

constexpr friction::PlotLook kOracle{"#000000", 7}, kExternal{"#E7298A", 2}, kUnknown{"#708090", 3};

/// The look that a law's row in the tables states, or that of what has no row.
friction::PlotLook plain_look(std::string_view law) {
  for (const auto table : {friction::law_table(), friction::robot_law_table()})
    for (const friction::LawInfo& row : table)
      if (row.name == law) return row.look;
  return law == "oracle" ? kOracle : law == "external" ? kExternal : kUnknown;
}

/// "#rrggbb" moved by `share` towards white (positive) or black (negative).
std::string shaded(std::string_view colour, double share) {
  std::string result = "#";
  for (std::size_t i = 1; i < 7; i += 2) {
    const int channel = std::stoi(std::string(colour.substr(i, 2)), nullptr, 16);
    const double end = share > 0 ? 255 : 0;
    const auto moved = static_cast<int>(std::lround(channel + std::abs(share) * (end - channel)));
    result += fmt::format("{:02X}", moved);
  }
  return result;
}

/// Law of the whole robot or of the first joint in a model file; "external" without a file, empty
/// when it has none to read.
std::string law_of(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return "external";
  const auto model = read_json_if_there(file);
  for (const char* place : {"/friction_of_robot/law", "/friction/0/0/law"})
    if (const nlohmann::json::json_pointer law(place); model.contains(law))
      return model.at(law).get<std::string>();
  return {};
}

}  // namespace

Look look_of_law(const std::string& law, int again) {
  static constexpr std::array kShares{0.0, 0.4, -0.45, 0.65, -0.7};
  const friction::PlotLook look = plain_look(law);
  const auto shade = static_cast<std::size_t>(again) % kShares.size();
  return {shaded(look.colour, kShares[shade]), law == "oracle" ? 2 : 1 + again % 4, look.marker};
}

std::vector<RunModel> models_of_run(const std::filesystem::path& folder) {
  const auto evaluation = evaluate::load_evaluation(folder);
  std::vector<RunModel> models;
  std::map<std::string, int> uses;
  for (const auto& entry : evaluation.at("models")) {
    const auto name = entry.at("name").get<std::string>();
    const bool is_oracle = entry.value("is_oracle", false);
    const int seed = entry.value("seed", 1);
    if (is_oracle && name != "oracle") continue;
    const auto known = std::find_if(models.begin(), models.end(),
                                    [&](const RunModel& model) { return model.name == name; });
    if (known != models.end()) {
      known->seeds.push_back(seed);
      continue;
    }
    RunModel model{name, entry.value("label", name), {}, {seed}, is_oracle, {}};
    model.law =
        is_oracle ? "oracle" : law_of(folder / "models" / fmt::format("{}_s{}.json", name, seed));
    model.look = look_of_law(model.law, uses[model.law]++);
    models.push_back(std::move(model));
  }
  return models;
}

}  // namespace fricid::render
