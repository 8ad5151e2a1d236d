#include "fricid/render/palette.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "fricid/evaluate/evaluation_file.hpp"
#include "json_files.hpp"

namespace fricid::render {
namespace {

struct Hue {
  std::string_view law, colour;
  int marker;
};

constexpr std::array kHues{Hue{"oracle", "#000000", 7},
                           Hue{"coulomb_viscous", "#CC79A7", 9},
                           Hue{"stribeck", "#E69F00", 11},
                           Hue{"dahl", "#56B4E9", 5},
                           Hue{"lugre", "#009E73", 13},
                           Hue{"gms", "#D55E00", 7},
                           Hue{"lvm", "#0072B2", 15},
                           Hue{"load_dependent", "#882255", 4},
                           Hue{"neural", "#8C7A00", 8},
                           Hue{"maxwell_slip", "#7A5230", 6},
                           Hue{"viscous_power", "#44AA99", 10},
                           Hue{"lvm1", "#5D3FD3", 12},
                           Hue{"lvm4", "#00446B", 14},
                           Hue{"lugre_classic", "#66A61E", 12},
                           Hue{"nn", "#B8860B", 6},
                           Hue{"rnn", "#A0522D", 9},
                           Hue{"lvm_paper", "#4169E1", 4},
                           Hue{"external", "#E7298A", 2},
                           Hue{"", "#708090", 3}};  // what is not in the table

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
  const auto hue = std::find_if(kHues.begin(), kHues.end() - 1,
                                [&](const Hue& candidate) { return candidate.law == law; });
  const auto shade = static_cast<std::size_t>(again) % kShares.size();
  return {shaded(hue->colour, kShares[shade]), law == "oracle" ? 2 : 1 + again % 4, hue->marker};
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
