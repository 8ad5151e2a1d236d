// The engine plugin "fricid.friction" of MuJoCo: the friction of a model file as passive torques.
#include <fmt/format.h>
#include <mujoco/mjplugin.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/sim/friction_host.hpp"

namespace fricid::sim {
namespace {

// Configuration of an instance: either the path of a model file or its content; what joint names
// begin with in the MJCF; temperature of all joints [K].
constexpr std::array kAttributes{"model", "content", "prefix", "temperature"};

std::string attribute(const mjModel* m, int instance, const char* name) {
  const char* value = mj_getPluginConfig(m, instance, name);
  return value ? value : "";
}

data::ModelFile model_of(const mjModel* m, int instance) {
  const std::string path = attribute(m, instance, "model");
  const std::string content = attribute(m, instance, "content");
  if (path.empty() == content.empty())
    throw UserError("found {} of the attributes model and content; allowed: one",
                    path.empty() ? "none" : "both");
  return path.empty() ? data::parse_model(content, "content") : data::load_model(path);
}

double temperature_of(const mjModel* m, int instance) {
  const std::string text = attribute(m, instance, "temperature");
  if (text.empty()) return kRoomTemperature;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (*end != '\0' || !(value > 0) || !std::isfinite(value))
    throw UserError("temperature: found {}; allowed: above 0 [K]", text);
  return value;
}

// The joint of the MJCF that is joint j of the robot.
int joint_id(const mjModel* m, const std::string& prefix, const dynamics::Joint& joint) {
  const std::string name = prefix + joint.name;
  const int id = mj_name2id(m, mjOBJ_JOINT, name.c_str());
  if (id < 0) throw UserError("the MJCF has no joint {}", name);
  const bool revolute = joint.type == dynamics::JointType::kRevolute;
  if (m->jnt_type[id] != (revolute ? mjJNT_HINGE : mjJNT_SLIDE))
    throw UserError("joint {} of the MJCF is no {}", name, revolute ? "hinge" : "slide");
  return id;
}

FrictionHost make_host(const mjModel* m, int instance, const data::ModelFile& model) {
  const std::string prefix = attribute(m, instance, "prefix");
  std::vector<int> qpos, dof;
  for (const dynamics::Joint& joint : model.arm.robot.joints) {
    const int id = joint_id(m, prefix, joint);
    qpos.push_back(m->jnt_qposadr[id]);
    dof.push_back(m->jnt_dofadr[id]);
  }
  return {model.arm.friction, model.arm.robot, std::move(qpos), std::move(dof)};
}

/// What an mjData holds for an instance: workspace alone. The state is in mjData.plugin_state: z
/// (state_size), then, where friction reads the load, the torque of the actuators in the last step
/// (n), since those of a step are known only after its passive forces.
struct Instance {
  FrictionHost host;
  std::vector<double> load, temperature;  // (n)
  bool reads_load;

  mjtNum* actuator_torque(mjtNum* state) const { return state + host.z().size(); }

  void read(const mjData* d, mjtNum* state) {
    std::copy_n(state, host.z().size(), host.z().begin());
    if (!reads_load) return;
    for (std::size_t j = 0; j < load.size(); ++j)
      load[j] = d->qfrc_applied[host.dof()[j]] + actuator_torque(state)[j];
  }
};

int state_size(const data::ModelFile& model) {
  const friction::RobotFriction& friction = model.arm.friction.model;
  return friction.state_size() + (friction.reads_load() ? friction.joint_count() : 0);
}

Instance* instance_of(const mjData* d, int instance) {
  return reinterpret_cast<Instance*>(d->plugin_data[instance]);  // NOLINT: MuJoCo keeps a number
}

// Calls f; what it throws becomes an error of MuJoCo. That may jump, so nothing is left to destroy.
template <class F>
int guarded(F f) {
  std::array<char, 1024> message{};
  try {
    return f();
  } catch (const std::exception& error) {
    const auto end =
        fmt::format_to_n(message.data(), message.size() - 1, "fricid.friction: {}", error.what());
    *end.out = '\0';
  }
  mju_error("%s", message.data());
  return -1;
}

int nstate(const mjModel* m, int instance) {
  return guarded([&] { return state_size(model_of(m, instance)); });
}

int init(const mjModel* m, mjData* d, int instance) {
  return guarded([&] {
    const data::ModelFile model = model_of(m, instance);
    const std::vector<double> temperature(static_cast<std::size_t>(model.arm.robot.n()),
                                          temperature_of(m, instance));
    d->plugin_data[instance] = reinterpret_cast<std::uintptr_t>(
        new Instance{.host = make_host(m, instance, model),
                     .load = std::vector<double>(temperature.size()),
                     .temperature = temperature,
                     .reads_load = model.arm.friction.model.reads_load()});
    return 0;
  });
}

void destroy(mjData* d, int instance) {
  delete instance_of(d, instance);
  d->plugin_data[instance] = 0;
}

void reset(const mjModel* m, mjtNum* plugin_state, void* /*plugin_data*/, int instance) {
  std::fill_n(plugin_state, m->plugin_statenum[instance], 0.0);
}

void compute(const mjModel* m, mjData* d, int instance, int /*capability*/) {
  Instance& own = *instance_of(d, instance);
  own.read(d, d->plugin_state + m->plugin_stateadr[instance]);
  const std::span<const double> tau_f = own.host.torque(*d, own.load, own.temperature);
  for (std::size_t j = 0; j < tau_f.size(); ++j) d->qfrc_passive[own.host.dof()[j]] -= tau_f[j];
}

// MuJoCo calls this with the new q and v.
void advance(const mjModel* m, mjData* d, int instance) {
  Instance& own = *instance_of(d, instance);
  mjtNum* state = d->plugin_state + m->plugin_stateadr[instance];
  if (own.reads_load)
    for (std::size_t j = 0; j < own.load.size(); ++j)
      own.actuator_torque(state)[j] = d->qfrc_actuator[own.host.dof()[j]];
  own.read(d, state);
  own.host.step(*d, own.load, own.temperature, m->opt.timestep);
  std::ranges::copy(own.host.z(), state);
}

}  // namespace
}  // namespace fricid::sim

mjPLUGIN_LIB_INIT(fricid_friction) {
  using namespace fricid::sim;
  mjpPlugin plugin;
  mjp_defaultPlugin(&plugin);
  plugin.name = "fricid.friction";
  plugin.capabilityflags = mjPLUGIN_PASSIVE;
  plugin.nattribute = static_cast<int>(kAttributes.size());
  plugin.attributes = kAttributes.data();
  plugin.nstate = nstate;
  plugin.init = init;
  plugin.destroy = destroy;
  plugin.reset = reset;
  plugin.compute = compute;
  plugin.advance = advance;
  mjp_registerPlugin(&plugin);
}
