// Prediction of the motor torque from measured motion (inverse dynamics).
#pragma once

#include <filesystem>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/evaluate/metrics.hpp"
#include "fricid/system/arm.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::evaluate {

inline constexpr int kDriftBlocks = 20;  ///< of a recording, whose means show drift

/// Predicted motor torque and its error e per joint, over the samples with a measured torque.
struct TorquePrediction {
  RowMatrix tau;                       ///< (T, n) predicted [N m]
  RowMatrix tau_f;                     ///< (T, n) friction in it, its constant part too [N m]
  RegimeError rmse;                    ///< (n) [N m], by regime of the measured motion
  std::vector<double> percent_of_rms;  ///< (n) 100 rmse / rms of the measured torque
  std::vector<double> r2;              ///< (n) 1 - sum e^2 / sum (tau - mean tau)^2
  /// (n) RMSE of the one-step-ahead prediction, which also knows the error of the last sample:
  /// e_k - rho e_{k-1}, rho the lag-one autocorrelation of e over the recording [N m]. A value far
  /// below rmse means correlated residuals: the model lacks a slow effect.
  std::vector<double> one_step;
  /// (n) Rise from begin to end of the recording of the straight line through the means of measured
  /// - predicted over its twentieths, and the standard error of that from their scatter, which a
  /// slow residual does not make too small [N m]. NaN where a twentieth holds no sample.
  std::vector<double> drift, drift_error;

  /// The scores; the torques are files of their own.
  template <class Archive>
  void visit(Archive& archive) {
    const auto field = [](std::string_view unit, std::string_view meaning) {
      return any_number(unit, meaning);
    };
    rmse.visit(archive, "rmse");
    archive("one_step", one_step,
            field("N m",
                  "per joint, RMSE one step ahead: of the error less its lag-one autocorrelation "
                  "times the last one"));
    archive("percent_of_rms", percent_of_rms,
            field("%", "per joint, rmse over the RMS of the measured torque"));
    archive("r2", r2, field("1", "per joint, share of the measured torque's variance explained"));
    archive("drift", drift,
            field("N m", "per joint, rise of the torque residual over the recording"));
    archive("drift_error", drift_error, field("N m", "per joint, standard error of drift"));
  }
};

/// tau = M(q) a + h(q, v) + tau_f, friction driven by the motion (free run: its state is never
/// corrected by the measured torque, which only says how the first sample was reached, see
/// initial_friction_state). Laws that read the load see the predicted torque, not the
/// measured one: the rigid-body torque first, then once more with the friction found.
/// @param known    the robot before identification, see constant_friction
/// @param q, v, a  zero-phase filtered motion (T, n)
/// @throws UserError when the sizes do not agree
TorquePrediction torque_prediction(const Arm& arm, const dynamics::RobotModel& known,
                                   const data::Dataset& dataset, ConstRowMatrix q, ConstRowMatrix v,
                                   ConstRowMatrix a);

/// A prediction as a file.
struct PredictionSignals {
  static constexpr std::string_view kFormat = "fricid.prediction/1";

  std::vector<std::string> joint_names;  ///< (n)
  Eigen::VectorXd t;                     ///< (T) [s]
  RowMatrix q, v;                        ///< (T, n) motion that drove the model [rad], [rad/s]
  RowMatrix tau;                         ///< (T, n) as measured [N m]
  RowMatrix tau_predicted;               ///< (T, n) [N m]
  RowMatrix tau_f;                       ///< (T, n) friction in it [N m]

  template <class Archive>
  void visit(Archive& archive) {
    archive.joints(joint_names);
    archive.times(t);
    archive.of_joints("q", q, signal("rad", "position that drove the model"));
    archive.of_joints("v", v, signal("rad/s", "velocity that drove the model"));
    archive.of_joints("tau", tau, signal("N m", "motor torque as measured"));
    archive.of_joints("tau_predicted", tau_predicted, signal("N m", "motor torque as predicted"));
    archive.of_joints(
        "tau_f", tau_f,
        signal("N m",
               "friction torque in tau_predicted, the constant torque of the joint included"));
  }
};
/// @param q, v  zero-phase filtered motion (T, n)
void save_prediction(const TorquePrediction& prediction, const data::Dataset& dataset,
                     ConstRowMatrix q, ConstRowMatrix v, const std::filesystem::path& path);
/// @param n  number of joints
/// @throws as data::load_signals
PredictionSignals load_prediction(const std::filesystem::path& path, int n);

/// Hidden states of a friction driven by the motion and the measured torque of a prediction (T,
/// n_z), in the units of its laws.
RowMatrix driven_states(const Arm& arm, const PredictionSignals& signals);

}  // namespace fricid::evaluate
