#include "fricid/render/palette.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include <fmt/format.h>

#include "fricid/data/model_file.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::render {
namespace {

constexpr friction::PlotLook kOracle{"#000000", 7}, kExternal{"#E7298A", 2}, kSum{"#2A6FDB", 15},
    kUnknown{"#708090", 3};

/// The look of a law's table row, or that of the oracle, sums of laws, external or unknown models.
friction::PlotLook plain_look(std::string_view law) {
  for (const auto table : {friction::law_table(), friction::robot_law_table()})
    for (const friction::LawInfo& row : table)
      if (row.name == law) return row.look;
  return law == "oracle" ? kOracle : law == "external" ? kExternal : law == "sum" ? kSum : kUnknown;
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

/// Law of the whole robot or of the first joint; "sum" where a joint has several, "external"
/// without a model file, empty where there is no friction.
std::string law_of(const std::optional<data::ModelFile>& file) {
  if (!file) return "external";
  const friction::RobotFriction& friction = file->arm.friction.model;
  if (friction.has_whole()) return friction.whole().law;
  if (std::ranges::any_of(friction.joints(),
                          [](const auto& joint) { return joint.laws.size() > 1; }))
    return "sum";
  if (friction.joint_count() == 0 || friction.joints().front().laws.empty()) return {};
  return friction.joints().front().laws.front().law;
}

}  // namespace

Look look_of_law(const std::string& law, int again) {
  static constexpr std::array kShares{0.0, 0.4, -0.45, 0.65, -0.7};
  const friction::PlotLook look = plain_look(law);
  const auto shade = static_cast<std::size_t>(again) % kShares.size();
  return {shaded(look.colour, kShares[shade]), law == "oracle" ? 2 : 1 + again % 4, look.marker};
}

std::vector<RunModel> models_of_run(const evaluate::Evaluation& evaluation,
                                    const workflow::RunFolder& run) {
  std::vector<RunModel> models;
  std::map<std::string, int> uses;
  for (const evaluate::ModelResult& entry : evaluation.models) {
    if (entry.is_oracle && entry.name != "oracle") continue;
    const auto known = std::ranges::find(models, entry.name, &RunModel::name);
    if (known != models.end()) {
      known->seeds.push_back(entry.seed);
      continue;
    }
    const std::string& label = entry.label.empty() ? entry.name : entry.label;
    RunModel model{entry.name, label, {}, {entry.seed}, entry.is_oracle, {}};
    model.law = model.is_oracle
                    ? "oracle"
                    : law_of(workflow::if_there(run.model(model.first_fit()), data::load_model));
    model.look = look_of_law(model.law, uses[model.law]++);
    models.push_back(std::move(model));
  }
  return models;
}

}  // namespace fricid::render
