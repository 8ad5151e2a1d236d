// Small recordings and contests for the tests of evaluate.
#pragma once

#include <string>
#include <vector>

#include "flywheel.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/evaluate/evaluate.hpp"
#include "kr6_truth.hpp"

namespace fricid::test {

inline constexpr int kSubsteps = 4;

/// A recording as a trajectory: torque with white noise of the given share of its RMS, motion
/// filtered without error.
inline evaluate::Trajectory as_trajectory(const Recording& recording, const std::string& name,
                                          double noise = 0, std::uint64_t seed = 1) {
  evaluate::Trajectory trajectory;
  data::Dataset& data = trajectory.data;
  const Eigen::Index T = recording.q.rows(), n = recording.q.cols();
  data.name = name;
  for (Eigen::Index j = 0; j < n; ++j) data.joint_names.push_back("joint_" + std::to_string(j + 1));
  data.rate_hz = 1 / kSamplePeriod;
  data.t = Eigen::VectorXd::LinSpaced(T, 0, static_cast<double>(T - 1) * kSamplePeriod);
  data.q = recording.q;
  data.tau = recording.tau;
  Rng rng(seed, 99);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double rms = recording.tau.col(j).norm() / std::sqrt(static_cast<double>(T));
    for (Eigen::Index k = 0; k < T; ++k) data.tau(k, j) += noise * rms * rng.normal();
  }
  trajectory.q = recording.q;
  trajectory.v = recording.v;
  trajectory.truth = evaluate::Reference{recording.q, recording.v, recording.tau_f, recording.z};
  return trajectory;
}

inline data::ModelFile model_file(const std::string& name, Arm arm, bool is_oracle = false) {
  data::ModelFile model;
  model.name = name;
  model.label = name;
  model.free_parameters = static_cast<int>(arm.friction.theta.size());
  model.arm = std::move(arm);
  model.is_oracle = is_oracle;
  return model;
}

/// KR6 with LuGre friction: the truth, a LuGre model whose bristles are 30 % too stiff and a
/// Coulomb model.
inline evaluate::Contest small_contest(int T = 700, double noise = 0.002) {
  const Arm truth{hanging_kr6(), kr6_friction("lugre")};
  evaluate::Contest contest;
  contest.scene = "small";
  contest.robot = truth.robot;
  for (int i = 0; i < 2; ++i)
    contest.trajectories.push_back(as_trajectory(
        record(truth, HangingMotion(static_cast<std::uint64_t>(10 + i)), T, {kSubsteps}),
        "validation_" + std::to_string(i), noise, static_cast<std::uint64_t>(i)));
  Arm near = truth;
  for (std::size_t i = 0; i < near.friction.theta.size(); ++i)
    if (near.friction.model.parameters()[i].symbol == "sigma0") near.friction.theta[i] *= 1.3;
  contest.models = {model_file("oracle", truth, true),
                    model_file("simple", {truth.robot, kr6_friction("coulomb_viscous")}),
                    model_file("lugre", near)};
  return contest;
}

inline evaluate::EvaluateOptions small_options() {
  evaluate::EvaluateOptions options;
  options.horizons_s = {0.1, 1, 0};
  options.starts = 3;
  options.substeps = kSubsteps;
  options.min_headroom = 10;
  return options;
}

}  // namespace fricid::test
