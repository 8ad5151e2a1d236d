#include "fricid/scene/problem.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/config/paths.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "fricid/friction/sum.hpp"
#include "friction_by_effort.hpp"
#include "joint_names.hpp"
#include "welds.hpp"

namespace fricid::scene {
namespace {

namespace fs = std::filesystem;
using dynamics::LinearTorque;
using estimate::Method;

constexpr int kFewestDraws = 19;  // whose extremes are the 5 % and 95 % quantiles

// Finds the file named by a key; the name becomes one that any copy of the scene can use: relative
// to the share folder where the file lies in it, else absolute.
fs::path find_and_rename(const SceneOrigin& origin, std::string& name, std::string_view key) {
  if (name.empty()) return {};
  const fs::path path = origin.find(name, key);
  if (name[0] == '$') return path;
  const fs::path in_share =
      fs::weakly_canonical(path).lexically_relative(fs::weakly_canonical(config::share_dir()));
  const bool inside = !in_share.empty() && *in_share.begin() != "..";
  name = inside ? in_share.string() : path.string();
  return path;
}

// Relative logs that exist become absolute, so that the scene can be run from another folder.
void rename_logs(std::vector<std::string>& logs, const fs::path& folder) {
  for (std::string& log : logs) {
    if (log.empty() || log[0] == '$') continue;
    const std::string file = data::log_part(log).file;
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
    const LinearTorqueSection& config = scene.robot.torques[i];
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

// Coupled motors of the contract, if the scene has none. @throws UserError when
// they differ
void take_couplings(Scene& scene, const fs::path& contract_path) {
  if (contract_path.empty()) return;
  std::vector<CouplingSection> of_contract;
  for (const data::Coupling& c : data::load_contract(contract_path).couplings)
    of_contract.push_back({.joint = c.joint, .motor = c.motor, .factor = c.factor});
  if (of_contract.empty()) return;
  std::vector<CouplingSection>& own = scene.robot.couplings;
  if (own.empty()) own = of_contract;
  const auto same = [](const CouplingSection& a, const CouplingSection& b) {
    return a.joint == b.joint && a.motor == b.motor && a.factor == b.factor;
  };
  if (!std::ranges::is_permutation(own, of_contract, same))
    throw UserError(
        "{}: robot.coupling differs from [[coupling]] of {}; allowed: the same, or none",
        scene.origin.place("robot.coupling"), contract_path.string());
}

void add_couplings(const Scene& scene, dynamics::RobotModel& robot) {
  for (std::size_t i = 0; i < scene.robot.couplings.size(); ++i) {
    const CouplingSection& c = scene.robot.couplings[i];
    const std::string key = fmt::format("robot.coupling[{}]", i);
    const std::string shown = fmt::format("robot.coupling[{}]", i + 1);
    const auto index = [&](const std::string& name, const char* what) {
      const auto found = std::ranges::find(scene.joints, name);
      if (found == scene.joints.end())
        throw UserError("{}: {}.{} = \"{}\"; allowed: {}",
                        scene.origin.place(fmt::format("{}.{}", key, what)), shown, what, name,
                        fmt::join(scene.joints, ", "));
      return static_cast<int>(found - scene.joints.begin());
    };
    const int joint = index(c.joint, "joint"), motor = index(c.motor, "motor");
    if (joint == motor)
      throw UserError("{}: {} couples {} with itself", scene.origin.place(key), shown, c.joint);
    robot.couplings.push_back({joint, motor, c.factor});
    if (!dynamics::is_transmission(robot))
      throw UserError(
          "{}: {} leaves a joint that no motor turns alone; allowed: factors by which "
          "the motors turn every joint",
          scene.origin.place(key), shown);
  }
}

void add_payload(const Scene& scene, dynamics::RobotModel& model) {
  const RobotSection& robot = scene.robot;
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

void check_modifiers(const Scene& scene, const std::vector<std::string>& given,
                     const std::string& key, const std::string& shown) {
  std::vector<std::string_view> known;
  for (const friction::LawInfo& row : friction::modifier_table()) known.push_back(row.name);
  for (const std::string& modifier : given) {
    if (std::ranges::find(known, modifier) == known.end())
      throw UserError("{}: {}.modifiers = \"{}\"; allowed: {}",
                      scene.origin.place(key + ".modifiers"), shown, modifier,
                      fmt::join(known, ", "));
    if (std::ranges::count(given, modifier) > 1)
      throw UserError("{}: {}.modifiers names \"{}\" twice", scene.origin.place(key + ".modifiers"),
                      shown, modifier);
  }
}

// A sum of laws stands where a law would.
void check_sum(const Scene& scene, const estimate::ModelOptions& model, const std::string& key,
               const std::string& shown) {
  if (!model.modifiers.empty())
    throw UserError("{}: {}.modifiers beside a sum of laws; allowed: modifiers of each law",
                    scene.origin.place(key + ".modifiers"), shown);
  for (std::size_t l = 0; l < model.laws.size(); ++l) {
    const std::string at = fmt::format("{}.law[{}]", key, l);
    const estimate::LawOptions& law = model.laws[l];
    std::vector<std::string_view> allowed;
    for (const friction::LawInfo& row : friction::law_table())
      if (!friction::is_learned(row.name)) allowed.push_back(row.name);
    if (std::ranges::find(allowed, law.law) == allowed.end())
      throw UserError("{}: {}.law[{}].law = \"{}\"; allowed: {}", scene.origin.place(at + ".law"),
                      shown, l + 1, law.law, fmt::join(allowed, ", "));
    check_modifiers(scene, law.modifiers, at, fmt::format("{}.law[{}]", shown, l + 1));
  }
}

// The law of a model and the method that suits it.
void complete_law(const Scene& scene, estimate::ModelOptions& model,
                  std::span<const std::string_view> laws, const std::string& key,
                  const std::string& shown) {
  const std::string said = model.law.empty() ? "name" : "law";
  if (model.law.empty()) model.law = model.name == "simple" ? "coulomb_viscous" : model.name;
  if (std::ranges::find(laws, model.law) == laws.end())
    throw UserError("{}: {}.{} = \"{}\"; allowed: {}", scene.origin.place(key + "." + said), shown,
                    said, model.law, fmt::join(laws, ", "));
  if (model.law == friction::kLvm) {
    const estimate::ModelOptions defaults;
    for (const auto& [decided, given] :
         {std::pair{"elements", model.elements != defaults.elements},
          std::pair{"modifiers", model.modifiers != defaults.modifiers}})
      if (given)
        throw UserError("{}: {}.{} is given; allowed for lvm, whose parts the data decide: none",
                        scene.origin.place(fmt::format("{}.{}", key, decided)), shown, decided);
    if (model.method.value_or(Method::kJoint) != Method::kJoint)
      throw UserError("{}: {}.method = \"{}\"; allowed for lvm: joint",
                      scene.origin.place(key + ".method"), shown, name_of(*model.method));
    model.method = Method::kJoint;
    return;
  }
  if (!model.modifiers.empty() && friction::is_robot_law(model.law))
    throw UserError("{}: {}.modifiers = \"{}\"; allowed for {}, a law of the whole robot: none",
                    scene.origin.place(key + ".modifiers"), shown, model.modifiers[0], model.law);
  check_modifiers(scene, model.modifiers, key, shown);
  const bool learned = friction::is_learned(model.law);
  if (!model.method) model.method = learned ? Method::kMultiStep : Method::kConventional;
  if (learned && (model.method == Method::kConventional || model.method == Method::kJoint))
    throw UserError("{}: {}.method = \"{}\"; allowed for {}: torque, multi_step, em",
                    scene.origin.place(key + ".method"), shown, name_of(*model.method), model.law);
}

// Checks [[model]] and fills in what its keys leave open.
void complete_models(Scene& scene) {
  std::vector<std::string_view> laws{friction::kLvm};
  for (const friction::LawInfo& row : friction::law_table()) laws.push_back(row.name);
  for (const friction::LawInfo& row : friction::robot_law_table()) laws.push_back(row.name);
  for (std::size_t i = 0; i < scene.models.size(); ++i) {
    estimate::ModelOptions& model = scene.models[i];
    const std::string key = fmt::format("model[{}]", i), shown = fmt::format("model[{}]", i + 1);
    require_name(Named::kModel, model.name, scene.origin.place(key + ".name"));
    require_label(model.label, shown + ".label", scene.origin.place(key + ".label"));
    for (std::size_t other = 0; other < i; ++other)
      if (scene.models[other].name == model.name)
        throw UserError("{}: {}.name = \"{}\" is used twice", scene.origin.place(key + ".name"),
                        shown, model.name);
    if (model.label.empty()) model.label = model.name;
    if (!model.laws.empty()) {
      check_sum(scene, model, key, shown);
      model.method = model.method.value_or(Method::kJoint);
    } else {
      complete_law(scene, model, laws, key, shown);
    }
    if (model.n_z != estimate::ModelOptions{}.n_z &&
        !(model.laws.empty() && friction::is_robot_law(model.law) &&
          friction::find_robot_law(model.law).most_latents > 0))
      throw UserError("{}: {}.n_z = {}; allowed for {}: none", scene.origin.place(key + ".n_z"),
                      shown, model.n_z, model.laws.empty() ? model.law : "a sum of laws");
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
  if (scene.evaluate.horizons_s.empty())
    throw UserError("{}: evaluate.horizons_s = an empty array; allowed: one horizon or more",
                    scene.origin.place("evaluate.horizons_s"));
  if (const int draws = scene.evaluate.draws; draws > 0 && draws < kFewestDraws)
    throw UserError("{}: evaluate.draws = {}; allowed: 0 or at least {}",
                    scene.origin.place("evaluate.draws"), draws, kFewestDraws);
  if (!scene.simulates()) {
    if (scene.data.contract.empty())
      throw UserError("{}: data.contract is missing: column contract of the logs",
                      scene.origin.place("data"));
    return;
  }
  const double rate = scene.sensors.rate_hz;
  if (scene.identify.cutoff_hz >= rate / 2)
    throw UserError(
        "{}: identify.cutoff_hz = {:g} Hz; allowed: below {:g} Hz, half the sample rate",
        scene.origin.place("identify.cutoff_hz"), scene.identify.cutoff_hz, rate / 2);
  const double steps = 1 / (scene.sensors.rate_hz * scene.plant.step_s);
  if (steps < 0.5 || std::abs(steps - std::round(steps)) > 1e-6 * steps)
    throw UserError("{}: plant.step_s = {} s; allowed: the sample period {} s over a whole number",
                    scene.origin.place("plant.step_s"), scene.plant.step_s,
                    1 / scene.sensors.rate_hz);
}

void check_contract(const Scene& scene, const fs::path& path) {
  if (path.empty()) return;
  std::vector<std::string> moving = data::load_contract(path).joint_names;
  std::erase_if(moving, [&](const std::string& joint) { return scene.robot.fix.contains(joint); });
  if (moving == scene.joints) return;
  throw UserError("{}: data.contract has the joints {}; allowed: those of the robot, {}{}",
                  scene.origin.place("data.contract"), fmt::join(moving, ", "),
                  fmt::join(scene.joints, ", "),
                  moving.size() < scene.joints.size()
                      ? "; fix a joint that is not logged: robot.fix = {JOINT = POSITION}"
                      : "");
}

/// The current folder for a scene without a file.
fs::path folder_of_scene(const Scene& scene) {
  return fs::absolute(scene.origin.path.empty() ? "scene" : scene.origin.path)
      .parent_path()
      .lexically_normal();
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
  const fs::path contract = find_and_rename(origin, scene.data.contract, "data.contract");
  rename_logs(scene.data.train, origin.folder("data.train"));
  rename_logs(scene.data.validation, origin.folder("data.validation"));
  take_couplings(scene, contract);
  fix_held_joints(scene, contract, folder_of_scene(scene));
  if (!mjcf.empty() && !scene.robot.fix.empty())
    throw UserError(
        "{}: robot.fix beside robot.mjcf; allowed: one of them, without mjcf the "
        "simulator's arm is made of the URDF",
        origin.place("robot.fix"));
  dynamics::RobotModel robot =
      dynamics::load_urdf(urdf, mount_rotation(scene.robot), welds_of(scene));
  scene.joints = joint_names(robot);
  add_payload(scene, robot);
  add_couplings(scene, robot);
  dynamics::require_inertia(robot, urdf.string());
  scene.identify.linear_prior_sd = add_torques(scene, robot);
  if (scene.friction && scene.friction->model.joints().empty())
    scene.friction = friction_by_effort(robot, origin.place("friction"));

  require_name(Named::kScene, scene.name, origin.place("name"));
  require_label(scene.description, "description", origin.place("description"));
  for (auto* values : {&scene.sensors.encoder_noise_rad, &scene.sensors.encoder_step_rad})
    if (values->empty()) values->assign(scene.joints.size(), 0.0);
  check_contract(scene, contract);
  complete_models(scene);
  check_consistency(scene);

  std::vector<fs::path> inputs = origin.files;
  for (const fs::path& path : {urdf, mjcf, contract})
    if (!path.empty()) inputs.push_back(path);
  for_logs(scene, [&](const std::string& log) {
    try {
      inputs.push_back(config::find_file(data::log_part(log).file, folder_of_scene(scene)));
    } catch (const UserError&) {
      return;  // absent logs are reported by data_available
    }
  });
  return {.scene = std::move(scene),
          .robot = std::move(robot),
          .urdf_path = urdf,
          .mjcf_path = mjcf,
          .contract_path = contract,
          .inputs = std::move(inputs)};
}

void require_horizons(const Scene& scene) {
  if (!scene.simulates()) return;
  const double rate = scene.sensors.rate_hz;
  const double last = std::round(2 * std::numbers::pi / scene.excitation.base_rad_s * rate) - 1;
  for (const double horizon : scene.evaluate.horizons_s)
    if (std::round(horizon * rate) > last)
      throw UserError(
          "{}: evaluate.horizons_s = {:g} s; allowed: up to {:.4g} s, the length of a "
          "recording",
          scene.origin.place("evaluate.horizons_s"), horizon, last / rate);
}

fs::path find_log(const Problem& problem, const std::string& name) {
  return config::find_file(data::log_part(name).file, folder_of_scene(problem.scene));
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

}  // namespace fricid::scene
