#include "fricid/sim/truth.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/data/signal_file.hpp"

namespace fricid::sim {

using nlohmann::json;

std::string friction_text(const friction::Friction& friction) {
  json joints = json::array();
  for (const friction::JointSpec& joint : friction.model.joints()) {
    json laws = json::array();
    for (const friction::LawSpec& law : joint.laws) {
      json modifiers = json::array();
      for (const friction::ModifierSpec& modifier : law.modifiers)
        modifiers.push_back({{"name", modifier.name}, {"order", modifier.order}});
      laws.push_back({{"law", law.law},
                      {"elements", law.elements},
                      {"modifiers", modifiers},
                      {"parameters", json::array()}});
    }
    joints.push_back({{"laws", laws}});
  }
  const auto& parameters = friction.model.parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const friction::ParameterRef& p = parameters[i];
    joints[static_cast<std::size_t>(p.joint)]["laws"][static_cast<std::size_t>(p.law)]["parameters"]
        .push_back({{"owner", p.owner},
                    {"symbol", p.symbol},
                    {"value", friction.theta[i]},
                    {"unit", std::string(p.info.unit)}});
  }
  return json{{"joints", joints}}.dump();
}

friction::Friction friction_of(const std::string& text) {
  const json root = json::parse(text);
  std::vector<friction::JointSpec> joints;
  std::vector<double> theta;
  for (const json& joint : root.at("joints")) {
    friction::JointSpec& spec = joints.emplace_back();
    for (const json& law : joint.at("laws")) {
      friction::LawSpec& law_spec = spec.laws.emplace_back();
      law_spec.law = law.at("law").get<std::string>();
      law_spec.elements = law.at("elements").get<int>();
      for (const json& modifier : law.at("modifiers"))
        law_spec.modifiers.push_back(
            {modifier.at("name").get<std::string>(), modifier.at("order").get<int>()});
      for (const json& parameter : law.at("parameters"))
        theta.push_back(parameter.at("value").get<double>());
    }
  }
  return {friction::RobotFriction(std::move(joints)), std::move(theta)};
}

void save_truth(const Truth& truth, const std::filesystem::path& path) {
  data::save_signals(truth, path);
}

Truth load_truth(const std::filesystem::path& path) {
  Truth truth;
  try {
    truth = data::load_signals<Truth>(path);
  } catch (const json::exception& error) {
    throw UserError("{}: attribute friction: {}", path.string(), error.what());
  }
  truth.name = path.stem().string();
  if (static_cast<int>(truth.friction.theta.size()) != truth.friction.model.parameter_count() ||
      truth.trace.z.cols() != truth.friction.model.state_size())
    throw UserError("{}: attribute friction does not fit table z or its own parameters",
                    path.string());
  return truth;
}

}  // namespace fricid::sim
