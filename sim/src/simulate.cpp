#include "fricid/sim/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "fricid/sim/controller.hpp"
#include "fricid/sim/sensors.hpp"
#include "fricid/sim/simulation_size.hpp"
#include "run_in.hpp"

namespace fricid::sim {
namespace {

// A sequence to simulate: one period of a series.
struct Task {
  std::string name;
  const Fourier* series;
  int number;  // within the run
};

void fill_temperature(const SensorOptions& config, double time, std::vector<double>& temperature) {
  std::fill(temperature.begin(), temperature.end(), temperature_at(config, time));
}

// Controls the arm along `series` from `run_in` seconds before its start; logs one period.
Trace follow(const scene::Problem& problem, const MujocoArm& arm, const Fourier& series,
             double start_time) {
  const dynamics::RobotModel& robot = problem.robot;
  const double dt = 1 / problem.scene.sensors.rate_hz;
  const int steps = steps_per_sample(dt, arm.step());
  const int length = static_cast<int>(std::lround(series.period() / dt));
  const int run_in = static_cast<int>(std::lround(std::min(kRunIn, series.period()) / dt));

  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(run_in + length, -run_in, length - 1) * dt;
  const Motion motion = TimeGrid(series.w, series.harmonics(), t).sample(series);
  Plant plant(arm, robot, *problem.scene.friction);
  Controller controller(problem.scene.controller, robot, dt);
  Trace trace = make_trace(length, dt, robot.n(), plant.state_size());

  const auto n = static_cast<std::size_t>(robot.n());
  State state{std::vector<double>(motion.q.col(0).begin(), motion.q.col(0).end()),
              std::vector<double>(motion.v.col(0).begin(), motion.v.col(0).end()),
              std::vector<double>(static_cast<std::size_t>(plant.state_size()), 0.0)};
  plant.set_state(state);
  std::vector<double> tau(n), temperature(n);
  for (int k = 0; k < run_in + length; ++k) {
    controller.torque({motion.q.col(k), motion.v.col(k), motion.a.col(k)}, state.q, state.v, tau);
    fill_temperature(problem.scene.sensors, start_time + std::max(0.0, t[k]), temperature);
    plant.hold(tau, temperature, steps);
    if (k >= run_in) record(plant, state, tau, temperature, k - run_in, trace);
    state = plant.state();
  }
  return trace;
}

Payload payload_of(const scene::Problem& problem) {
  const scene::RobotSection& robot = problem.scene.robot;
  if (robot.payload_kg <= 0) return {};
  const auto& frames = problem.robot.frames;
  const auto frame = std::find_if(frames.begin(), frames.end(), [&](const dynamics::Frame& f) {
    return f.name == robot.payload_frame;
  });
  if (frame == frames.end())
    throw UserError("{}: payload_frame = \"{}\" is no frame of {}", problem.scene.name,
                    robot.payload_frame, problem.robot.name);
  const std::array<double, 6>& I = robot.payload_inertia;
  Payload payload{*frame, robot.payload_kg, Eigen::Vector3d(robot.payload_com.data()), {}};
  payload.inertia << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
  return payload;
}

/// Largest eigenvalue of M(q)^-1 diag(M(q)) along a motion: by so much more than one joint alone an
/// arm answers to gains in proportion to the joints' own inertias.
double strongest_answer(const dynamics::RobotModel& robot, const RowMatrix& q) {
  constexpr Eigen::Index kPoses = 50;
  const auto n = static_cast<std::size_t>(robot.n());
  const std::span<const double> pi{robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd M(robot.n(), robot.n());
  double strongest = 1;
  for (Eigen::Index k = 0; k < q.rows(); k += std::max<Eigen::Index>(1, q.rows() / kPoses)) {
    if (!q.row(k).allFinite()) continue;
    dynamics::crba<double>(robot, ws, pi, {q.row(k).data(), n}, {M.data(), n * n});
    const Eigen::VectorXd root = M.diagonal().cwiseSqrt();
    // the same eigenvalues as those of the inverse of D^-1/2 M D^-1/2
    const Eigen::MatrixXd scaled =
        root.cwiseInverse().asDiagonal() * M * root.cwiseInverse().asDiagonal();
    const double least =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
            .eigenvalues()[0];
    if (least > 0) strongest = std::max(strongest, 1 / least);
  }
  return strongest;
}

/// A velocity gain of 2 zeta w takes out more than the velocity between two samples when
/// 2 zeta w dt > 1, and the loop overshoots in every one; that of one joint moves the others too.
void check_controller(const scene::Problem& problem, const RowMatrix& q, const std::string& found) {
  const ControllerOptions& controller = problem.scene.controller;
  const dynamics::RobotModel& robot = problem.robot;
  const double rate = problem.scene.sensors.rate_hz;
  const double answer =
      controller.kind == ControlLaw::kComputedTorque ? 1 : strongest_answer(robot, q);
  const double fastest = rate / (4 * std::numbers::pi * controller.damping * answer);
  if (controller.bandwidth_hz <= fastest) return;
  const bool lacks_rotors =
      (robot.pi.segment(robot.armature_begin(), robot.n()).array() == 0).any();
  throw UserError(
      "{}; a controller of {} Hz that acts {} times a second overshoots at every sample: lower "
      "controller.bandwidth_hz below {:.2g}{} raise sensors.rate_hz",
      found, controller.bandwidth_hz, rate, fastest,
      lacks_rotors ? ", state armatures (robot.guess_armature = true), or" : ", or");
}

void check_finite(const scene::Problem& problem, const Trace& trace, const std::string& name) {
  if (trace.q.allFinite() && trace.v.allFinite() && trace.z.allFinite()) return;
  check_controller(problem, trace.q,
                   fmt::format("{}: {}: the simulated arm diverged", problem.scene.name, name));
  const dynamics::RobotModel& robot = problem.robot;
  for (int j = 0; j < robot.n(); ++j)
    if (const std::string& joint = robot.joints[static_cast<std::size_t>(j)].name;
        robot.pi[robot.armature_begin() + j] == 0)
      throw UserError(
          "{}: {}: the simulated arm diverged; {} has no armature, the inertia of its rotor: state "
          "robot.armature = {{{} = {:.2g}}} in the scene (usual for its limits), or "
          "robot.guess_armature = true for all joints without",
          problem.scene.name, name, joint, joint, dynamics::usual_armature(robot)[j]);
  throw UserError(
      "{}: {}: the simulated arm diverged; shorten plant.step_s = {} s, lower the stiffness of "
      "the friction, or look for a wrong mass, inertia or gain",
      problem.scene.name, name, problem.scene.plant.step_s);
}

// Friction that reverses a light joint within a step makes it chatter: then neither the motion nor
// the friction torque is that of the law.
void check_chatter(const scene::Problem& problem, const Trace& trace, const Fourier& series,
                   const std::string& name) {
  constexpr double kVisible = 2e-3;          // [rad/s]
  constexpr double kMost = 30, kTimes = 10;  // reversals per second; times those of the reference
  const double seconds = static_cast<double>(trace.t.size()) / problem.scene.sensors.rate_hz;
  const double designed = series.harmonics() * series.w / std::numbers::pi;
  const dynamics::RobotModel& robot = problem.robot;
  for (int j = 0; j < robot.n(); ++j) {
    int turns = 0;
    for (Eigen::Index k = 1; k < trace.v.rows(); ++k) {
      const double before = trace.v(k - 1, j), after = trace.v(k, j);
      turns += before * after < 0 && std::min(std::abs(before), std::abs(after)) > kVisible;
    }
    if (turns / seconds < std::max(kMost, kTimes * designed)) continue;
    const std::string& joint = robot.joints[static_cast<std::size_t>(j)].name;
    const std::string found =
        fmt::format("{}: {}: the simulated {} chatters: it reverses {:.0f} times a second",
                    problem.scene.name, name, joint, turns / seconds);
    check_controller(problem, trace.q, found);
    const double armature = robot.pi[robot.armature_begin() + j];
    throw UserError(
        "{} under friction of {:.3g} N m with an armature of {:.2g} kg m^2; give it a larger one, "
        "robot.armature = {{{} = {:.2g}}} in the scene or in the URDF, or shorten plant.step_s = "
        "{} s",
        found, trace.tau_f.col(j).cwiseAbs().maxCoeff(), armature, joint,
        std::max(2 * armature, dynamics::usual_armature(robot)[j]), problem.scene.plant.step_s);
  }
}

}  // namespace

MujocoArm make_arm(const scene::Problem& problem) {
  return make_arm(problem, problem.scene.plant.step_s);
}

MujocoArm make_arm(const scene::Problem& problem, double step) {
  if (problem.mjcf_path.empty() && !problem.scene.simulates())
    throw UserError("{}: [robot] mjcf is missing; pictures of a logged robot need its shape",
                    problem.scene.name);
  return MujocoArm(problem.mjcf_path, problem.robot, step, payload_of(problem));
}

SimulationSize size_of_simulation(const scene::Problem& problem) {
  const scene::Scene& scene = problem.scene;
  SimulationSize size;
  size.training = static_cast<double>(scene.excitation.train) * scene.excitation.repeats;
  size.recordings = size.training + scene.excitation.validation;
  size.samples = 2 * std::numbers::pi / scene.excitation.base_rad_s * scene.sensors.rate_hz;
  // values per sample: the truth's t, q, v, a, tau, tau_f, temperature and z; the log's t, q, v,
  // tau and temperature; the desired motion
  const int numbers =
      2 + 13 * problem.robot.n() + (scene.friction ? scene.friction->model.state_size() : 0);
  size.bytes = sizeof(double) * size.recordings * size.samples * numbers;
  return size;
}

void require_memory_of_simulation(const scene::Problem& problem) {
  const SimulationSize size = size_of_simulation(problem);
  require_memory(
      size.bytes, problem.scene.name,
      fmt::format("simulating {} recordings of {:.0f} samples", size.recordings, size.samples));
}

Simulation simulate(const scene::Problem& problem, int jobs) {
  if (!problem.scene.simulates())
    throw UserError("{}: [friction] is missing, a simulation needs it", problem.scene.name);
  require_memory_of_simulation(problem);
  const MujocoArm arm = make_arm(problem);
  steps_per_sample(1 / problem.scene.sensors.rate_hz, arm.step());

  Simulation result;
  result.excitation =
      design_excitation(problem.scene.excitation, arm, problem.robot, problem.scene.seed, jobs);

  std::vector<Task> tasks;
  const auto add = [&](const std::string& kind, int index, const Fourier& series) {
    tasks.push_back({fmt::format("{}_{}", kind, index), &series, static_cast<int>(tasks.size())});
  };
  const int repeats = problem.scene.excitation.repeats;
  const int train = static_cast<int>(result.excitation.train.size()) * repeats;
  for (int i = 0; i < train; ++i)
    add("train", i, result.excitation.train[static_cast<std::size_t>(i / repeats)]);
  for (std::size_t i = 0; i < result.excitation.validation.size(); ++i)
    add("validation", static_cast<int>(i), result.excitation.validation[i]);

  std::vector<data::Dataset> datasets(tasks.size());
  std::vector<Truth> truths(tasks.size());
  Progress progress("simulate", static_cast<double>(tasks.size()));
  parallel_for(static_cast<int>(tasks.size()), jobs, [&](int i) {
    throw_if_stopped();
    const auto index = static_cast<std::size_t>(i);
    const Task& task = tasks[index];
    Truth& truth = truths[index];
    truth.name = task.name;
    truth.rate_hz = problem.scene.sensors.rate_hz;
    truth.friction = *problem.scene.friction;
    truth.joint_names = problem.robot.joint_names();
    truth.trace = follow(problem, arm, *task.series, task.number * task.series->period());
    check_finite(problem, truth.trace, task.name);
    check_chatter(problem, truth.trace, *task.series, task.name);

    data::Dataset& dataset = datasets[index];
    dataset =
        measure(truth.trace, problem.scene.sensors, problem.robot, problem.scene.seed, task.number);
    dataset.name = task.name;
    dataset.source = fmt::format("simulation {} seed {}", problem.scene.name, problem.scene.seed);
    progress.advance(1);
  });

  const auto move_range = [train](auto& from, auto& first, auto& second) {
    first.assign(std::make_move_iterator(from.begin()),
                 std::make_move_iterator(from.begin() + train));
    second.assign(std::make_move_iterator(from.begin() + train),
                  std::make_move_iterator(from.end()));
  };
  move_range(datasets, result.train, result.validation);
  move_range(truths, result.train_truth, result.validation_truth);
  return result;
}

Trace oracle_rollout(const scene::Problem& problem, const MujocoArm& arm, const Truth& truth,
                     const data::Dataset& dataset, int start, int length) {
  Plant plant(arm, problem.robot, truth.friction);
  return rollout(plant, truth.trace.state(start), dataset.tau.middleRows(start, length),
                 truth.trace.temperature.middleRows(start, length), truth.dt());
}

}  // namespace fricid::sim
