#include "fricid/data/model_file.hpp"

#include <charconv>
#include <cmath>
#include <limits>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/json.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/names.hpp"
#include "fricid/data/friction_keys.hpp"
#include "fricid/dynamics/physical_inertia.hpp"

namespace fricid::data {
namespace {

using Json = nlohmann::ordered_json;
using dynamics::Frame;
using dynamics::Joint;
using dynamics::JointType;
using dynamics::LinearTorque;
using dynamics::RobotModel;
using friction::Friction;
using friction::ParameterInfo;

constexpr char kFormatName[] = "fricid.model";
constexpr int kFormatVersion = 1;
constexpr const char* kInertiaKeys[] = {"Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"};
constexpr const char* kShapes[] = {"1", "sin(k q)", "cos(k q)",
                                   "q"};  // order of LinearTorque::Shape

// ---- writing

Json vector_json(const double* values, int size) {
  Json array = Json::array();
  for (int i = 0; i < size; ++i) array.push_back(values[i]);
  return array;
}

Json matrix_json(const Eigen::Matrix3d& R) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back({R(i, 0), R(i, 1), R(i, 2)});
  return rows;
}

Json link_json(const RobotModel& robot, int i) {
  const double* pi = robot.pi.data() + 10 * i;
  Json inertia = Json::object();
  for (int k = 0; k < 6; ++k) inertia[kInertiaKeys[k]] = pi[4 + k];
  return {{"mass", pi[0]}, {"first_moment", vector_json(pi + 1, 3)}, {"inertia", inertia}};
}

Json joint_json(const RobotModel& robot, int i) {
  const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
  return {{"name", joint.name},
          {"link", joint.link},
          {"type", joint.type == JointType::kRevolute ? "revolute" : "prismatic"},
          {"continuous", joint.continuous},
          {"parent", joint.parent},
          {"R0", matrix_json(joint.R0)},
          {"p0", vector_json(joint.p0.data(), 3)},
          {"axis", vector_json(joint.axis.data(), 3)},
          {"lower", joint.lower},
          {"upper", joint.upper},
          {"velocity", joint.velocity},
          {"effort", joint.effort},
          {"acceleration", joint.acceleration},
          {"jerk", joint.jerk},
          {"armature", robot.pi[robot.armature_begin() + i]},
          {"moves", link_json(robot, i)}};
}

Json robot_json(const RobotModel& robot) {
  Json joints = Json::array(), frames = Json::array(), torques = Json::array();
  for (int i = 0; i < robot.n(); ++i) joints.push_back(joint_json(robot, i));
  for (const Frame& frame : robot.frames)
    frames.push_back({{"name", frame.name},
                      {"link", frame.link},
                      {"R", matrix_json(frame.R)},
                      {"p", vector_json(frame.p.data(), 3)}});
  for (std::size_t i = 0; i < robot.linear_torques.size(); ++i) {
    const LinearTorque& torque = robot.linear_torques[i];
    torques.push_back({{"name", torque.name},
                       {"joint", torque.joint},
                       {"shape", kShapes[static_cast<int>(torque.shape)]},
                       {"k", torque.k},
                       {"c", robot.pi[robot.linear_begin() + static_cast<int>(i)]}});
  }
  Json json = {{"name", robot.name},
               {"gravity", vector_json(robot.gravity.data(), 3)},
               {"joints", joints},
               {"frames", frames},
               {"linear_torques", torques}};
  for (const dynamics::Coupling& coupling : robot.couplings)
    json["couplings"].push_back(
        {{"joint", coupling.joint}, {"motor", coupling.motor}, {"factor", coupling.factor}});
  return json;
}

Json parameters_json(const std::vector<ParameterInfo>& infos, const double* theta) {
  Json parameters = Json::object();
  for (std::size_t p = 0; p < infos.size(); ++p)
    parameters[std::string(infos[p].symbol)] = {{"value", theta[p]},
                                                {"unit", std::string(infos[p].unit)}};
  return parameters;
}

// One list of laws per joint; a robot without friction has empty ones.
Json friction_json(const Friction& friction, int n) {
  Json joints = Json::array();
  if (friction.model.joint_count() == 0)
    for (int j = 0; j < n; ++j) joints.push_back(Json::array());
  const double* theta = friction.theta.data();
  for (const friction::JointSpec& joint : friction.model.joints()) {
    Json laws = Json::array();
    for (const friction::LawSpec& law : joint.laws) {
      const auto infos = friction::parameters_of_law(law.law, law.elements);
      Json item = {{"law", law.law},
                   {"elements", law.elements},
                   {"parameters", parameters_json(infos, theta)},
                   {"modifiers", Json::array()}};
      theta += infos.size();
      for (const friction::ModifierSpec& modifier : law.modifiers) {
        const auto own = friction::parameters_of_modifier(modifier.name, modifier.order);
        item["modifiers"].push_back({{"modifier", modifier.name},
                                     {"order", modifier.order},
                                     {"parameters", parameters_json(own, theta)}});
        theta += own.size();
      }
      laws.push_back(item);
    }
    joints.push_back(laws);
  }
  return joints;
}

// The law of the whole robot.
Json whole_json(const Friction& friction) {
  const friction::RobotLawSpec& whole = friction.model.whole();
  const int n = friction.model.joint_count();
  const friction::RobotLawSize size{n, whole.elements, whole.latents};
  Json json = {
      {"law", whole.law},
      {"elements", whole.elements},
      {"parameters", parameters_json(friction::parameters_of_robot_law(whole.law, size),
                                     friction.theta.data() + friction.model.parameter_begin(n))}};
  if (friction::find_robot_law(whole.law).most_latents > 0) json["n_z"] = whole.latents;
  return json;
}

Json noise_json(const LatentNoise& noise) {
  const auto list = [](const Eigen::VectorXd& x) {
    return vector_json(x.data(), static_cast<int>(x.size()));
  };
  return {{"sample_s", noise.dt},
          {"variance_q", list(noise.q)},
          {"variance_v", list(noise.v)},
          {"variance_z", list(noise.z)},
          {"variance_observation", list(noise.R)}};
}

// JSON has no infinity and no NaN.
void refuse_non_finite(const Json& node, const std::string& where, const std::string& path) {
  if (node.is_number_float() && !std::isfinite(node.get<double>()))
    throw UserError("{}: {} = {}; allowed: finite", where, path, node.get<double>());
  if (!node.is_structured()) return;
  for (const auto& [key, value] : node.items())
    refuse_non_finite(value, where, path.empty() ? key : path + "." + key);
}

// ---- reading

// A node with its path, for messages.
class Node {
 public:
  Node(const Json& json, const std::string& file, std::string path)
      : json_(json), file_(file), path_(std::move(path)) {}

  Node operator[](const std::string& key) const {
    const std::string path = path_.empty() ? key : path_ + "." + key;
    if (!json_.is_object()) refuse("an object");
    const auto found = json_.find(key);
    if (found == json_.end()) throw UserError("{}: {} is missing", file_, path);
    return {*found, file_, path};
  }
  Node at(std::size_t i) const { return {json_[i], file_, fmt::format("{}[{}]", path_, i)}; }
  std::size_t size() const {
    if (!json_.is_array()) refuse("an array");
    return json_.size();
  }
  bool has(const std::string& key) const { return json_.contains(key); }
  std::size_t key_count() const { return json_.size(); }
  double number() const {
    if (!json_.is_number()) refuse("a number");
    return json_.get<double>();
  }
  double number(double lower, double upper) const {
    const double value = number();
    if (!(value >= lower && value <= upper)) refuse(fmt::format("{:g} to {:g}", lower, upper));
    return value;
  }
  int integer(int lower, int upper) const {
    if (!json_.is_number_integer()) refuse("a whole number");
    return static_cast<int>(number(lower, upper));
  }
  bool flag() const {
    if (!json_.is_boolean()) refuse("true or false");
    return json_.get<bool>();
  }
  std::string text() const {
    if (!json_.is_string()) refuse("a text");
    return json_.get<std::string>();
  }
  std::string name(Named kind) const {
    const std::string name = text();
    require_written_name(kind, name, fmt::format("{}: {}", file_, path_));
    return name;
  }
  std::string label() const {
    const std::string label = text();
    require_label(label, path_, file_);
    return label;
  }
  Eigen::Vector3d vector() const {
    if (size() != 3) refuse("3 numbers");
    return {at(0).number(), at(1).number(), at(2).number()};
  }
  Eigen::Matrix3d rotation() const {
    if (size() != 3) refuse("3 rows");
    Eigen::Matrix3d R;
    for (int i = 0; i < 3; ++i) R.row(i) = at(static_cast<std::size_t>(i)).vector();
    // Written by hand or rounded files are refused: a rotation carries full precision.
    if ((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-9)
      refuse("a rotation");
    return R;
  }
  void require_within(const Limit& limit, std::uint64_t found) const {
    fricid::require_within(limit, found, fmt::format("{}: {}", file_, path_));
  }
  /// What `make` gives; its UserError is told as one of this node.
  template <class Make>
  auto checked(Make make) const {
    try {
      return make();
    } catch (const UserError& error) {
      throw UserError("{}: {}: {}", file_, path_, error.what());
    }
  }
  [[noreturn]] void refuse(const std::string& allowed) const {
    throw UserError("{}: {}{}; allowed: {}", file_, path_.empty() ? "found " : path_ + " = ",
                    shown(json_), allowed);
  }

 private:
  const Json& json_;
  const std::string& file_;
  std::string path_;
};

constexpr int kMost = 1'000'000'000;
constexpr double kRounding = 1e-3;  // what a URDF may miss of a physical inertia, per unit of mass

RobotModel read_robot(const Node& node) {
  RobotModel robot;
  robot.name = node["name"].name(Named::kRobot);
  robot.gravity = node["gravity"].vector();
  const Node joints = node["joints"], frames = node["frames"], torques = node["linear_torques"];
  const int n = static_cast<int>(joints.size());
  if (n < 1) joints.refuse("at least one joint");
  joints.require_within(limits::kJoints, joints.size());
  robot.pi.setZero(11 * n + static_cast<int>(torques.size()));
  for (int i = 0; i < n; ++i) {
    const Node item = joints.at(static_cast<std::size_t>(i));
    Joint joint;
    joint.name = item["name"].name(Named::kJoint);
    joint.link = item["link"].name(Named::kLink);
    const std::string type = item["type"].text();
    if (type != "revolute" && type != "prismatic") item["type"].refuse("revolute or prismatic");
    joint.type = type == "revolute" ? JointType::kRevolute : JointType::kPrismatic;
    joint.continuous = item["continuous"].flag();
    joint.parent = item["parent"].integer(-1, i - 1);
    joint.R0 = item["R0"].rotation();
    joint.p0 = item["p0"].vector();
    joint.axis = item["axis"].vector();
    if (std::abs(joint.axis.norm() - 1) > 1e-9) item["axis"].refuse("a unit vector");
    joint.lower = item["lower"].number();
    joint.upper = item["upper"].number();
    joint.velocity = item["velocity"].number();
    joint.effort = item["effort"].number();
    joint.acceleration = item["acceleration"].number();
    joint.jerk = item["jerk"].number();
    for (const char* key : {"velocity", "effort", "acceleration", "jerk", "armature"})
      if (item[key].number() < 0) item[key].refuse("0 or more");
    robot.pi[robot.pi.size() - static_cast<int>(torques.size()) - n + i] =
        item["armature"].number();
    const Node link = item["moves"];
    robot.pi[10 * i] = link["mass"].number();
    robot.pi.segment<3>(10 * i + 1) = link["first_moment"].vector();
    for (int k = 0; k < 6; ++k)
      robot.pi[10 * i + 4 + k] = link["inertia"][kInertiaKeys[k]].number();
    if (!(robot.pi[10 * i] > 0)) link["mass"].refuse("above 0");
    if (!dynamics::is_physical(robot.pi.segment<10>(10 * i), -kRounding))
      link["inertia"].refuse("that of a body of this mass and first moment");
    robot.joints.push_back(joint);
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Node item = frames.at(i);
    robot.frames.push_back({.name = item["name"].name(Named::kLink),
                            .link = item["link"].integer(-1, n - 1),
                            .R = item["R"].rotation(),
                            .p = item["p"].vector()});
  }
  for (std::size_t i = 0; i < torques.size(); ++i) {
    const Node item = torques.at(i);
    const std::string shape = item["shape"].text();
    const auto known = std::find(std::begin(kShapes), std::end(kShapes), shape);
    if (known == std::end(kShapes)) item["shape"].refuse("1, sin(k q), cos(k q) or q");
    robot.linear_torques.push_back(
        {.name = item["name"].label(),
         .joint = item["joint"].integer(0, n - 1),
         .shape = static_cast<LinearTorque::Shape>(known - std::begin(kShapes)),
         .k = item["k"].number()});
    robot.pi[11 * n + static_cast<int>(i)] = item["c"].number();
  }
  if (!node.has("couplings")) return robot;
  const Node couplings = node["couplings"];
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const Node item = couplings.at(i);
    const dynamics::Coupling coupling{.joint = item["joint"].integer(0, n - 1),
                                      .motor = item["motor"].integer(0, n - 1),
                                      .factor = item["factor"].number()};
    if (coupling.joint == coupling.motor) item["motor"].refuse("another joint");
    robot.couplings.push_back(coupling);
  }
  if (!dynamics::is_transmission(robot)) couplings.refuse("motors that turn every joint");
  return robot;
}

void read_parameters(const Node& node, const std::vector<ParameterInfo>& infos,
                     std::vector<double>& theta) {
  for (const ParameterInfo& info : infos) {
    const Node parameter = node[std::string(info.symbol)];
    if (parameter["unit"].text() != info.unit) parameter["unit"].refuse(std::string(info.unit));
    theta.push_back(parameter["value"].number(info.lower, info.upper));
  }
  if (node.key_count() != infos.size())
    node.refuse(fmt::format("the {} parameters of the law", infos.size()));
}

const friction::LawInfo& row_of(const Node& name, std::span<const friction::LawInfo> rows) {
  const friction::LawInfo* row = find_row(rows, name.text());
  if (!row) name.refuse(list_names(rows));
  return *row;
}

int read_count(const Node& count, const friction::LawInfo& row, int none) {
  return row.has_elements ? count.integer(1, row.most_elements) : count.integer(none, none);
}

Friction read_friction(const Node& root, int n) {
  const Node node = root["friction"];
  if (node.size() != static_cast<std::size_t>(n))
    node.refuse(fmt::format("one list of laws for each of {} joints", n));
  std::vector<friction::JointSpec> joints(static_cast<std::size_t>(n));
  std::vector<double> theta;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Node laws = node.at(j);
    for (std::size_t i = 0; i < laws.size(); ++i) {
      const Node item = laws.at(i);
      const friction::LawInfo& row = row_of(item["law"], friction::law_table());
      friction::LawSpec law{.law = std::string(row.name),
                            .elements = read_count(item["elements"], row, 0),
                            .modifiers = {}};
      read_parameters(item["parameters"], friction::parameters_of_law(law.law, law.elements),
                      theta);
      const Node modifiers = item["modifiers"];
      for (std::size_t m = 0; m < modifiers.size(); ++m) {
        const Node own = modifiers.at(m);
        const friction::LawInfo& kind = row_of(own["modifier"], friction::modifier_table());
        friction::ModifierSpec modifier{.name = std::string(kind.name),
                                        .order = read_count(own["order"], kind, 1)};
        read_parameters(own["parameters"],
                        friction::parameters_of_modifier(modifier.name, modifier.order), theta);
        law.modifiers.push_back(modifier);
      }
      joints[j].laws.push_back(law);
    }
  }
  friction::RobotLawSpec whole;
  if (root.has("friction_of_robot")) {
    const Node item = root["friction_of_robot"];
    const friction::LawInfo& row = row_of(item["law"], friction::robot_law_table());
    whole = {.law = std::string(row.name), .elements = read_count(item["elements"], row, 0)};
    if (row.most_latents > 0) whole.latents = item["n_z"].integer(1, row.most_latents);
    const friction::RobotLawSize size{n, whole.elements, whole.latents};
    read_parameters(
        item["parameters"],
        item.checked([&] { return friction::parameters_of_robot_law(whole.law, size); }), theta);
  }
  return {.model = node.checked(
              [&] { return friction::RobotFriction(std::move(joints), std::move(whole)); }),
          .theta = std::move(theta)};
}

LatentNoise read_noise(const Node& node, int n, int nz) {
  const auto variances = [&](const char* key, std::initializer_list<int> sizes) {
    const Node list = node[key];
    const int size = static_cast<int>(list.size());
    if (std::find(sizes.begin(), sizes.end(), size) == sizes.end())
      list.refuse(fmt::format("{} numbers", fmt::join(sizes, " or ")));
    Eigen::VectorXd values(size);
    for (int i = 0; i < size; ++i)
      values[i] =
          list.at(static_cast<std::size_t>(i))
              .number(std::numeric_limits<double>::min(), std::numeric_limits<double>::max());
    return values;
  };
  return {.dt = node["sample_s"].number(1e-9, 1e9),
          .q = variances("variance_q", {n}),
          .v = variances("variance_v", {n}),
          .z = variances("variance_z", {nz}),
          .R = variances("variance_observation", {n, 2 * n})};
}

void check_format(const Node& root, const std::string& file) {
  const std::string format = root["format"].text();
  const std::string allowed = fmt::format("{}/{}", kFormatName, kFormatVersion);
  if (format == allowed) return;
  const std::size_t slash = format.rfind('/');
  int version = 0;
  if (slash != std::string::npos)
    std::from_chars(format.data() + slash + 1, format.data() + format.size(), version);
  if (format.substr(0, slash) == kFormatName && version > kFormatVersion)
    throw UserError("{}: format {} is newer than {}, which this program reads", file, format,
                    allowed);
  throw UserError("{}: format = \"{}\"; allowed: {}", file, format, allowed);
}

}  // namespace

void save_model(const ModelFile& model, const std::filesystem::path& path) {
  Json json = {{"format", fmt::format("{}/{}", kFormatName, kFormatVersion)},
               {"name", model.name},
               {"label", model.label},
               {"seed", model.seed},
               {"is_oracle", model.is_oracle},
               {"free_parameters", model.free_parameters},
               {"budget", model.budget},
               {"robot", robot_json(model.arm.robot)},
               {"friction", friction_json(model.arm.friction, model.arm.robot.n())}};
  if (model.arm.friction.model.has_whole())
    json["friction_of_robot"] = whole_json(model.arm.friction);
  if (model.noise) json["noise"] = noise_json(*model.noise);
  refuse_non_finite(json, path.string(), "");
  write_file_atomically(path, json.dump(1) + "\n");
}

ModelFile load_model(const std::filesystem::path& path) {
  const std::string file = path.string();
  const std::string text = read_file(path);
  if (text.empty()) throw UserError("{}: an empty file", file);
  const Json json = parse_json<Json>(text, file);
  const Node root(json, file, "");
  check_format(root, file);
  ModelFile model;
  model.name = root["name"].name(Named::kModel);
  model.label = root["label"].label();
  model.seed = root["seed"].integer(0, kMost);
  model.is_oracle = root["is_oracle"].flag();
  if (!model.is_oracle) require_name(Named::kModel, model.name, file);
  model.free_parameters = root["free_parameters"].integer(0, kMost);
  if (root.has("budget")) model.budget = root["budget"].label();
  model.arm.robot = read_robot(root["robot"]);
  model.arm.friction = read_friction(root, model.arm.robot.n());
  if (root.has("noise"))
    model.noise =
        read_noise(root["noise"], model.arm.robot.n(), model.arm.friction.model.state_size());
  return model;
}

}  // namespace fricid::data
