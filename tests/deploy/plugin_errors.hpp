// What the MuJoCo plugin and the engine make of the same motion.
#pragma once

#include <span>
#include <vector>

#include "in_mujoco.hpp"
#include "law_errors.hpp"

namespace fricid::deploy::test {

/// Loads the plugin of this build into the process, once.
void load_plugin();

sim::MjModelPtr with_plugin(const Exported& exported);
sim::MjModelPtr with_plugin(const data::ModelFile& model);

sim::MjDataPtr data_of(const mjModel& m);

/// Torques of step k that reverse all joints [N m].
void apply(const mjModel& m, mjData& d, int k);

/// The engine, driven by the motion that MuJoCo makes: call `compare` after each mj_step.
class Shadow {
 public:
  Shadow(const data::ModelFile& model, const mjModel& m, const mjData& d);

  /// Largest difference of the friction torque [N m] in the step before. The load of the torque is
  /// `load`, that of the step what `d` has.
  double compare(const mjData& d, std::span<const double> load);
  double compare(const mjData& d) {
    return compare(d, {d.qfrc_applied, static_cast<std::size_t>(m_.nv)});
  }

 private:
  std::size_t state_size() const { return static_cast<std::size_t>(friction_.model.state_size()); }
  void motion_from(const mjData& d);

  const friction::Friction& friction_;
  const mjModel& m_;
  std::vector<double> z_, tau_f_;
  std::vector<friction::Input<double>> in_;
};

/// The plugin against the engine along two seconds of torques that reverse, or until a robot that
/// its friction drives is too fast.
struct PluginErrors {
  double worst = 0;    ///< difference of the torque [N m]
  double largest = 0;  ///< torque [N m]
  int steps = 0;
};
inline constexpr int kPluginSteps = 4000;
PluginErrors plugin_errors(const data::ModelFile& model);

}  // namespace fricid::deploy::test
