// Errors of a rollout by horizon and of a friction torque by regime.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fricid/base/field.hpp"

#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/trajectory.hpp"

namespace fricid::evaluate {

/// Errors pooled over the samples of [start, start + h]: mean of e^2 (mse) and of |e| (mae), per
/// joint and averaged over joints. NaN where the rollout is shorter than the horizon. Samples whose
/// reference is missing are left out.
struct HorizonError {
  double q_mse, q_mae;                                                     ///< [rad^2], [rad]
  double v_mse, v_mae;                                                     ///< [rad^2/s^2], [rad/s]
  std::vector<double> q_mse_joint, q_mae_joint, v_mse_joint, v_mae_joint;  ///< (n)
};

/// The same, one value per horizon.
struct HorizonErrors {
  std::vector<double> q_mse, q_mae, v_mse, v_mae;
  std::vector<std::vector<double>> q_mse_joint, q_mae_joint, v_mse_joint, v_mae_joint;

  void add(HorizonError error);

  template <class Archive>
  void visit(Archive& archive) {
    const auto field = [](std::string_view unit, std::string_view meaning) {
      return not_negative(unit, meaning);
    };
    archive("q_mse", q_mse, field("rad^2", "per horizon, mean over joints and samples"));
    archive("q_mae", q_mae, field("rad", "per horizon, mean absolute error"));
    archive("v_mse", v_mse, field("rad^2/s^2", "per horizon"));
    archive("v_mae", v_mae, field("rad/s", "per horizon"));
    archive("q_mse_joint", q_mse_joint, field("rad^2", "per horizon and joint"));
    archive("q_mae_joint", q_mae_joint, field("rad", "per horizon and joint"));
    archive("v_mse_joint", v_mse_joint, field("rad^2/s^2", "per horizon and joint"));
    archive("v_mae_joint", v_mae_joint, field("rad/s", "per horizon and joint"));
  }
};

/// Errors of a rollout over its first `steps` samples after the start.
HorizonError horizon_error(const Rollout& rollout, const Trajectory& trajectory, int steps);

/// Mean over joints of |q - reference| per sample (T) [rad].
/// @param q          (T, n)
/// @param reference  (T or more rows, n)
Eigen::VectorXd mean_absolute_error(ConstRowMatrix q, ConstRowMatrix reference);

/// Root mean square error of a torque per joint [N m] by regime of the motion:
///
///     presliding   |v| < 0.05 rad/s, or less than 5 mrad of travel since the last reversal
///     reversal     less than 0.05 s from a change of sign of v
///     sliding      neither
///
/// Presliding and reversal overlap. NaN where a joint has no such sample. Of sliding joints [N],
/// 5 mm/s and 0.5 mm (`dynamics::travel_scale`).
struct RegimeError {
  std::vector<double> all, presliding, reversal, sliding;  ///< (n)

  /// @param key  of `all`; the others' are followed by _presliding, _reversal, _sliding
  template <class Archive>
  void visit(Archive& archive, const std::string& key) {
    const Field field = not_negative("N m", "per joint; empty: not known");
    archive(key, all, field);
    archive(key + "_presliding", presliding, field);
    archive(key + "_reversal", reversal, field);
    archive(key + "_sliding", sliding, field);
  }
};

/// @param error  (rows, n) [N m], row i at row begin + i of the motion; missing (NaN) left out
/// @param q, v   (T, n) motion that decides the regime [rad], [rad/s]
/// @param joints (n) turning or sliding
RegimeError regime_error(ConstRowMatrix error, ConstRowMatrix q, ConstRowMatrix v, double dt,
                         int begin, std::span<const dynamics::Joint> joints);

/// @param tau_f  torque to be scored (rows, n), row i at sample begin + i of the trajectory
/// @pre trajectory.truth holds tau_f
RegimeError friction_error(ConstRowMatrix tau_f, const Trajectory& trajectory, int begin,
                           std::span<const dynamics::Joint> joints);

/// Root mean square of the true friction torque per joint [N m], whole recording.
std::vector<double> friction_rms(const Trajectory& trajectory);

}  // namespace fricid::evaluate
