// Options of the simulation, section by section.
#pragma once

#include <string_view>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"

namespace fricid::sim {

/// [plant]: the ground-truth simulation.
struct PlantOptions {
  double step_s = 0.0005;

  template <class Archive>
  void visit(Archive& archive) {
    archive("step_s", step_s, number("s", 1e-6, 0.1, "physics step; divides the sample period"));
  }
};

/// Controller of the simulated arm, see sim::Controller.
enum class ControlLaw {
  kPdGravity,       ///< stiffness, damping and gravity
  kComputedTorque,  ///< ... and the inertial torque of the desired acceleration
  kCascade          ///< position loop, velocity loop with integral, imperfect gravity model
};
constexpr std::string_view names(ControlLaw) { return "pd_gravity|computed_torque|cascade"; }

/// [controller]: not known to the estimators.
struct ControllerOptions {
  ControlLaw kind = ControlLaw::kPdGravity;
  double bandwidth_hz = 8;
  double damping = 0.9;
  double integral_s = 0.3;
  double model_error = 0.1;

  template <class Archive>
  void visit(Archive& archive) {
    archive("kind", kind, choice("law; cascade has an integral and an imperfect gravity model"));
    archive("bandwidth_hz", bandwidth_hz,
            number("Hz", 0.01, 1000, "closed-loop position bandwidth"));
    archive("damping", damping, number("1", 0.01, 10, "damping ratio"));
    archive("integral_s", integral_s, number("s", 1e-3, 1e6, "cascade: reset time"));
    archive("model_error", model_error,
            number("1", 0, 1, "cascade: relative error of its gravity model"));
  }
};

/// Criterion of the trajectory design, minimised.
enum class Criterion {
  kDOptimal,   ///< - log det of the information of the base parameters
  kCondition,  ///< its condition number
  kNone        ///< no optimisation: the first random draw, scaled to the limits
};
constexpr std::string_view names(Criterion) { return "d_optimal|condition|none"; }

/// [excitation]: Fourier series per joint.
struct ExcitationOptions {
  int harmonics = 20;
  double base_rad_s = 0.2;
  double spectrum = 0.5;
  int train = 3;
  int repeats = 2;
  int validation = 3;
  Criterion criterion = Criterion::kDOptimal;
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
    archive("harmonics", harmonics,
            number("", 2, 200, "terms of the Fourier series; one alone does not begin at rest"));
    archive("base_rad_s", base_rad_s,
            number("rad/s", 1e-3, 100, "base frequency w; the period is 2 pi / w"));
    archive("spectrum", spectrum,
            number("1", -4, 4, "velocity amplitudes of the random start rise as k^spectrum"));
    archive("train", train, number("", 1, 1000, "distinct training trajectories"));
    archive(
        "repeats", repeats,
        number("", 1, 100, "periods of each training trajectory, logged as separate sequences"));
    archive("validation", validation, number("", 0, 1000, "distinct validation trajectories"));
    archive("criterion", criterion, choice("criterion of the optimiser on the base regressor"));
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
struct SensorOptions {
  double rate_hz = 250;
  std::vector<double> encoder_noise_rad;  ///< (n) or empty
  std::vector<double> encoder_step_rad;   ///< (n) or empty
  double torque_noise = 0.001;
  double torque_step = 0.0005;
  std::vector<double> torque_gain;  ///< (n) or empty
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
    archive(
        "torque_gain", torque_gain,
        per_joint("1", 0.1, 10, "logged over true torque, an error of the torque constant; []: 1"));
    archive("torque_delay_samples", torque_delay_samples,
            number("", 0, 1000, "samples that the logged torque lags behind"));
    archive("dropped", dropped, number("1", 0, 0.5, "share of samples replaced by the one before"));
    archive("velocity", velocity, flag("log a measured velocity too"));
    archive("temperature", temperature, flag("log the temperature"));
    archive("temperature_start_K", temperature_start_K,
            number("K", 200, 500, "temperature at the start of the first recording"));
    archive("temperature_rise_K", temperature_rise_K,
            number("K", -200, 200,
                   "warm-up over all recordings, one behind the other: rise (1 - exp(-t / time))"));
    archive("temperature_time_s", temperature_time_s,
            number("s", 1e-3, 1e6, "time constant of the warm-up"));
  }
};

/// Motion that drives the friction which is fed forward.
enum class Drive { kReference, kMeasured };
constexpr std::string_view names(Drive) { return "reference|measured"; }

/// [compensation]: the simulated arm under its controller, with the friction of each model fed
/// forward.
struct CompensationOptions {
  std::vector<double> gains;
  Drive drive = Drive::kReference;
  std::vector<double> bandwidths_hz{2, 8};
  std::vector<double> sizes{0.1, 1};
  double rest_s = 3;

  bool wanted() const { return !gains.empty(); }

  template <class Archive>
  void visit(Archive& archive) {
    archive("gains", gains,
            number("1", 0, 10, "factors on the friction that is fed forward; []: no closed loop"));
    archive("drive", drive, choice("motion that drives the states of the friction"));
    archive("bandwidths_hz", bandwidths_hz,
            number("Hz", 0.01, 1000, "of the controller, in place of its own"));
    archive("sizes", sizes,
            number("1", 1e-3, 1,
                   "of the paths: a random motion within the limits, scaled about its centre; a "
                   "small one is slow"));
    archive("rest_s", rest_s,
            number("s", 1, 1000, "standstill after a path, in which limit cycles are looked for"));
  }
};

/// [contact]: pushes on the simulated arm, found by an observer with the friction of each model.
struct ContactOptions {
  double hours = 0;
  std::vector<double> forces_N{20, 50};
  int pushes = 60;
  double push_s = 0.25;
  double size = 1;
  double bandwidth_hz = 10;
  int particles = 0;

  bool wanted() const { return hours > 0; }

  template <class Archive>
  void visit(Archive& archive) {
    archive("hours", hours,
            number("h", 0, 1000,
                   "of motion without contact, for the threshold of one false alarm per hour; 0: "
                   "no contact is simulated"));
    archive("forces_N", forces_N, number("N", 1e-3, 1e5, "of the pushes"));
    archive("pushes", pushes, number("", 1, 1e5, "number of pushes of each force"));
    archive("push_s", push_s, number("s", 0.01, 10, "length of a push"));
    archive("size", size,
            number("1", 1e-3, 1,
                   "of the paths: random motions within the limits, scaled about their centre"));
    archive("bandwidth_hz", bandwidth_hz, number("Hz", 0.1, 1000, "of the momentum observer"));
    archive(
        "particles", particles,
        number("", 0, 1e6,
               "also by the observer with friction states that so many particles filter; 0: no"));
  }
};

}  // namespace fricid::sim
