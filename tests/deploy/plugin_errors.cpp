#include "plugin_errors.hpp"

#include <algorithm>
#include <cmath>

namespace fricid::deploy::test {

void load_plugin() {
  sim::initialise_mujoco();
  [[maybe_unused]] static const bool loaded = (mj_loadPluginLibrary(FRICID_PLUGIN), true);
}

sim::MjModelPtr with_plugin(const Exported& exported) {
  load_plugin();
  return in_mujoco(exported);
}
sim::MjModelPtr with_plugin(const data::ModelFile& model) {
  return with_plugin(export_model(model, "plugin"));
}

sim::MjDataPtr data_of(const mjModel& m) { return sim::MjDataPtr(mj_makeData(&m)); }

void apply(const mjModel& m, mjData& d, int k) {
  for (int j = 0; j < m.nv; ++j)
    d.qfrc_applied[j] = 9 * std::sin(0.012 * k + j) * (1 + std::sin(0.0007 * k));
}

Shadow::Shadow(const data::ModelFile& model, const mjModel& m, const mjData& d)
    : friction_(model.arm.friction), m_(m), z_(d.plugin_state, d.plugin_state + state_size()) {
  in_.resize(static_cast<std::size_t>(m.nv));
  tau_f_.resize(in_.size());
  motion_from(d);
}

double Shadow::compare(const mjData& d, std::span<const double> load) {
  for (std::size_t j = 0; j < in_.size(); ++j) in_[j].load = load[j];
  friction_.model.torque<double>(friction_.theta, in_, z_, tau_f_);
  double worst = 0;
  for (int j = 0; j < m_.nv; ++j)
    worst = std::max(worst, std::abs(d.qfrc_passive[j] + tau_f_[static_cast<std::size_t>(j)]));
  motion_from(d);
  for (int j = 0; j < m_.nv; ++j)
    in_[static_cast<std::size_t>(j)].load = d.qfrc_applied[j] + d.qfrc_actuator[j];
  friction_.model.step<double>(friction_.theta, in_, m_.opt.timestep, z_);
  return worst;
}

void Shadow::motion_from(const mjData& d) {
  for (std::size_t j = 0; j < in_.size(); ++j) in_[j] = {d.qpos[j], d.qvel[j], 0, kRoomTemperature};
}

PluginErrors plugin_errors(const data::ModelFile& model) {
  const sim::MjModelPtr m = with_plugin(model);
  m->opt.timestep = 5e-4;
  const sim::MjDataPtr d = data_of(*m);
  Shadow engine(model, *m, *d);
  PluginErrors errors;
  // networks with random weights may drive the robot
  constexpr double kTooFast = 50;  // [rad/s]
  int& k = errors.steps;
  for (; k < kPluginSteps && std::abs(d->qvel[0]) + std::abs(d->qvel[1]) < kTooFast; ++k) {
    apply(*m, *d, k);
    mj_step(m.get(), d.get());
    errors.worst = std::max(errors.worst, engine.compare(*d));
    for (int j = 0; j < m->nv; ++j)
      errors.largest = std::max(errors.largest, std::abs(d->qfrc_passive[j]));
  }
  return errors;
}

}  // namespace fricid::deploy::test
