#include "fricid/sim/truth.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/data/hdf5.hpp"

namespace fricid::sim {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "fricid.truth/1";

struct Table {
  const char* name;
  const char* unit;
  RowMatrix Trace::*values;
};
constexpr std::array kTables{Table{"q", "rad", &Trace::q},
                             Table{"v", "rad/s", &Trace::v},
                             Table{"a", "rad/s^2", &Trace::a},
                             Table{"tau", "N m", &Trace::tau},
                             Table{"tau_f", "N m", &Trace::tau_f},
                             Table{"z", "law's own", &Trace::z},
                             Table{"temperature", "K", &Trace::temperature}};

json to_json(const friction::Friction& friction) {
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
  return {{"joints", joints}};
}

friction::Friction from_json(const json& root) {
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

}  // namespace

void save_truth(const Truth& truth, const std::filesystem::path& path) {
  data::write_hdf5(path, kFormat, [&](data::H5Writer& file) {
    file.attribute("joint_names", truth.joint_names);
    file.attribute("rate_hz", truth.rate_hz);
    file.attribute("friction", to_json(truth.friction).dump());
    file.vector("t", truth.trace.t, "s");
    for (const Table& table : kTables)
      file.matrix(table.name, truth.trace.*table.values, table.unit);
  });
}

Truth load_truth(const std::filesystem::path& path) {
  const data::H5Reader file(path, kFormat);
  Truth truth;
  truth.name = path.stem().string();
  truth.joint_names = file.joint_names();
  truth.rate_hz = file.number_attribute("rate_hz");
  truth.trace.t = file.vector("t");
  const auto n = static_cast<int>(truth.joint_names.size());
  for (const Table& table : kTables) {
    RowMatrix& values = truth.trace.*table.values;
    values = file.matrix(table.name, table.values == &Trace::z ? -1 : n);
    if (values.rows() != truth.trace.t.size())
      throw UserError("{}: table {} has {} rows; allowed: {}, as t", path.string(), table.name,
                      values.rows(), truth.trace.t.size());
  }
  try {
    truth.friction = from_json(json::parse(file.text_attribute("friction")));
  } catch (const json::exception& error) {
    throw UserError("{}: attribute friction: {}", path.string(), error.what());
  }
  if (static_cast<int>(truth.friction.theta.size()) != truth.friction.model.parameter_count() ||
      truth.trace.z.cols() != truth.friction.model.state_size())
    throw UserError("{}: attribute friction does not fit table z or its own parameters",
                    path.string());
  return truth;
}

}  // namespace fricid::sim
