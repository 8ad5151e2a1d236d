#include "fricid/scene/problem.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/config/paths.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "friction_by_effort.hpp"
#include "models.hpp"
#include "robot_parts.hpp"
#include "welds.hpp"

namespace fricid::scene {
namespace {

namespace fs = std::filesystem;

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

// The model of another run, absolute wherever the scene is. That of a scene in a run folder may be
// gone since.
void find_prior(const SceneOrigin& origin, std::string& name, const std::string& key) {
  if (name.empty() || fs::path(name).is_absolute()) return;
  name = fs::absolute(origin.find(name, key)).lexically_normal().string();
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

/// Closed loops are simulated, and need paths, forces and names that differ from theirs.
void check_loops(const Scene& scene) {
  const sim::CompensationOptions& loops = scene.compensation;
  const auto require =
      [&](bool wanted, const std::string& key,
          std::initializer_list<std::pair<std::string, const std::vector<double>*>> lists) {
        if (!wanted) return;
        if (!scene.simulates())
          throw UserError("{}: {} without [friction]; allowed: a scene that simulates",
                          scene.origin.place(key), key);
        for (const auto& [name, values] : lists)
          if (values->empty())
            throw UserError("{}: {} = an empty array; allowed: one or more",
                            scene.origin.place(name), name);
      };
  require(
      loops.wanted(), "compensation.gains",
      {{"compensation.bandwidths_hz", &loops.bandwidths_hz}, {"compensation.sizes", &loops.sizes}});
  require(scene.contact.wanted(), "contact.hours", {{"contact.forces_N", &scene.contact.forces_N}});
  constexpr double kFastestBase = 1.5;  // [rad/s] observers need a while to begin
  if (scene.contact.wanted() && scene.excitation.base_rad_s > kFastestBase)
    throw UserError("{}: excitation.base_rad_s = {:g}; allowed beside contact.hours: up to {:g}",
                    scene.origin.place("excitation.base_rad_s"), scene.excitation.base_rad_s,
                    kFastestBase);
  if (!loops.wanted() && !scene.contact.wanted()) return;
  for (std::size_t i = 0; i < scene.models.size(); ++i)
    if (const std::string& name = scene.models[i].name; name == "none" || name == "truth")
      throw UserError("{}: model[{}].name = \"{}\"; allowed in closed loops: another",
                      scene.origin.place(fmt::format("model[{}].name", i)), i + 1, name);
}

// Calls with the key and the name of each log of a scene.
template <class Use>
void for_logs(const Scene& scene, Use&& use) {
  const auto each = [&](const char* key, const std::vector<std::string>& logs) {
    for (const std::string& log : logs) use(key, log);
  };
  each("data.train", scene.data.train);
  each("data.validation", scene.data.validation);
  each("payload.logs", scene.payload.logs);
}

void check_consistency(const Scene& scene) {
  check_loops(scene);
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
    if (!scene.data.contract.empty()) return;
    for_logs(scene, [&](const char*, const std::string& log) {
      if (fs::path(data::log_part(log).file).extension() != ".h5")
        throw UserError(
            "{}: data.contract is missing: column contract of the logs; only data sets of `fricid "
            "import` (.h5) need none",
            scene.origin.place("data"));
    });
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
  if (std::ranges::is_permutation(moving, scene.joints)) return;
  throw UserError("{}: data.contract has the joints {}; allowed: those of the robot, {}{}",
                  scene.origin.place("data.contract"), fmt::join(moving, ", "),
                  fmt::join(scene.joints, ", "),
                  moving.size() < scene.joints.size()
                      ? "; fix a joint that is not logged: robot.fix = {JOINT = POSITION}"
                      : "");
}

/// A load is found by two kinds of recordings of one arm, which must tell it.
void check_payload(const Scene& scene, dynamics::RobotModel robot) {
  const PayloadSection& load = scene.payload;
  if (!load.wanted()) return;
  const auto refuse = [&](const std::string& key, const char* found, const char* allowed) {
    throw UserError("{}: {} {}; allowed: {}", scene.origin.place(key), key, found, allowed);
  };
  if (!load.logs.empty() && scene.simulates())
    refuse("payload.logs", "beside [friction]", "payload.mass_kg, the load to simulate");
  if (load.mass_kg > 0 && !scene.simulates())
    refuse("payload.mass_kg", "without [friction]", "payload.logs");
  if (load.mass_kg > 0 && scene.robot.payload_kg > 0)
    refuse("payload.mass_kg", "beside robot.payload_kg", "one of them");
  add_unknown_load(scene, robot);
}

/// The current folder for a scene without a file.
fs::path folder_of_scene(const Scene& scene) {
  return fs::absolute(scene.origin.path.empty() ? "scene" : scene.origin.path)
      .parent_path()
      .lexically_normal();
}

}  // namespace

Problem resolve(Scene scene) {
  const SceneOrigin& origin = scene.origin;
  const fs::path urdf = find_and_rename(origin, scene.robot.urdf, "robot.urdf");
  const fs::path mjcf = find_and_rename(origin, scene.robot.mjcf, "robot.mjcf");
  const fs::path contract = find_and_rename(origin, scene.data.contract, "data.contract");
  for (std::size_t i = 0; i < scene.models.size(); ++i)
    find_prior(origin, scene.models[i].prior, fmt::format("model[{}].prior", i));
  rename_logs(scene.data.train, origin.folder("data.train"));
  rename_logs(scene.data.validation, origin.folder("data.validation"));
  rename_logs(scene.payload.logs, origin.folder("payload.logs"));
  take_couplings(scene, contract);
  fix_held_joints(scene, contract, folder_of_scene(scene));
  if (!mjcf.empty() && !scene.robot.fix.empty())
    throw UserError(
        "{}: robot.fix beside robot.mjcf; allowed: one of them, without mjcf the "
        "simulator's arm is made of the URDF",
        origin.place("robot.fix"));
  dynamics::RobotModel robot = dynamics::load_urdf(urdf, mount_rotation(scene.robot),
                                                   welds_of(scene), scene.robot.mend_inertia);
  scene.joints = robot.joint_names();
  add_payload(scene, robot);
  add_couplings(scene, robot);
  add_armatures(scene, robot);
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
  check_payload(scene, robot);

  std::vector<fs::path> inputs = origin.files;
  for (const fs::path& path : {urdf, mjcf, contract})
    if (!path.empty()) inputs.push_back(path);
  for (const estimate::ModelOptions& model : scene.models)
    if (fs::exists(model.prior)) inputs.emplace_back(model.prior);
  for_logs(scene, [&](const char*, const std::string& log) {
    try {
      inputs.push_back(config::find_file(data::log_part(log).file, folder_of_scene(scene)));
    } catch (const UserError&) {
      return;  // absent logs are refused by require_logs
    }
  });
  return {.scene = std::move(scene),
          .robot = std::move(robot),
          .urdf_path = urdf,
          .mjcf_path = mjcf,
          .contract_path = contract,
          .inputs = std::move(inputs)};
}

Problem with_load(const Problem& problem) {
  Scene scene = problem.scene;
  scene.robot.payload_frame = scene.payload.frame;
  scene.robot.payload_kg = scene.payload.mass_kg;
  scene.robot.payload_com = scene.payload.com;
  scene.robot.payload_inertia = scene.payload.inertia;
  scene.excitation.validation = 0;
  ++scene.seed;
  dynamics::RobotModel robot = problem.robot;
  add_unknown_load(scene, robot);
  return {.scene = std::move(scene),
          .robot = std::move(robot),
          .urdf_path = problem.urdf_path,
          .mjcf_path = problem.mjcf_path,
          .contract_path = problem.contract_path,
          .inputs = problem.inputs};
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

void require_logs(const Problem& problem) {
  for_logs(problem.scene, [&](const char* key, const std::string& log) {
    try {
      find_log(problem, log);
    } catch (const UserError& error) {
      throw UserError("{}: {}", problem.scene.origin.place(key), error.what());
    }
  });
}

void require_priors(const Problem& problem) {
  const std::vector<estimate::ModelOptions>& models = problem.scene.models;
  for (std::size_t i = 0; i < models.size(); ++i)
    if (!models[i].prior.empty())
      problem.scene.origin.find(models[i].prior, fmt::format("model[{}].prior", i));
}

bool logs_are_there(const Problem& problem) {
  try {
    require_logs(problem);
  } catch (const UserError&) {
    return false;
  }
  return true;
}

}  // namespace fricid::scene
