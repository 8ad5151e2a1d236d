// One validated scene file. Each section names its fields once, in `visit`: reading, writing with every
// default filled in, the unknown-key check and `fricid template scene` all use it.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::data {

/// [robot]
struct RobotConfig {
  std::string urdf;                    ///< the engine's robot; relative to the scene file or the share folder
  std::string mjcf;                    ///< the simulator's robot; empty for imported logs
  std::string mount = "floor";         ///< floor, ceiling, wall, or rpy
  std::array<double, 3> mount_rpy{};   ///< [rad], used when mount = "rpy"
  double payload_kg = 0;               ///< rigid, at `payload_com` in the flange frame
  std::array<double, 3> payload_com{};
  /// [[robot.torque]]: known torques linear in a parameter: joint, terms = ["sin(q)", "cos(2 q)", "1", "q"], prior
  std::vector<dynamics::LinearTorque> torques;
};

/// [plant]: the ground-truth simulation.
struct PlantConfig {
  double step_s = 0.0005;              ///< physics step; divides the sample period
};

/// [controller]: not known to the estimators.
struct ControllerConfig {
  std::string kind = "pd_gravity";     ///< pd_gravity, computed_torque, cascade (with integral, imperfect model)
  double bandwidth_hz = 8;             ///< closed-loop position bandwidth
  double damping = 0.9;
  double integral_s = 0.3;             ///< cascade only: reset time
  double model_error = 0.1;            ///< cascade only: relative error of its gravity model
};

/// [excitation]
struct ExcitationConfig {
  int harmonics = 20;
  double base_rad_s = 0.2;             ///< w; period = 2 pi / w
  double spectrum = 0.5;               ///< velocity amplitudes of the random start ~ k^spectrum
  int train = 3;                       ///< distinct training trajectories
  int repeats = 2;                     ///< periods of each, logged as separate sequences
  int validation = 3;
  std::string criterion = "d_optimal"; ///< d_optimal, condition, none
  int restarts = 8;
  double velocity_share = 0.6;         ///< of the joint limit
  double acceleration_share = 0.8;
  double jerk_share = 0.8;
  double torque_share = 0.8;
  double clearance_m = 0.03;           ///< smallest distance to itself, floor, ceiling
  std::vector<double> centre;          ///< (n) [rad] box centre; empty: middle of the limits
  std::vector<double> half_range;      ///< (n) [rad]; empty: 90 % of the limits
};

/// [sensors]
struct SensorsConfig {
  double rate_hz = 250;
  std::vector<double> encoder_noise_rad;         ///< sd per joint
  std::vector<double> encoder_step_rad;          ///< quantisation step per joint, 0: none
  double torque_noise = 0.001;                   ///< sd as a share of the effort limit
  double torque_step = 0.0005;                   ///< quantisation as a share of the effort limit, 0: none
  int torque_delay_samples = 0;
  double dropped = 0;                            ///< share of samples replaced by the previous one
  bool velocity = false;                         ///< log a measured velocity too
  bool temperature = false;                      ///< log the temperature
  double temperature_start_K = 293.15;
  double temperature_rise_K = 0;                 ///< exponential warm-up over the whole recording
  double temperature_time_s = 600;
};

/// [data]: logs instead of simulation.
struct DataConfig {
  std::string contract;                          ///< column contract file (TOML)
  std::vector<std::string> train, validation;    ///< log files; may start with $VARIABLE/
};

/// [prior]: standard deviations of the CAD values, for excitation too short to identify them.
struct PriorConfig {
  bool use = false;
  double mass = 0.15;                            ///< relative
  double com_m = 0.02;
  double inertia = 0.3;                          ///< relative
  double armature = 0.3;                         ///< relative
};

/// [identify]: stage S0, common to all models.
struct IdentifyConfig {
  double cutoff_hz = 10;
  double min_speed_rad_s = 0.2;                  ///< rows with |v_j| above it enter the base parameters
  PriorConfig prior;
};

/// [[model]]: one thing to fit.
struct ModelConfig {
  std::string name;                              ///< simple, stribeck, dahl, lugre, gms, ... a law of the table
  std::string label;
  int elements = 4;
  int starts = 4;                                ///< optimiser starts
  std::vector<int> seeds{1};
};

/// [evaluate]
struct EvaluateConfig {
  std::vector<double> horizons_s{0.1, 1, 10, 0}; ///< 0: full length
  int starts = 4;                                ///< start times per trajectory for horizons below full length
  int substeps = 8;                              ///< engine steps per sample
  double diverged_rad = 10;                      ///< |q error| beyond it flags and clamps a rollout
  double min_headroom = 10;                      ///< below it a horizon is called meaningless
};

/// The whole scene. `n` joints come from the URDF.
struct Experiment {
  std::string name;
  std::uint64_t seed = 1;
  std::string description;
  RobotConfig robot;
  PlantConfig plant;
  std::optional<friction::Friction> friction;    ///< what is injected; absent for logs
  ControllerConfig controller;
  ExcitationConfig excitation;
  SensorsConfig sensors;
  DataConfig data;
  IdentifyConfig identify;
  std::vector<ModelConfig> models;
  EvaluateConfig evaluate;

  dynamics::RobotModel model;                    ///< loaded from robot.urdf with mount, payload, torques
  std::vector<std::filesystem::path> inputs;     ///< every file read: scenes, URDF, contract
  std::filesystem::path folder;                  ///< of the scene file: relative paths start there

  bool simulates() const { return friction.has_value(); }
};

/// Reads a scene, following `extends`. Files named in it are looked for beside the scene, then in the
/// share folder. @throws UserError "file:line: ..." on anything wrong
Experiment load_experiment(const std::filesystem::path& path);

/// The scene as run: every default filled in, `extends` resolved; loading it gives the same experiment.
std::string to_toml(const Experiment& experiment);

/// A commented scene with every key, its unit, range and default.
std::string scene_template();

}  // namespace fricid::data
