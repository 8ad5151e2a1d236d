// What a scene file says. Each section names its fields once, in `visit`: reading, writing with
// every default filled in, the unknown-key check and `fricid template scene` all use it, and it
// says what each field means, in which unit and range.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/field.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::data {

/// [[robot.torque]]: torques of one joint, each a known shape times an unknown coefficient.
struct TorqueConfig {
  std::string joint;
  std::vector<std::string> terms;
  std::vector<double> prior_sd;

  /// For the template.
  static TorqueConfig example() {
    return {.joint = "joint_a2", .terms = {"1", "sin(q)", "cos(q)"}, .prior_sd = {10, 500, 500}};
  }
  template <class Archive>
  void visit(Archive& archive) {
    archive("joint", joint, required(text("name of the joint")));
    archive("terms", terms, required(text("shapes: 1, q, sin(q), cos(q), sin(2 q), ...")));
    archive(
        "prior_sd", prior_sd,
        number("N m", 0, 1e6, "standard deviation of each coefficient about 0; []: none known"));
  }
};

/// [robot]
struct RobotConfig {
  std::string urdf;
  std::string mjcf;
  std::string mount = "floor";
  std::array<double, 3> mount_rpy{};
  double payload_kg = 0;
  std::array<double, 3> payload_com{};
  std::array<double, 6> payload_inertia{};
  std::string payload_frame = "flange";
  std::vector<TorqueConfig> torques;

  template <class Archive>
  void visit(Archive& archive) {
    archive("urdf", urdf,
            required(text("the engine's robot; beside the scene or in the share folder")));
    archive("mjcf", mjcf, text("the simulator's robot; empty for logs"));
    archive("mount", mount, choice("floor ceiling wall rpy", "how the base is fixed"));
    archive("mount_rpy", mount_rpy,
            number("rad", -6.2832, 6.2832, "roll, pitch, yaw of the base when mount = \"rpy\""));
    archive("payload_kg", payload_kg, number("kg", 0, 2000, "rigid payload"));
    archive("payload_com", payload_com,
            number("m", -5, 5, "centre of mass of the payload in payload_frame"));
    archive("payload_inertia", payload_inertia,
            number("kg m^2", -1e4, 1e4,
                   "Ixx, Iyy, Izz, Ixy, Ixz, Iyz of the payload about its centre of mass"));
    archive("payload_frame", payload_frame, text("frame of the URDF that carries the payload"));
    archive.sections("torque", torques,
                     "known torques linear in a parameter, e.g. a counterbalance");
  }
};

/// [plant]: the ground-truth simulation.
struct PlantConfig {
  double step_s = 0.0005;

  template <class Archive>
  void visit(Archive& archive) {
    archive("step_s", step_s, number("s", 1e-6, 0.1, "physics step; divides the sample period"));
  }
};

/// [controller]: not known to the estimators.
struct ControllerConfig {
  std::string kind = "pd_gravity";
  double bandwidth_hz = 8;
  double damping = 0.9;
  double integral_s = 0.3;
  double model_error = 0.1;

  template <class Archive>
  void visit(Archive& archive) {
    archive("kind", kind,
            choice("pd_gravity computed_torque cascade",
                   "law; cascade has an integral and an "
                   "imperfect gravity model"));
    archive("bandwidth_hz", bandwidth_hz,
            number("Hz", 0.01, 1000, "closed-loop position bandwidth"));
    archive("damping", damping, number("1", 0.01, 10, "damping ratio"));
    archive("integral_s", integral_s, number("s", 1e-3, 1e6, "cascade: reset time"));
    archive("model_error", model_error,
            number("1", 0, 1, "cascade: relative error of its gravity model"));
  }
};

/// [excitation]: Fourier series per joint.
struct ExcitationConfig {
  int harmonics = 20;
  double base_rad_s = 0.2;
  double spectrum = 0.5;
  int train = 3;
  int repeats = 2;
  int validation = 3;
  std::string criterion = "d_optimal";
  int restarts = 8;
  double velocity_share = 0.6;
  double acceleration_share = 0.8;
  double jerk_share = 0.8;
  double torque_share = 0.8;
  double clearance_m = 0.03;
  std::vector<double> centre;
  std::vector<double> half_range;

  template <class Archive>
  void visit(Archive& archive) {
    archive("harmonics", harmonics, number("", 1, 200, "terms of the Fourier series"));
    archive("base_rad_s", base_rad_s,
            number("rad/s", 1e-3, 100, "base frequency w; the period is 2 pi / w"));
    archive("spectrum", spectrum,
            number("1", -4, 4, "velocity amplitudes of the random start rise as k^spectrum"));
    archive("train", train, number("", 1, 1000, "distinct training trajectories"));
    archive(
        "repeats", repeats,
        number("", 1, 100, "periods of each training trajectory, logged as separate sequences"));
    archive("validation", validation, number("", 0, 1000, "distinct validation trajectories"));
    archive(
        "criterion", criterion,
        choice("d_optimal condition none", "what the optimiser improves in the base regressor"));
    archive("restarts", restarts, number("", 1, 10000, "random starts of the optimiser"));
    archive("velocity_share", velocity_share, number("1", 0.01, 1, "share of the velocity limit"));
    archive("acceleration_share", acceleration_share,
            number("1", 0.01, 1, "share of the acceleration limit"));
    archive("jerk_share", jerk_share, number("1", 0.01, 1, "share of the jerk limit"));
    archive("torque_share", torque_share, number("1", 0.01, 1, "share of the effort limit"));
    archive("clearance_m", clearance_m,
            number("m", 0, 1, "smallest distance to itself, floor and ceiling"));
    archive("centre", centre,
            per_joint("rad", -12.6, 12.6, "centre of the position box; []: middle of the limits"));
    archive("half_range", half_range,
            per_joint("rad", 0, 12.6, "half width of the position box; []: 90 % of the limits"));
  }
};

/// [sensors]
struct SensorsConfig {
  double rate_hz = 250;
  std::vector<double> encoder_noise_rad;  ///< (n) after resolving
  std::vector<double> encoder_step_rad;   ///< (n) after resolving
  double torque_noise = 0.001;
  double torque_step = 0.0005;
  int torque_delay_samples = 0;
  double dropped = 0;
  bool velocity = false;
  bool temperature = false;
  double temperature_start_K = 293.15;
  double temperature_rise_K = 0;
  double temperature_time_s = 600;

  template <class Archive>
  void visit(Archive& archive) {
    archive("rate_hz", rate_hz, number("Hz", 1, 1e5, "sample rate"));
    archive("encoder_noise_rad", encoder_noise_rad,
            per_joint("rad", 0, 0.1, "standard deviation of the position noise; []: none"));
    archive("encoder_step_rad", encoder_step_rad,
            per_joint("rad", 0, 0.1, "quantisation of the position, 0: none; []: none"));
    archive("torque_noise", torque_noise,
            number("1", 0, 1, "standard deviation as a share of the effort limit"));
    archive("torque_step", torque_step,
            number("1", 0, 1, "quantisation as a share of the effort limit, 0: none"));
    archive("torque_delay_samples", torque_delay_samples,
            number("", 0, 1000, "samples that the logged torque lags behind"));
    archive("dropped", dropped, number("1", 0, 0.5, "share of samples replaced by the one before"));
    archive("velocity", velocity, flag("log a measured velocity too"));
    archive("temperature", temperature, flag("log the temperature"));
    archive("temperature_start_K", temperature_start_K,
            number("K", 200, 500, "temperature at the start of the recording"));
    archive("temperature_rise_K", temperature_rise_K,
            number("K", -200, 200, "warm-up over the whole recording: rise (1 - exp(-t / time))"));
    archive("temperature_time_s", temperature_time_s,
            number("s", 1e-3, 1e6, "time constant of the warm-up"));
  }
};

/// [data]: logs instead of simulation.
struct DataConfig {
  std::string contract;
  std::vector<std::string> train, validation;

  template <class Archive>
  void visit(Archive& archive) {
    archive("contract", contract, text("column contract (fricid template contract)"));
    archive("train", train, text("log files to learn from; may start with $VARIABLE/"));
    archive("validation", validation, text("log files to judge by; may start with $VARIABLE/"));
  }
};

/// [identify.prior]: the CAD values as a prior, for excitation too short to identify them.
struct PriorConfig {
  bool use = false;
  double mass = 0.15;
  double com_m = 0.02;
  double inertia = 0.3;
  double armature = 0.3;

  template <class Archive>
  void visit(Archive& archive) {
    archive("use", use, flag("use the robot's nominal values as a prior"));
    archive("mass", mass, number("1", 1e-6, 1e3, "relative standard deviation of each mass"));
    archive("com_m", com_m, number("m", 1e-6, 10, "standard deviation of each centre of mass"));
    archive("inertia", inertia,
            number("1", 1e-6, 1e3, "relative standard deviation of each inertia"));
    archive("armature", armature,
            number("1", 1e-6, 1e3, "relative standard deviation of each armature"));
  }
};

/// [identify]: the least-squares stage, common to all models.
struct IdentifyConfig {
  double cutoff_hz = 10;
  double min_speed_rad_s = 0.2;
  PriorConfig prior;

  template <class Archive>
  void visit(Archive& archive) {
    archive("cutoff_hz", cutoff_hz,
            number("Hz", 0.01, 1e4, "cut-off of the zero-phase low pass (Butterworth, order 4)"));
    archive("min_speed_rad_s", min_speed_rad_s,
            number("rad/s", 0, 100, "speed below which rows do not enter the base parameters"));
    archive.section("prior", prior, "standard deviations about the nominal robot");
  }
};

/// [model.torque]: training on the torque that the rigid body leaves.
struct TorqueTrainingConfig {
  double window_s = 0.5;
  int batch = 32;
  int iterations = 2000;
  double rate = 0.004;
  bool filtered = true;
  double hold_out = 0.2;

  template <class Archive>
  void visit(Archive& archive) {
    archive("window_s", window_s,
            number("s", 0, 100, "over which the friction state is differentiated; 0: one sample"));
    archive("batch", batch, number("", 1, 1e6, "windows per step"));
    archive("iterations", iterations, number("", 0, 1e7, "steps of Adam"));
    archive("rate", rate, number("1", 1e-6, 1, "first step length of Adam"));
    archive("filtered", filtered,
            flag("pass the model's torque through the filter of the measured one; else motion and "
                 "torque are compared as filtered at cutoff_hz"));
    archive("hold_out", hold_out,
            number("1", 0.05, 0.5, "last share of every recording, kept for choosing"));
  }
};

/// [model.train]: training on open-loop windows.
struct TrainConfig {
  std::string optimiser = "auto";
  double window_s = 0.25;
  int batch = 32;
  int iterations = 0;
  double rate = 0;
  bool rigid_body = true;
  double hold_out = 0.2;

  template <class Archive>
  void visit(Archive& archive) {
    archive("optimiser", optimiser,
            choice("auto adam gauss_newton",
                   "auto: Gauss-Newton steps with sampled curvature for up to 8000 parameters, "
                   "else Adam"));
    archive("window_s", window_s, number("s", 0.01, 100, "length of a window"));
    archive("batch", batch, number("", 1, 1e6, "windows per step"));
    archive("iterations", iterations,
            number("", 0, 1e7, "steps; 0: 2400 of adam, 1000 of gauss_newton"));
    archive("rate", rate,
            number("1", 0, 1, "first step length; 0: 0.008 of adam, 1 of gauss_newton"));
    archive("rigid_body", rigid_body, flag("train the rigid body together with the friction"));
    archive("hold_out", hold_out,
            number("1", 0.05, 0.5, "last share of every recording, kept for choosing"));
  }
};

/// [model.em]: expectation-maximisation.
struct EmConfig {
  std::string e_step = "ekf";
  std::string m_step = "score";
  int iterations = 10;
  int particles = 200;
  int paths = 4;
  int m_steps = 500;
  int batch = 2048;
  double rate = 0.004;
  double torque_noise = 0.1;
  double torque_floor = 0.01;
  double z_noise_first = 0.1;
  double z_noise_last = 0.01;
  bool free_observation_noise = false;
  bool rigid_body = true;
  double hold_out = 0.2;
  std::string keep = "held_out";

  template <class Archive>
  void visit(Archive& archive) {
    archive("e_step", e_step, choice("ekf psi adapted bootstrap", "how paths are smoothed"));
    archive("m_step", m_step,
            choice("score transitions",
                   "climb the likelihood, or the transition density, as networks always do"));
    archive("iterations", iterations, number("", 0, 1e5, "E- and M-steps"));
    archive("particles", particles, number("", 1, 1e6, "of the particle filters"));
    archive("paths", paths, number("", 1, 1000, "smoothed paths per recording"));
    archive("m_steps", m_steps, number("", 0, 1e6, "steps of Adam per iteration"));
    archive("batch", batch, number("", 1, 1e7, "transitions per step of Adam"));
    archive("rate", rate, number("1", 1e-6, 1, "first step length of Adam"));
    archive("torque_noise", torque_noise,
            number("1", 1e-6, 10, "first noise of the torque, share of the friction torque"));
    archive("torque_floor", torque_floor, number("1", 1e-9, 10, "least such noise"));
    archive(
        "z_noise_first", z_noise_first,
        number("1", 1e-9, 10, "first noise of the latent states per sample, share of their size"));
    archive("z_noise_last", z_noise_last, number("1", 1e-9, 10, "last such noise"));
    archive("free_observation_noise", free_observation_noise,
            flag("estimate the encoder noise too, once the latent states are quiet"));
    archive("rigid_body", rigid_body, flag("fit the rigid body together with the friction"));
    archive("hold_out", hold_out,
            number("1", 0.05, 0.5, "last share of every recording, kept for choosing"));
    archive("keep", keep,
            choice("held_out last", "which iteration: the best on held-out rollouts, or the last"));
  }
};

/// [[model]]: one thing to fit.
struct ModelConfig {
  std::string name;
  std::string label;
  std::string law;     ///< name of the law table after resolving
  std::string method;  ///< never empty after resolving
  int elements = 4;
  std::vector<std::string> modifiers;
  int starts = 4;
  std::vector<int> seeds{1};
  TorqueTrainingConfig torque;
  TrainConfig train;
  EmConfig em;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name,
            required(text("name of its files, used once: letters, digits, _ - and .")));
    archive("label", label, text("name in tables and plots; empty: the name"));
    archive("law", law,
            text("friction law fitted to every joint, or law of the whole robot; empty: the name "
                 "(simple: coulomb_viscous)"));
    archive(
        "method", method,
        choice("conventional torque multi_step em",
               "how it is fitted: to the torque that the rigid body leaves, by a search or by "
               "gradients, or from there on by open-loop windows or by expectation-maximisation; "
               "empty: multi_step for learned laws, else conventional"));
    archive(
        "elements", elements,
        number("", 1, 64, "elements of laws that have several; width of the nets of learned ones"));
    archive("modifiers", modifiers,
            text("modifiers of the law, innermost first: asymmetry, load, temperature, ..."));
    archive("starts", starts, number("", 1, 1000, "starts of the optimiser"));
    archive("seeds", seeds, number("", 0, 1e9, "one fit per seed"));
    archive.section("torque", torque,
                    "method torque, and multi_step of laws of the whole robot before its windows");
    archive.section("train", train, "method multi_step");
    archive.section("em", em, "method em");
  }
};

/// [evaluate]
struct EvaluateConfig {
  std::vector<double> horizons_s{0.1, 1, 10, 0};
  int starts = 4;
  int substeps = 8;
  double diverged_rad = 10;
  double min_headroom = 10;
  int draws = 39;

  template <class Archive>
  void visit(Archive& archive) {
    archive("horizons_s", horizons_s,
            number("s", 0, 1e5, "lengths of the open-loop rollouts; 0: the full length"));
    archive("starts", starts,
            number("", 1, 1000, "start times per trajectory for horizons below full length"));
    archive("substeps", substeps, number("", 1, 1000, "steps of the engine per sample"));
    archive("diverged_rad", diverged_rad,
            number("rad", 1e-3, 1e6, "position error beyond which a rollout is flagged and held"));
    archive("min_headroom", min_headroom,
            number("1", 0, 1e9,
                   "best conventional error over the oracle's below which a horizon is "
                   "called meaningless"));
    archive("draws", draws,
            number("", 0, 10000,
                   "open-loop rollouts per model and trajectory whose quantiles are the 90 % band, "
                   "19 or more; 0: no bands"));
  }
};

/// [render]: the film of a run. The plots and the report are always made.
struct RenderConfig {
  bool video = true;
  std::string layout = "ghosts";
  std::string quality = "standard";
  std::vector<std::string> models;
  std::string joint;
  std::vector<double> camera_deg;
  double card_s = 3;

  template <class Archive>
  void visit(Archive& archive) {
    archive("video", video, flag("make the videos in `fricid run`"));
    archive("layout", layout,
            choice("ghosts side_by_side",
                   "models as translucent ghosts on one arm, or each beside the others"));
    archive("quality", quality,
            choice("draft standard final", "standard has smooth edges, final shadows too"));
    archive("models", models,
            text("names of the models shown; []: the best, the first of the scene, the next best"));
    archive("joint", joint, text("whose friction is shown; empty: the one the models miss most"));
    archive(
        "camera_deg", camera_deg,
        number("deg", -360, 360, "azimuth and elevation; []: from where the error is seen best"));
    archive("card_s", card_s, number("s", 0, 60, "opening and closing card, each; 0: none"));
  }
};

/// Where a key of a scene stands.
struct Place {
  std::string file;  ///< as the user named it
  std::uint64_t line = 0;
};

/// Where a scene came from: for messages, and for the files it names. Empty for a scene made in
/// code.
struct SceneOrigin {
  std::string path;                          ///< as the user named it
  std::vector<std::filesystem::path> files;  ///< read for it, itself first, then what it extends
  std::map<std::string, Place> keys;         ///< "robot.torque[0].joint" and so on, and tables

  /// "file:line" of a key or of the nearest table around it that was written, for messages.
  std::string place(std::string_view key) const;
  /// Folder of the file in which a key stands: relative file names start there.
  std::filesystem::path folder(std::string_view key) const;
  /// Absolute path of the file that a key names. @throws UserError when it is not there
  std::filesystem::path find(const std::string& name, std::string_view key) const;
};

/// What a scene file says, plain: nothing is looked up, see `resolve`.
struct Scene {
  std::string name;
  std::string description;
  std::uint64_t seed = 1;
  RobotConfig robot;
  /// What is injected; absent for logs. Without a law for any joint: LuGre by the effort limits.
  std::optional<friction::Friction> friction;
  PlantConfig plant;
  ControllerConfig controller;
  ExcitationConfig excitation;
  SensorsConfig sensors;
  DataConfig data;
  IdentifyConfig identify;
  std::vector<ModelConfig> models;
  EvaluateConfig evaluate;
  RenderConfig render;

  std::vector<std::string> joints;  ///< (n) of the robot, in the order of per-joint values
  SceneOrigin origin;

  bool simulates() const { return friction.has_value(); }

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name,
            text("name of the run; empty: that of the file; letters, digits, space, _ - . ( )"));
    archive("description", description, text("one line for reports"));
    archive("seed", seed, number("", 0, 9e15, "seed of every random draw"));
    archive.section("robot", robot, "the arm");
    archive.section("friction", friction, "what the simulator injects");
    archive.section("plant", plant, "the simulation");
    archive.section("controller", controller, "moves the simulated arm; unknown to the estimators");
    archive.section("excitation", excitation, "Fourier trajectories inside all limits");
    archive.section("sensors", sensors, "what the log sees of the truth");
    archive.section("data", data, "log files instead of a simulation");
    archive.section("identify", identify, "least squares on the rigid body, common to all models");
    archive.sections("model", models, "what is fitted");
    archive.section("evaluate", evaluate, "open loop on held-out data");
    archive.section("render", render, "the film of the run");
  }
};

/// Reads a scene, following `extends = "file"` or an array of files of which the last wins
/// (relative to the file that says it; tables merge, values and arrays replace). Reads the joints
/// of its URDF too: friction and per-joint values are by joint.
/// @throws UserError "file:line: ..." on anything wrong
Scene load_scene(const std::filesystem::path& path);

/// The scene as a file; loading it gives the same scene.
std::string to_toml(const Scene& scene);

/// A commented scene with every key, its unit, range and default.
std::string scene_template();

}  // namespace fricid::data
