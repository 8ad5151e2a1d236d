#include "fricid/data/experiment.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/data/contract.hpp"
#include "friction_by_effort.hpp"
#include "friction_toml.hpp"
#include "toml_file.hpp"
#include "toml_reader.hpp"
#include "toml_writer.hpp"

namespace fricid::data {
namespace {

namespace fs = std::filesystem;
using dynamics::LinearTorque;

// Where the keys of a scene stand.
class Places {
 public:
  explicit Places(const TomlFile& file) : file_(file) {}

  const toml::node* find(std::string_view key) const { return file_.table.at_path(key).node(); }
  std::string of(std::string_view key) const { return place_of_key(file_, key); }
  fs::path folder(std::string_view key) const {
    const fs::path outer = fs::path(file_.path).parent_path();
    const toml::node* node = find(key);
    return node ? folder_of(*node, outer) : outer;
  }

 private:
  const TomlFile& file_;
};

// Finds a file named by a key; the name becomes one that any copy of the scene can use: relative to
// the share folder where the file lies in it, else absolute.
fs::path resolve(std::string& name, const Places& places, std::string_view key) {
  if (name.empty()) return {};
  fs::path path;
  try {
    path = find_file(name, places.folder(key));
  } catch (const UserError& error) {
    throw UserError("{}: {}: {}", places.of(key), key, error.what());
  }
  if (name[0] == '$') return path;
  const fs::path in_share =
      fs::weakly_canonical(path).lexically_relative(fs::weakly_canonical(share_dir()));
  const bool inside = !in_share.empty() && *in_share.begin() != "..";
  name = inside ? in_share.string() : path.string();
  return path;
}

// 1, q, sin(q), cos(2 q), sin(3*q)
std::optional<LinearTorque> parse_term(std::string term) {
  std::erase_if(term, [](char c) { return c == ' ' || c == '*'; });
  LinearTorque torque;
  if (term == "1") return torque;
  if (term == "q") {
    torque.shape = LinearTorque::Shape::kLinear;
    return torque;
  }
  const bool sine = term.starts_with("sin("), cosine = term.starts_with("cos(");
  if ((!sine && !cosine) || !term.ends_with("q)")) return std::nullopt;
  torque.shape = sine ? LinearTorque::Shape::kSin : LinearTorque::Shape::kCos;
  const std::string_view factor = std::string_view(term).substr(4, term.size() - 6);
  if (factor.empty()) return torque;
  int k = 0;
  const auto [end, error] = std::from_chars(factor.data(), factor.data() + factor.size(), k);
  if (error != std::errc() || end != factor.data() + factor.size() || k < 1) return std::nullopt;
  torque.k = k;
  return torque;
}

std::vector<std::string> joint_names(const dynamics::RobotModel& model) {
  std::vector<std::string> names;
  for (const dynamics::Joint& joint : model.joints) names.push_back(joint.name);
  return names;
}

void add_torques(Experiment& experiment, const Places& places) {
  const std::vector<std::string> joints = joint_names(experiment.model);
  for (std::size_t i = 0; i < experiment.robot.torques.size(); ++i) {
    const TorqueConfig& config = experiment.robot.torques[i];
    const std::string key = fmt::format("robot.torque[{}]", i);
    const std::string shown = fmt::format("robot.torque[{}]", i + 1);
    const auto joint = std::find(joints.begin(), joints.end(), config.joint);
    if (joint == joints.end())
      throw UserError("{}: {}.joint = \"{}\"; allowed: {}", places.of(key + ".joint"), shown,
                      config.joint, fmt::join(joints, ", "));
    if (!config.prior_sd.empty() && config.prior_sd.size() != config.terms.size())
      throw UserError("{}: {}.prior_sd = an array of {}; allowed: [] or {} numbers, one per term",
                      places.of(key + ".prior_sd"), shown, config.prior_sd.size(),
                      config.terms.size());
    for (std::size_t k = 0; k < config.terms.size(); ++k) {
      std::optional<LinearTorque> torque = parse_term(config.terms[k]);
      if (!torque)
        throw UserError("{}: {}.terms[{}] = \"{}\"; allowed: 1, q, sin(q), cos(q), sin(2 q), ...",
                        places.of(key + ".terms"), shown, k + 1, config.terms[k]);
      torque->joint = static_cast<int>(joint - joints.begin());
      torque->name = fmt::format("{} {}", config.joint, config.terms[k]);
      dynamics::add_linear_torque(experiment.model, *torque);
      experiment.torque_prior_sd.push_back(
          config.prior_sd.empty() ? std::numeric_limits<double>::infinity() : config.prior_sd[k]);
    }
  }
}

void add_payload(Experiment& experiment, const Places& places) {
  const RobotConfig& robot = experiment.robot;
  if (robot.payload_kg == 0) return;
  const auto& frames = experiment.model.frames;
  const auto frame = std::find_if(frames.begin(), frames.end(), [&](const dynamics::Frame& f) {
    return f.name == robot.payload_frame;
  });
  if (frame == frames.end()) {
    std::vector<std::string> names;
    for (const dynamics::Frame& f : frames) names.push_back(f.name);
    throw UserError("{}: robot.payload_frame = \"{}\"; allowed: {}",
                    places.of("robot.payload_frame"), robot.payload_frame, fmt::join(names, ", "));
  }
  const auto& [xx, yy, zz, xy, xz, yz] = robot.payload_inertia;
  const Eigen::Matrix3d inertia{{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
  // The sum with the link must stay a body: about its own centre Ixx + Iyy >= Izz, and so on.
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  if (moments[0] < 0 || moments[0] + moments[1] < moments[2])
    throw UserError(
        "{}: robot.payload_inertia has principal moments {:g}, {:g}, {:g} kg m^2; allowed: none "
        "negative, the largest at most the sum of the others",
        places.of("robot.payload_inertia"), moments[0], moments[1], moments[2]);
  dynamics::add_payload(experiment.model, *frame, robot.payload_kg,
                        Eigen::Map<const Eigen::Vector3d>(robot.payload_com.data()), inertia);
}

void load_robot(Experiment& experiment, const Places& places) {
  RobotConfig& robot = experiment.robot;
  experiment.urdf_path = resolve(robot.urdf, places, "robot.urdf");
  experiment.mjcf_path = resolve(robot.mjcf, places, "robot.mjcf");
  experiment.model = dynamics::load_urdf(experiment.urdf_path, mount_rotation(robot));
  add_payload(experiment, places);
  add_torques(experiment, places);
}

void check_models(Experiment& experiment, const Places& places) {
  std::vector<std::string_view> laws, modifiers;
  for (const friction::LawInfo& row : friction::law_table()) laws.push_back(row.name);
  for (const friction::LawInfo& row : friction::robot_law_table()) laws.push_back(row.name);
  for (const friction::LawInfo& row : friction::modifier_table()) modifiers.push_back(row.name);
  for (std::size_t i = 0; i < experiment.models.size(); ++i) {
    ModelConfig& model = experiment.models[i];
    const std::string key = fmt::format("model[{}]", i), shown = fmt::format("model[{}]", i + 1);
    require_name(Named::kModel, model.name, places.of(key + ".name"));
    require_label(model.label, shown + ".label", places.of(key + ".label"));
    for (std::size_t other = 0; other < i; ++other)
      if (experiment.models[other].name == model.name)
        throw UserError("{}: {}.name = \"{}\" is used twice", places.of(key + ".name"), shown,
                        model.name);
    const std::string said = model.law.empty() ? "name" : "law";
    if (model.law.empty()) model.law = model.name == "simple" ? "coulomb_viscous" : model.name;
    if (std::find(laws.begin(), laws.end(), model.law) == laws.end())
      throw UserError("{}: {}.{} = \"{}\"; allowed: {}", places.of(key + "." + said), shown, said,
                      model.law, fmt::join(laws, ", "));
    if (!model.modifiers.empty() && friction::is_robot_law(model.law))
      throw UserError("{}: {}.modifiers = \"{}\"; allowed for {}, a law of the whole robot: none",
                      places.of(key + ".modifiers"), shown, model.modifiers[0], model.law);
    for (const std::string& modifier : model.modifiers) {
      if (std::find(modifiers.begin(), modifiers.end(), modifier) == modifiers.end())
        throw UserError("{}: {}.modifiers = \"{}\"; allowed: {}", places.of(key + ".modifiers"),
                        shown, modifier, fmt::join(modifiers, ", "));
      if (std::ranges::count(model.modifiers, modifier) > 1)
        throw UserError("{}: {}.modifiers names \"{}\" twice", places.of(key + ".modifiers"), shown,
                        modifier);
    }
    if (model.label.empty()) model.label = model.name;
    if (model.method.empty())
      model.method = friction::is_learned(model.law) ? "multi_step" : "conventional";
    if (model.method == "conventional" && friction::is_learned(model.law))
      throw UserError("{}: {}.method = \"conventional\"; allowed for {}: torque, multi_step, em",
                      places.of(key + ".method"), shown, model.law);
    std::sort(model.seeds.begin(), model.seeds.end());
    model.seeds.erase(std::unique(model.seeds.begin(), model.seeds.end()), model.seeds.end());
  }
}

void check_consistency(const Experiment& experiment, const Places& places,
                       const std::string& path) {
  if (!experiment.simulates() && experiment.data.train.empty())
    throw UserError("{}: neither friction to inject nor logs; allowed: [friction] or data.train",
                    path);
  if (experiment.simulates() && !experiment.data.train.empty())
    throw UserError("{}: data.train beside [friction]; allowed: one of them",
                    places.of("data.train"));
  if (!experiment.simulates()) {
    if (experiment.data.contract.empty())
      throw UserError("{}: data.contract is missing: column contract of the logs",
                      places.of("data"));
    return;
  }
  const double steps = 1 / (experiment.sensors.rate_hz * experiment.plant.step_s);
  if (steps < 0.5 || std::abs(steps - std::round(steps)) > 1e-6 * steps)
    throw UserError("{}: plant.step_s = {} s; allowed: the sample period {} s over a whole number",
                    places.of("plant.step_s"), experiment.plant.step_s,
                    1 / experiment.sensors.rate_hz);
}

void check_contract(const Experiment& experiment, const Places& places) {
  if (experiment.contract_path.empty()) return;
  const Contract contract = load_contract(experiment.contract_path);
  const std::vector<std::string> joints = joint_names(experiment.model);
  if (contract.joint_names != joints)
    throw UserError("{}: data.contract has the joints {}; allowed: those of the robot, {}",
                    places.of("data.contract"), fmt::join(contract.joint_names, ", "),
                    fmt::join(joints, ", "));
}

std::vector<fs::path> named_inputs(const TomlFile& file, const Experiment& experiment) {
  std::vector<fs::path> inputs = file.files;
  for (const fs::path& path :
       {experiment.urdf_path, experiment.mjcf_path, experiment.contract_path})
    if (!path.empty()) inputs.push_back(path);
  for (const auto* logs : {&experiment.data.train, &experiment.data.validation}) {
    for (const std::string& log : *logs) {
      try {
        inputs.push_back(find_file(log, experiment.folder));
      } catch (const UserError&) {
        continue;  // absent logs are reported by data_available
      }
    }
  }
  return inputs;
}

// Relative logs that exist become absolute, so that the scene can be run from another folder.
void resolve_logs(std::vector<std::string>& logs, const fs::path& folder) {
  for (std::string& log : logs) {
    if (log.empty() || log[0] == '$') continue;
    const fs::path path = fs::absolute(folder / log).lexically_normal();
    if (fs::path(log).is_relative() && fs::exists(path)) log = path.string();
  }
}

}  // namespace

Eigen::Matrix3d mount_rotation(const RobotConfig& robot) {
  if (robot.mount == "ceiling") return Eigen::Vector3d(1, -1, -1).asDiagonal();
  if (robot.mount == "wall") return Eigen::Matrix3d{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}};
  if (robot.mount == "rpy") {
    using Eigen::AngleAxisd, Eigen::Vector3d;
    const auto& [roll, pitch, yaw] = robot.mount_rpy;
    return (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
            AngleAxisd(roll, Vector3d::UnitX()))
        .toRotationMatrix();
  }
  return Eigen::Matrix3d::Identity();
}

Experiment load_experiment(const std::filesystem::path& path) {
  const TomlFile file = load_toml(path);
  const Places places(file);
  Experiment experiment;
  experiment.folder = fs::absolute(path).parent_path().lexically_normal();

  // The robot first: its joints are how many values the other sections need.
  if (!places.find("robot"))
    throw UserError("{}: robot.urdf is missing: the engine's robot", file.path);
  TomlReader(file.table, "", file.path, {}).section("robot", experiment.robot, "");
  load_robot(experiment, places);
  const RobotConfig robot = experiment.robot;
  const std::vector<std::string> joints = joint_names(experiment.model);
  TomlReader reader(file.table, "", file.path, joints);
  experiment.visit(reader);
  reader.refuse_unknown();
  experiment.robot = robot;
  if (experiment.friction && experiment.friction->model.joints().empty())
    experiment.friction = friction_by_effort(experiment.model, places.of("friction"));

  if (experiment.name.empty()) experiment.name = path.stem().string();
  require_name(Named::kScene, experiment.name, places.of("name"));
  require_label(experiment.description, "description", places.of("description"));
  for (auto* values : {&experiment.sensors.encoder_noise_rad, &experiment.sensors.encoder_step_rad})
    if (values->empty()) values->assign(joints.size(), 0.0);
  experiment.contract_path = resolve(experiment.data.contract, places, "data.contract");
  resolve_logs(experiment.data.train, places.folder("data.train"));
  resolve_logs(experiment.data.validation, places.folder("data.validation"));
  check_contract(experiment, places);
  check_models(experiment, places);
  check_consistency(experiment, places, file.path);
  experiment.inputs = named_inputs(file, experiment);
  return experiment;
}

bool data_available(const Experiment& experiment, std::string* why) {
  for (const auto* logs : {&experiment.data.train, &experiment.data.validation}) {
    for (const std::string& log : *logs) {
      try {
        find_file(log, experiment.folder);
      } catch (const UserError& error) {
        if (why) *why = error.what();
        return false;
      }
    }
  }
  return true;
}

std::string to_toml(const Experiment& experiment) {
  TomlWriter writer(false, joint_names(experiment.model));
  Experiment copy = experiment;
  copy.visit(writer);
  return writer.text();
}

std::string scene_template() {
  Experiment example;
  example.name = "example";
  example.robot.urdf = "models/kr6_r700/kr6_r700.urdf";
  example.robot.mjcf = "models/kr6_r700/kr6_r700.xml";
  example.models.emplace_back();
  example.models[0].name = "lugre";
  example.models[0].label = "LuGre";
  example.models[0].method = "conventional";
  TomlWriter writer(true, {});
  example.visit(writer);
  return "# A scene of fricid. Every key is optional unless it says required; the values are the\n"
         "# defaults. A scene may start from another: extends = \"other.toml\" (its tables merge,\n"
         "# its values and arrays are replaced), or from several, the last of which wins:\n"
         "# extends = [\"robot.toml\", \"models.toml\"]. Unknown keys are errors.\n\n" +
         writer.text();
}

}  // namespace fricid::data
