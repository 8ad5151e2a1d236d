#include "fricid/sim/truth.hpp"

#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/base/json.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/signal_file.hpp"

namespace fricid::sim {

namespace {

using data::Json;

struct ModifierText {
  std::string name;
  int order = 1;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("of the modifier"));
    archive("order", order, number("", 1, 1e6, "its number of terms"));
  }
};

struct ParameterText {
  std::string owner, symbol, unit;
  double value = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("owner", owner, text("law or modifier"));
    archive("symbol", symbol, text("of the owner's table"));
    archive("unit", unit, text("of the value"));
    archive("value", value, any_number("", "of the parameter"));
  }
};

struct LawText {
  int elements = 0;
  std::string law;
  std::vector<ModifierText> modifiers;
  std::vector<ParameterText> parameters;

  template <class Archive>
  void visit(Archive& archive) {
    archive("elements", elements, number("", 0, 1e6, "its number of elements"));
    archive("law", law, text("its name"));
    archive.sections("modifiers", modifiers, "in their order");
    archive.sections("parameters", parameters, "in the order of theta");
  }
};

struct JointText {
  std::vector<LawText> laws;

  template <class Archive>
  void visit(Archive& archive) {
    archive.sections("laws", laws, "that act on the joint");
  }
};

struct FrictionText {
  std::vector<JointText> joints;

  template <class Archive>
  void visit(Archive& archive) {
    archive.sections("joints", joints, "of the robot");
  }
};

}  // namespace

std::string friction_text(const friction::Friction& friction) {
  FrictionText text;
  for (const friction::JointSpec& joint : friction.model.joints()) {
    std::vector<LawText>& laws = text.joints.emplace_back().laws;
    for (const friction::LawSpec& law : joint.laws) {
      LawText& item = laws.emplace_back(
          LawText{.elements = law.elements, .law = law.law, .modifiers = {}, .parameters = {}});
      for (const friction::ModifierSpec& modifier : law.modifiers)
        item.modifiers.push_back({modifier.name, modifier.order});
    }
  }
  const auto& parameters = friction.model.parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const friction::ParameterRef& p = parameters[i];
    text.joints[static_cast<std::size_t>(p.joint)]
        .laws[static_cast<std::size_t>(p.law)]
        .parameters.push_back({p.owner, p.symbol, std::string(p.info.unit), friction.theta[i]});
  }
  Json json = Json::object();
  data::JsonWriter writer(json);
  text.visit(writer);
  return json.dump();
}

friction::Friction friction_of(const std::string& text, const std::string& place) {
  FrictionText read;
  const auto json = parse_json<Json>(text, place);
  data::JsonReader reader(json, place);
  read.visit(reader);
  std::vector<friction::JointSpec> joints;
  std::vector<double> theta;
  for (const JointText& joint : read.joints) {
    friction::JointSpec& spec = joints.emplace_back();
    for (const LawText& law : joint.laws) {
      friction::LawSpec& law_spec = spec.laws.emplace_back(
          friction::LawSpec{.law = law.law, .elements = law.elements, .modifiers = {}});
      for (const ModifierText& modifier : law.modifiers)
        law_spec.modifiers.push_back({modifier.name, modifier.order});
      for (const ParameterText& parameter : law.parameters) theta.push_back(parameter.value);
    }
  }
  try {
    return {friction::RobotFriction(std::move(joints)), std::move(theta)};
  } catch (const UserError& error) {
    throw UserError("{}: {}", place, error.what());
  }
}

void save_truth(const Truth& truth, const std::filesystem::path& path) {
  data::save_signals(truth, path);
}

Truth load_truth(const std::filesystem::path& path) {
  auto truth = data::load_signals<Truth>(path);
  truth.name = path.stem().string();
  const friction::RobotFriction& model = truth.friction.model;
  const std::string place = path.string() + ": attribute friction";
  if (model.joint_count() != static_cast<int>(truth.joint_names.size()))
    throw UserError("{} has {} joints; allowed: {}, as joint_names", place, model.joint_count(),
                    truth.joint_names.size());
  friction::check_bounds(truth.friction, truth.joint_names, place);
  if (truth.trace.z.cols() != model.state_size())
    throw UserError("{} has {} states; allowed: {}, as table z", place, model.state_size(),
                    truth.trace.z.cols());
  return truth;
}

}  // namespace fricid::sim
