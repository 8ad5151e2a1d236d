#include "fricid/data/problem.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/data/paths.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "friction_by_effort.hpp"
#include "joint_names.hpp"

namespace fricid::data {
namespace {

namespace fs = std::filesystem;
using dynamics::LinearTorque;

// Finds the file named by a key; the name becomes one that any copy of the scene can use: relative
// to the share folder where the file lies in it, else absolute.
fs::path find_and_rename(const SceneOrigin& origin, std::string& name, std::string_view key) {
  if (name.empty()) return {};
  const fs::path path = origin.find(name, key);
  if (name[0] == '$') return path;
  const fs::path in_share =
      fs::weakly_canonical(path).lexically_relative(fs::weakly_canonical(share_dir()));
  const bool inside = !in_share.empty() && *in_share.begin() != "..";
  name = inside ? in_share.string() : path.string();
  return path;
}

// Relative logs that exist become absolute, so that the scene can be run from another folder.
void rename_logs(std::vector<std::string>& logs, const fs::path& folder) {
  for (std::string& log : logs) {
    if (log.empty() || log[0] == '$') continue;
    const std::string file = log_part(log).file;
    const fs::path path = fs::absolute(folder / file).lexically_normal();
    if (fs::path(file).is_relative() && fs::exists(path))
      log = path.string() + log.substr(file.size());
  }
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

// @return standard deviation of each coefficient [N m]
std::vector<double> add_torques(const Scene& scene, dynamics::RobotModel& robot) {
  std::vector<double> prior_sd;
  const std::vector<std::string>& joints = scene.joints;
  for (std::size_t i = 0; i < scene.robot.torques.size(); ++i) {
    const TorqueConfig& config = scene.robot.torques[i];
    const std::string key = fmt::format("robot.torque[{}]", i);
    const std::string shown = fmt::format("robot.torque[{}]", i + 1);
    const auto joint = std::find(joints.begin(), joints.end(), config.joint);
    if (joint == joints.end())
      throw UserError("{}: {}.joint = \"{}\"; allowed: {}", scene.origin.place(key + ".joint"),
                      shown, config.joint, fmt::join(joints, ", "));
    if (!config.prior_sd.empty() && config.prior_sd.size() != config.terms.size())
      throw UserError("{}: {}.prior_sd = an array of {}; allowed: [] or {} numbers, one per term",
                      scene.origin.place(key + ".prior_sd"), shown, config.prior_sd.size(),
                      config.terms.size());
    for (std::size_t k = 0; k < config.terms.size(); ++k) {
      std::optional<LinearTorque> torque = parse_term(config.terms[k]);
      if (!torque)
        throw UserError("{}: {}.terms[{}] = \"{}\"; allowed: 1, q, sin(q), cos(q), sin(2 q), ...",
                        scene.origin.place(key + ".terms"), shown, k + 1, config.terms[k]);
      torque->joint = static_cast<int>(joint - joints.begin());
      torque->name = fmt::format("{} {}", config.joint, config.terms[k]);
      dynamics::add_linear_torque(robot, *torque);
      prior_sd.push_back(config.prior_sd.empty() ? std::numeric_limits<double>::infinity()
                                                 : config.prior_sd[k]);
    }
  }
  return prior_sd;
}

void add_payload(const Scene& scene, dynamics::RobotModel& model) {
  const RobotConfig& robot = scene.robot;
  if (robot.payload_kg == 0) return;
  const auto& frames = model.frames;
  const auto frame = std::find_if(frames.begin(), frames.end(), [&](const dynamics::Frame& f) {
    return f.name == robot.payload_frame;
  });
  if (frame == frames.end()) {
    std::vector<std::string> names;
    for (const dynamics::Frame& f : frames) names.push_back(f.name);
    throw UserError("{}: robot.payload_frame = \"{}\"; allowed: {}",
                    scene.origin.place("robot.payload_frame"), robot.payload_frame,
                    fmt::join(names, ", "));
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
        scene.origin.place("robot.payload_inertia"), moments[0], moments[1], moments[2]);
  dynamics::add_payload(model, *frame, robot.payload_kg,
                        Eigen::Map<const Eigen::Vector3d>(robot.payload_com.data()), inertia);
}

// Checks [[model]] and fills in what its keys leave open.
void complete_models(Scene& scene) {
  std::vector<std::string_view> laws, modifiers;
  for (const friction::LawInfo& row : friction::law_table()) laws.push_back(row.name);
  for (const friction::LawInfo& row : friction::robot_law_table()) laws.push_back(row.name);
  for (const friction::LawInfo& row : friction::modifier_table()) modifiers.push_back(row.name);
  for (std::size_t i = 0; i < scene.models.size(); ++i) {
    ModelConfig& model = scene.models[i];
    const std::string key = fmt::format("model[{}]", i), shown = fmt::format("model[{}]", i + 1);
    require_name(Named::kModel, model.name, scene.origin.place(key + ".name"));
    require_label(model.label, shown + ".label", scene.origin.place(key + ".label"));
    for (std::size_t other = 0; other < i; ++other)
      if (scene.models[other].name == model.name)
        throw UserError("{}: {}.name = \"{}\" is used twice", scene.origin.place(key + ".name"),
                        shown, model.name);
    const std::string said = model.law.empty() ? "name" : "law";
    if (model.law.empty()) model.law = model.name == "simple" ? "coulomb_viscous" : model.name;
    if (std::find(laws.begin(), laws.end(), model.law) == laws.end())
      throw UserError("{}: {}.{} = \"{}\"; allowed: {}", scene.origin.place(key + "." + said),
                      shown, said, model.law, fmt::join(laws, ", "));
    if (!model.modifiers.empty() && friction::is_robot_law(model.law))
      throw UserError("{}: {}.modifiers = \"{}\"; allowed for {}, a law of the whole robot: none",
                      scene.origin.place(key + ".modifiers"), shown, model.modifiers[0], model.law);
    for (const std::string& modifier : model.modifiers) {
      if (std::find(modifiers.begin(), modifiers.end(), modifier) == modifiers.end())
        throw UserError("{}: {}.modifiers = \"{}\"; allowed: {}",
                        scene.origin.place(key + ".modifiers"), shown, modifier,
                        fmt::join(modifiers, ", "));
      if (std::ranges::count(model.modifiers, modifier) > 1)
        throw UserError("{}: {}.modifiers names \"{}\" twice",
                        scene.origin.place(key + ".modifiers"), shown, modifier);
    }
    if (model.label.empty()) model.label = model.name;
    if (model.method.empty())
      model.method = friction::is_learned(model.law) ? "multi_step" : "conventional";
    if (model.method == "conventional" && friction::is_learned(model.law))
      throw UserError("{}: {}.method = \"conventional\"; allowed for {}: torque, multi_step, em",
                      scene.origin.place(key + ".method"), shown, model.law);
    std::sort(model.seeds.begin(), model.seeds.end());
    model.seeds.erase(std::unique(model.seeds.begin(), model.seeds.end()), model.seeds.end());
  }
}

void check_consistency(const Scene& scene) {
  if (!scene.simulates() && scene.data.train.empty())
    throw UserError("{}: neither friction to inject nor logs; allowed: [friction] or data.train",
                    scene.origin.place(""));
  if (scene.simulates() && !scene.data.train.empty())
    throw UserError("{}: data.train beside [friction]; allowed: one of them",
                    scene.origin.place("data.train"));
  if (!scene.simulates()) {
    if (scene.data.contract.empty())
      throw UserError("{}: data.contract is missing: column contract of the logs",
                      scene.origin.place("data"));
    return;
  }
  const double steps = 1 / (scene.sensors.rate_hz * scene.plant.step_s);
  if (steps < 0.5 || std::abs(steps - std::round(steps)) > 1e-6 * steps)
    throw UserError("{}: plant.step_s = {} s; allowed: the sample period {} s over a whole number",
                    scene.origin.place("plant.step_s"), scene.plant.step_s,
                    1 / scene.sensors.rate_hz);
}

void check_contract(const Scene& scene, const fs::path& path) {
  if (path.empty()) return;
  const Contract contract = load_contract(path);
  if (contract.joint_names != scene.joints)
    throw UserError("{}: data.contract has the joints {}; allowed: those of the robot, {}",
                    scene.origin.place("data.contract"), fmt::join(contract.joint_names, ", "),
                    fmt::join(scene.joints, ", "));
}

fs::path folder_of_scene(const Scene& scene) {
  return fs::absolute(scene.origin.path).parent_path().lexically_normal();
}

// Calls with each log of a scene.
template <class Use>
void for_logs(const Scene& scene, Use&& use) {
  for (const auto* logs : {&scene.data.train, &scene.data.validation})
    for (const std::string& log : *logs) use(log);
}

}  // namespace

Problem resolve(Scene scene) {
  const SceneOrigin& origin = scene.origin;
  const fs::path urdf = find_and_rename(origin, scene.robot.urdf, "robot.urdf");
  const fs::path mjcf = find_and_rename(origin, scene.robot.mjcf, "robot.mjcf");
  dynamics::RobotModel robot = dynamics::load_urdf(urdf, mount_rotation(scene.robot));
  scene.joints = joint_names(robot);
  add_payload(scene, robot);
  dynamics::require_inertia(robot, urdf.string());
  std::vector<double> torque_prior_sd = add_torques(scene, robot);
  if (scene.friction && scene.friction->model.joints().empty())
    scene.friction = friction_by_effort(robot, origin.place("friction"));

  require_name(Named::kScene, scene.name, origin.place("name"));
  require_label(scene.description, "description", origin.place("description"));
  for (auto* values : {&scene.sensors.encoder_noise_rad, &scene.sensors.encoder_step_rad})
    if (values->empty()) values->assign(scene.joints.size(), 0.0);
  const fs::path contract = find_and_rename(origin, scene.data.contract, "data.contract");
  rename_logs(scene.data.train, origin.folder("data.train"));
  rename_logs(scene.data.validation, origin.folder("data.validation"));
  check_contract(scene, contract);
  complete_models(scene);
  check_consistency(scene);

  std::vector<fs::path> inputs = origin.files;
  for (const fs::path& path : {urdf, mjcf, contract})
    if (!path.empty()) inputs.push_back(path);
  for_logs(scene, [&](const std::string& log) {
    try {
      inputs.push_back(find_file(log_part(log).file, folder_of_scene(scene)));
    } catch (const UserError&) {
      return;  // absent logs are reported by data_available
    }
  });
  return {.scene = std::move(scene),
          .robot = std::move(robot),
          .torque_prior_sd = std::move(torque_prior_sd),
          .urdf_path = urdf,
          .mjcf_path = mjcf,
          .contract_path = contract,
          .inputs = std::move(inputs)};
}

fs::path find_log(const Problem& problem, const std::string& name) {
  return find_file(log_part(name).file, folder_of_scene(problem.scene));
}

bool data_available(const Problem& problem, std::string* why) {
  try {
    for_logs(problem.scene, [&](const std::string& log) { find_log(problem, log); });
  } catch (const UserError& error) {
    if (why) *why = error.what();
    return false;
  }
  return true;
}

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

}  // namespace fricid::data
