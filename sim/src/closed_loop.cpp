#include "fricid/sim/closed_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/sim/controller.hpp"
#include "fricid/sim/excitation.hpp"
#include "fricid/sim/plant.hpp"
#include "fricid/sim/sensors.hpp"
#include "fricid/sim/streams.hpp"
#include "fricid/system/driven_friction.hpp"
#include "run_in.hpp"

namespace fricid::sim {
namespace {

using Row = std::vector<double>;

// Seeds of paths and sequences of noise, apart from those of the recordings.
constexpr std::uint64_t kPathSeeds = std::uint64_t{1} << 40;
constexpr int kLoopSequences = 1 << 22;
constexpr double kLost = 1.0;  // [rad] error of an arm that is out of control

Eigen::Map<Eigen::VectorXd> vector_of(Row& row) { return {row.data(), std::ssize(row)}; }

/// The desired motion at times t [s], at rest from `end` on.
Motion desired(const Fourier& path, const Eigen::VectorXd& t, double end) {
  return TimeGrid(path.w, path.harmonics(), t.cwiseMin(end)).sample(path);
}

/// What the controller knows of the motion: encoder readings, and the difference of the last two.
class Encoders {
 public:
  Encoders(const SensorOptions& options, std::uint64_t seed, int number, const State& start)
      : options_(options), dt_(1 / options.rate_hz) {
    for (std::size_t j = 0; j < start.q.size(); ++j)
      noise_.push_back(
          make_rng(seed, Purpose::kEncoder, kLoopSequences + number, static_cast<int>(j)));
    q_ = read(start.q);
    v_ = start.v;
  }

  void look(const State& state) {
    Row now = read(state.q);
    for (std::size_t j = 0; j < now.size(); ++j) v_[j] = (now[j] - q_[j]) / dt_;
    q_ = std::move(now);
  }

  const Row& q() const { return q_; }
  const Row& v() const { return v_; }

 private:
  Row read(const Row& q) {
    Row readings;
    for (std::size_t j = 0; j < q.size(); ++j)
      readings.push_back(encoder_reading(options_, static_cast<int>(j), q[j], noise_[j]));
    return readings;
  }

  const SensorOptions& options_;
  double dt_;
  std::vector<Rng> noise_;
  Row q_, v_;
};

/// The fed forward friction, at the joints.
class Forward {
 public:
  Forward(const FeedForward& options, const dynamics::RobotModel& robot, double dt)
      : options_(options), motors_(robot), follower_(options.friction, dt) {}

  Row torque(const Row& q, const Row& v, const Row& load, const Row& temperature) {
    Row tau = follow(q, v, load, temperature);
    vector_of(tau) = options_.gain * (vector_of(tau) + options_.constant);
    return tau;
  }

 private:
  Row follow(const Row& q, const Row& v, const Row& load, const Row& temperature) {
    if (!motors_.coupled()) {
      const auto tau_f = follower_.follow(q, v, load, temperature);
      return {tau_f.begin(), tau_f.end()};
    }
    const auto row = [](const Row& x) {
      return Eigen::Map<const RowMatrix>(x.data(), 1, std::ssize(x));
    };
    const auto values = [](const RowMatrix& x) { return Row(x.data(), x.data() + x.size()); };
    const auto tau_f =
        follower_.follow(values(motors_.to_motors(row(q))), values(motors_.to_motors(row(v))),
                         values(motors_.torque_to_motors(row(load))), temperature);
    return values(motors_.torque_to_joints(row({tau_f.begin(), tau_f.end()})));
  }

  const FeedForward& options_;
  Transmission motors_;
  FrictionFollower follower_;
};

void saturate(const dynamics::RobotModel& robot, Row& tau) {
  for (std::size_t j = 0; j < tau.size(); ++j)
    if (const double effort = robot.joints[j].effort; effort > 0)
      tau[j] = std::clamp(tau[j], -effort, effort);
}

}  // namespace

Fourier random_path(const scene::Problem& problem, const MujocoArm& arm, int number, double size) {
  ExcitationOptions options = problem.scene.excitation;
  options.criterion = Criterion::kNone;
  options.train = 0;
  options.validation = 1;
  const std::uint64_t seed = problem.scene.seed + kPathSeeds + static_cast<std::uint64_t>(number);
  Fourier path = design_excitation(options, arm, problem.robot, seed, 1).validation.front();
  path.a *= size;
  path.b *= size;
  return path;
}

std::vector<Push> random_pushes(const scene::Problem& problem, int number, int count, int begin,
                                int end, double force_N, double push_s) {
  const int samples = static_cast<int>(std::lround(push_s * problem.scene.sensors.rate_hz));
  const int part = (end - begin) / count, n = problem.robot.n(), outer = n - n / 2;
  Rng rng = make_rng(problem.scene.seed, Purpose::kPush, number, 0);
  std::vector<Push> pushes;
  for (int i = 0; i < count; ++i) {
    Push push;
    // the rest of a part is quiet, so that the next push does not follow at once
    const double free = std::max(0, part - 2 * samples);
    push.begin = begin + i * part + samples / 2 + static_cast<int>(free * rng.uniform());
    push.end = push.begin + samples;
    push.joint = n / 2 + static_cast<int>(outer * rng.uniform());
    push.force = Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized() * force_N;
    pushes.push_back(push);
  }
  return pushes;
}

data::LoopSignals simulate_loop(const scene::Problem& problem, const MujocoArm& arm,
                                const LoopTask& task) {
  const dynamics::RobotModel& robot = problem.robot;
  const SensorOptions& sensors = problem.scene.sensors;
  const double dt = 1 / sensors.rate_hz;
  const int steps = steps_per_sample(dt, arm.step());
  const int run_in = static_cast<int>(std::lround(std::min(kRunIn, task.path.period()) / dt));
  const double path_s = task.periods * task.path.period();
  const int length = static_cast<int>(std::lround((path_s + task.rest_s) / dt));
  const int n = robot.n();

  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(run_in + length, -run_in, length - 1) * dt;
  const Motion motion = desired(task.path, t, path_s),
               ahead = desired(task.path, (t.array() + dt / 2).matrix(), path_s);

  Plant plant(arm, robot, *problem.scene.friction);
  Controller controller(task.controller, robot, dt);
  State state{Row(motion.q.col(0).begin(), motion.q.col(0).end()),
              Row(motion.v.col(0).begin(), motion.v.col(0).end()),
              Row(static_cast<std::size_t>(plant.state_size()), 0.0)};
  plant.set_state(state);
  Encoders encoders(sensors, problem.scene.seed, task.number, state);
  std::optional<Forward> forward;
  if (task.forward) forward.emplace(*task.forward, robot, dt);

  data::LoopSignals out;
  out.joint_names = robot.joint_names();
  out.t = t.tail(length);
  out.q_desired = motion.q.rightCols(length).transpose();
  out.v_desired = motion.v.rightCols(length).transpose();
  for (RowMatrix* signal :
       {&out.q, &out.v, &out.tau, &out.tau_feedback, &out.tau_forward, &out.tau_f, &out.q_measured})
    signal->setZero(length, n);
  if (!task.pushes.empty()) out.tau_ext.setZero(length, n);

  const auto joints = static_cast<std::size_t>(n);
  Row tau(joints, 0.0), ahead_q(joints), ahead_v(joints), fed(joints, 0.0);
  for (int k = 0; k < run_in + length; ++k) {
    if (k > 0) encoders.look(state);
    const Row temperature(joints, temperature_at(sensors, std::max(0.0, t[k])));
    if (forward) {
      const bool by_reference = task.forward->drive == Drive::kReference;
      vector_of(ahead_q) = ahead.q.col(k);
      vector_of(ahead_v) = ahead.v.col(k);
      fed = by_reference ? forward->torque(ahead_q, ahead_v, tau, temperature)
                         : forward->torque(encoders.q(), encoders.v(), tau, temperature);
    }
    controller.torque({motion.q.col(k), motion.v.col(k), motion.a.col(k)}, encoders.q(),
                      encoders.v(), tau);
    vector_of(tau) += vector_of(fed);
    saturate(robot, tau);
    const int row = k - run_in;
    for (const Push& push : task.pushes) {
      if (row == push.end) plant.push(push.joint, Eigen::Vector3d::Zero());
      if (row == push.begin) plant.push(push.joint, push.force);
    }
    plant.hold(tau, temperature, steps);
    if (row >= 0) {
      const auto put = [&](RowMatrix& signal, std::span<const double> values) {
        std::copy(values.begin(), values.end(), signal.row(row).data());
      };
      put(out.q, state.q);
      put(out.v, state.v);
      put(out.tau, tau);
      put(out.tau_feedback, controller.feedback());
      put(out.tau_forward, fed);
      put(out.tau_f, plant.tau_f());
      put(out.q_measured, encoders.q());
      if (!task.pushes.empty()) out.tau_ext.row(row) = plant.pushed_torque();
    }
    state = plant.state();
    const double error = (vector_of(state.q) - motion.q.col(k)).cwiseAbs().maxCoeff();
    if (!(error < kLost)) {
      out.keep(std::max(0, row + 1));
      break;
    }
  }
  return out;
}

data::Dataset log_of(const data::LoopSignals& loop, const scene::Problem& problem, int number) {
  data::Dataset log;
  log.joint_names = loop.joint_names;
  log.rate_hz = problem.scene.sensors.rate_hz;
  log.t = loop.t;
  log.q = loop.q_measured;
  log.tau = measured_torque(loop.tau, problem.scene.sensors, problem.robot, problem.scene.seed,
                            kLoopSequences + number);
  return log;
}

}  // namespace fricid::sim
