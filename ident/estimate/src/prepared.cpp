#include "fricid/estimate/prepared.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/data/training_part.hpp"
#include "fricid/signals/filter.hpp"
#include "fricid/signals/periods.hpp"
#include "fricid/system/transmission.hpp"
#include "rigid_body/contradictions.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/regression_start.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kSmoothing = 0.01;  // [rad/s]
constexpr double kNoisySpeed = 3;    // standard deviations

// Rates that differ by less are one: clocks do, and a speed is then off by as much.
constexpr double kOneRate = 1e-3;

// What brings two recordings to one rate.
std::string to_one_rate(const data::Dataset& a, const data::Dataset& b) {
  constexpr double kAlike = 0.01;
  const bool a_is_faster = a.rate_hz > b.rate_hz;
  const data::Dataset& faster = a_is_faster ? a : b;
  const double ratio = faster.rate_hz / (a_is_faster ? b : a).rate_hz;
  if (ratio < 1 + kAlike)
    return fmt::format("if both were sampled alike, give both even times of {:.5g} Hz",
                       std::round(a.rate_hz));
  const double whole = std::round(ratio);
  if (std::abs(ratio - whole) < kAlike * whole)
    return fmt::format("filter {} and keep one row in {:g}, or fit it in a scene of its own",
                       faster.name, whole);
  return "resample one of them, or fit each in a scene of its own";
}

// Rests of a joint tell nothing of its friction where the noise of its encoder (one standard
// deviation) or a step is worth this share of it: then its torque wanders while nothing is seen to
// move.
constexpr double kUnseen = 1.0 / 60;
constexpr double kRestingShare = 0.02;  // of the rows, that matters

/// Rows at rest go in joints whose bristles are too stiff for the encoder, by the stiffness of a
/// Dahl law fitted to the others.
void leave_out_rests(Prepared& prepared, int jobs) {
  if (prepared.rigid_body.Fc.size() != prepared.robot.n()) return;  // nothing moves
  const double cutoff = prepared.options.cutoff_hz;
  std::vector<signals::Recording> moving = prepared.recordings;
  Eigen::ArrayXd used = Eigen::ArrayXd::Zero(prepared.robot.n()), left = used, noise = used;
  for (signals::Recording& r : moving) {
    used += r.use.cast<double>().colwise().sum().transpose();
    r.use = r.use && !signals::at_rest(r, cutoff);
    left += r.use.cast<double>().colwise().sum().transpose();
    noise = noise.max(r.noise_sd.cwiseMax(r.step).array());
  }
  if ((left > (1 - kRestingShare) * used).all()) return;
  const friction::RobotFriction one({friction::JointSpec{{{"dahl", 0, {}}}}});
  const FrictionTorques target =
      friction_target(prepared.robot, prepared.rigid_body.pi, prepared.recordings, jobs);
  parallel_for(prepared.robot.n(), jobs, [&](int j) {
    if (left[j] > (1 - kRestingShare) * used[j]) return;
    const JointFrictionData data(moving, target, j, cutoff, offset_prior(prepared.rigid_body, j));
    if (data.rows() == 0) return;
    const std::vector<double> start =
        friction::start_from(one, guess_of(prepared.rigid_body, data, j));
    const std::vector<double> theta = fit_joint_friction(data, one, start, {}).theta;
    const auto value = [&](friction::Role role) {
      return theta[static_cast<std::size_t>(friction::find_parameter(one, 0, role))];
    };
    if (value(friction::Role::kStiffness) * noise[j] < kUnseen * value(friction::Role::kCoulomb))
      return;
    for (std::size_t s = 0; s < moving.size(); ++s)
      prepared.recordings[s].use.col(j) = moving[s].use.col(j);
  });
}

}  // namespace

std::vector<signals::Recording> recordings_of(const dynamics::RobotModel& robot,
                                              std::span<const data::Dataset> logs, double cutoff_hz,
                                              int jobs) {
  const Transmission motors(robot);
  std::vector<signals::Recording> recordings(logs.size());
  parallel_for(static_cast<int>(logs.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    recordings[s] = signals::make_recording(motors.to_motors(logs[s]), cutoff_hz);
  });
  signals::mark_repeats(recordings, jobs);
  return recordings;
}

Prepared prepare(const dynamics::RobotModel& robot, const RigidBodyOptions& options,
                 std::span<const data::Dataset> train, int jobs) {
  if (train.empty()) throw UserError("no training data");
  for (const data::Dataset& d : train) {
    if (d.n() != robot.n())
      throw UserError("{}: {} joints, the robot has {}", d.name, d.n(), robot.n());
    if (std::abs(d.rate_hz / train.front().rate_hz - 1) > kOneRate)
      throw UserError("{}: {:.7g} Hz, and {} {:.7g} Hz; allowed: one rate in a scene: {}", d.name,
                      d.rate_hz, train.front().name, train.front().rate_hz,
                      to_one_rate(d, train.front()));
  }
  Prepared out;
  const data::TrainingPart part = data::training_part(train);
  if (!part.is_all())
    out.fitted_to = {part.seconds, part.of_seconds, static_cast<int>(part.recordings.size())};
  out.recordings = recordings_of(robot, part.recordings, options.cutoff_hz, jobs);
  RegressionStart start = start_of_regression(robot, options);
  out.robot = std::move(start.robot);
  out.options = std::move(start.options);
  out.rigid_body = rigid_body_least_squares(out.robot, out.recordings, out.options);
  out.contradictions = find_contradictions(out.robot, out.recordings, out.options, out.rigid_body);
  for (const JointInertia& found : out.rigid_body.without_inertia) {
    const int k = out.robot.armature_begin() + found.joint;
    out.robot.pi[k] = out.rigid_body.pi[k];  // held there in further fits too
  }
  leave_out_rests(out, jobs);
  out.under_load = rigid_body_under_load(out.robot, out.recordings, out.options, out.rigid_body);
  if (out.under_load) {
    widen_errors(*out.under_load, out.rigid_body);
    out.rigid_body.lacks_growth = true;
  }
  if (out.rigid_body.Fc.size() != robot.n())
    throw UserError("{}: {}", robot.name, out.rigid_body.message);
  return out;
}

double smoothing_speed(const dynamics::RobotModel& robot,
                       std::span<const signals::Recording> recordings, double cutoff_hz,
                       int joint) {
  constexpr int kFrequencies = 1000;  // of the sum over the band
  double noise = 0;
  for (const signals::Recording& r : recordings) {
    // white noise of the position through the wide band and the central difference
    const double rate = 1 / r.dt;
    const signals::ZeroPhaseButterworth low_pass(signals::wide_band(cutoff_hz, rate), rate);
    double variance = 0;
    for (int i = 0; i < kFrequencies; ++i) {
      const double f = (i + 0.5) / kFrequencies * rate / 2;
      const double slope = low_pass.gain(f) * std::sin(2 * std::numbers::pi * f * r.dt) / r.dt;
      variance += slope * slope / kFrequencies;
    }
    noise = std::max(noise, r.noise_sd[joint] * std::sqrt(variance));
  }
  const dynamics::Joint& of = robot.joints[static_cast<std::size_t>(joint)];
  return std::max(kSmoothing * dynamics::travel_scale(of), kNoisySpeed * noise);
}

std::vector<double> torque_rms(std::span<const signals::Recording> recordings) {
  const int n = recordings.front().n();
  std::vector<double> rms(static_cast<std::size_t>(n));
  for (int j = 0; j < n; ++j) {
    double sum = 0, rows = 0;
    for (const signals::Recording& r : recordings) {
      sum += r.held_tau.col(j).squaredNorm();
      rows += static_cast<double>(r.held_tau.rows());
    }
    rms[static_cast<std::size_t>(j)] = std::sqrt(sum / rows);
  }
  return rms;
}

}  // namespace fricid::estimate
