// Scores of estimates of external torque: the file contact.json.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid::evaluate {

/// What was estimated while nothing touched the arm, second by second. An alarm is a second in
/// which
///
///     s = max_j |tau_ext,j| / sd_j
///
/// exceeds its threshold, sd_j the RMS of all that was estimated.
class QuietTorque {
 public:
  /// Adds the estimates of a recording (T, n), whose last part of a second is left out.
  void add(ConstRowMatrix tau_ext, double rate_hz);
  /// Adds those of another.
  void add(const QuietTorque& other);

  double hours() const { return static_cast<double>(peaks_.size()) / 3600; }
  Eigen::VectorXd sd() const;  ///< (n) [N m]
  /// The least s that at most one second of every hour exceeds.
  double threshold() const;

 private:
  std::vector<Eigen::VectorXd> peaks_;  ///< (n) of each second [N m]
  Eigen::VectorXd squares_;             ///< (n) sums
  double samples_ = 0;
};

/// One push in a recording.
struct PushSpan {
  int begin = 0, end = 0;  ///< samples
};

/// When pushes of one force were noticed.
struct PushScore {
  double force_N = 0;
  int pushes = 0, missed = 0;  ///< missed: not noticed before their end
  /// Time from the begin of a push to the alarm; quantiles over all pushes, infinite where fewer
  /// were noticed.
  double delay_median_s = 0, delay_90_s = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("force_N", force_N, number("N", 0, 1e6, "of the pushes"));
    archive("pushes", pushes, number("", 0, 1e9, "number of pushes"));
    archive("missed", missed, number("", 0, 1e9, "pushes that raised no alarm before their end"));
    archive("delay_median_s", delay_median_s,
            number("s", 0, 1e6, "from the begin of a push to its alarm, median; null: missed"));
    archive("delay_90_s", delay_90_s,
            number("s", 0, 1e6, "the same, nine of ten are faster; null: missed"));
  }
};

/// Recordings of pushes begin with so much of motion [s], in which bristles lose their unknown
/// first state: nothing there counts.
inline constexpr double kContactWarmUp = 2.0;

/// Methods: the momentum observer with friction that follows the motion, or whose states particles
/// filter.
inline constexpr const char *kObserver = "observer", *kParticles = "particles";

/// Scores of one model by one method.
struct ContactScore {
  std::string model, label;          ///< "truth": the injected friction
  std::string method;                ///< kObserver or kParticles
  std::vector<double> sd_Nm;         ///< (n) without contact
  double threshold_sd = 0;           ///< of s
  std::vector<double> threshold_Nm;  ///< (n) threshold_sd sd_Nm
  /// (n) RMS error of tau_ext while pushes come and go: all, within 0.2 s of a reversal, elsewhere.
  std::vector<double> rmse_Nm, rmse_reversal_Nm, rmse_sliding_Nm;
  std::vector<PushScore> forces;

  template <class Archive>
  void visit(Archive& archive) {
    const auto torque = [](std::string_view meaning) { return number("N m", 0, 1e9, meaning); };
    archive("model", model, text("whose friction was used; truth: the injected one"));
    archive("label", label, text("for tables and plots"));
    archive("method", method,
            text("observer: friction follows the motion; particles: they filter its states"));
    archive("sd_Nm", sd_Nm, torque("per joint, RMS of the estimate without contact"));
    archive("threshold_sd", threshold_sd,
            number("1", 0, 1e9, "threshold of one false alarm per hour, over sd_Nm"));
    archive("threshold_Nm", threshold_Nm, torque("per joint, the threshold"));
    archive("rmse_Nm", rmse_Nm, torque("per joint, RMS error of the external torque"));
    archive("rmse_reversal_Nm", rmse_reversal_Nm,
            torque("the same within 0.2 s after the desired velocity changed its sign"));
    archive("rmse_sliding_Nm", rmse_sliding_Nm, torque("the same elsewhere"));
    archive.sections("forces", forces, "pushes by force");
  }
};

struct ContactFile {
  static constexpr std::string_view kFormat = "fricid.contact/1";

  double hours = 0;         ///< without contact
  double bandwidth_hz = 0;  ///< of the observer
  std::vector<std::string> joint_names;
  std::vector<ContactScore> models;

  /// Force of the first pushes [N]; 0 without any.
  double first_force() const {
    return models.empty() || models.front().forces.empty() ? 0
                                                           : models.front().forces.front().force_N;
  }

  template <class Archive>
  void visit(Archive& archive) {
    archive("hours", hours, number("h", 0, 1e6, "simulated without contact"));
    archive("bandwidth_hz", bandwidth_hz, number("Hz", 0, 1e6, "of the momentum observer"));
    archive("joint_names", joint_names, text("joints in order"));
    archive.sections("models", models, "models whose friction was used");
  }
};

/// Errors of estimated external torques over recordings.
class TorqueErrors {
 public:
  /// @param v_desired  (T, n) whose changes of sign are the reversals
  void add(ConstRowMatrix estimate, ConstRowMatrix truth, ConstRowMatrix v_desired, double dt);
  void write(ContactScore& score) const;

 private:
  Eigen::MatrixXd squares_, counts_;  // (n, 3) all, reversal, sliding
};

/// From the begin of every push to the first sample whose s exceeds the threshold [s]; infinite
/// when that is after its end.
std::vector<double> delays(ConstRowMatrix tau_ext, std::span<const PushSpan> pushes, double rate_hz,
                           std::span<const double> threshold_Nm);
PushScore score_pushes(double force_N, std::vector<double> delays);

/// Geometric mean over joints of the threshold [N m].
double mean_threshold(const ContactScore& score);

/// One row per model.
std::string to_markdown(const ContactFile& file);

}  // namespace fricid::evaluate
