// Torque error of a model: a random torque that causes an open-loop error of the same size.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/options.hpp"
#include "fricid/evaluate/trajectory.hpp"

namespace fricid::evaluate {

/// Independent stationary Ornstein-Uhlenbeck torques, one per joint, held over each sample:
///
///     e_0 ~ N(0, sd^2),   e_{k+1} = rho e_k + sqrt(1 - rho^2) N(0, sd^2),   rho = exp(-dt/time),
///
/// applied to a joint by disturbance_at, larger at low speed, where friction models err most.
struct TorqueError {
  double time = 0;         ///< correlation time [s]; 0: white from sample to sample
  std::vector<double> sd;  ///< (n) of a joint in motion [N m]
  double slow_gain = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("time_s", time, number("s", 0, 1e3, "correlation time"));
    archive("sd", sd, not_negative("N m", "per joint, standard deviation in motion"));
    archive("slow_gain", slow_gain, number("1", 0, 1e3, "factor on sd at rest"));
  }
};

/// A realisation (rows, n) [N m]: numbers 0 .. rows n - 1 of the random stream, whatever the
/// threads.
RowMatrix draw_torque_error(const TorqueError& error, double dt, int rows, std::uint64_t seed,
                            std::uint64_t stream);

/// Recordings, or parts of them, and an arm that was not fitted to them.
struct LeftOut {
  std::vector<Trajectory> recordings;
  Arm arm;
};

/// A torque error and how rollouts under it may be stepped.
struct FittedTorqueError {
  TorqueError error;
  /// longest leap, see StepOptions, that moves the model's rollouts by less than a tenth of their
  /// own error in mean square, at every joint and horizon
  int leap = 1;
};

/// The torque error of a model, from open loops on motion that it was not fitted to. With
///
///     m_jh  mean square error of q_j over the first h seconds of rollouts,
///     S_jh  mean square of what a torque error moves q_j by in the same rollouts,
///
/// of fits that left the recordings out in turn (`left_out`) or, without any, of the model on the
/// recordings that it was fitted to (`training`),
/// over the starts and horizons of `options`, rollouts from the first sample apart from later ones
/// (h runs over both), the standard deviations make the geometric means of m_jh and S_jh over h
/// equal, joint by joint, by a fixed-point iteration
///
///     sd_j^2 <- sd_j^2 exp(mean over h of log(m_jh / S_jh)),
///
/// and of kTimes the correlation time is taken, the first from which a longer one does not lessen
/// the spread over h of log(m_jh / S_jh), its squared deviations from the mean summed over joints
/// and h. Rollouts that S compares are stepped by leaps. It covers all causes of open-loop error:
/// friction, rigid body, initial state, noise of the measured torque.
/// @param known  the robot before identification, see constant_friction
/// @return sd between 1e-6 and 1 of the rms torque; the same for any `jobs`
FittedTorqueError fit_torque_error(const data::ModelFile& model, const dynamics::RobotModel& known,
                                   std::span<const Trajectory> training,
                                   std::span<const LeftOut> left_out,
                                   const EvaluateOptions& options, int jobs);
inline constexpr double kSlowGain = 3;
inline constexpr double kTimes[] = {0, 0.03, 0.1, 0.3, 1};  // [s]

}  // namespace fricid::evaluate
