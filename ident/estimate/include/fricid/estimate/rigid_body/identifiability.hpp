// Before any fit: which parameters of a robot and its friction the data determine.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "fricid/base/enum_names.hpp"
#include "fricid/data/check_file.hpp"
#include "fricid/estimate/couplings.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"

namespace fricid::estimate {

/// kIdentified: predicted standard error below 10 % of the size that the parameter has or that
/// would matter (`judged_size`); kWeak: below 50 %; kNot: above.
enum class Verdict { kIdentified, kWeak, kNot };
constexpr std::string_view names(Verdict) {
  return "identified|weakly identified|not identifiable";
}
Verdict judge(double standard_error, double size);

/// After a joint's name: its Coulomb friction over the torque of its motor [1].
inline constexpr std::string_view kFrictionPerTorque = " friction per torque";

/// One unknown of the linear model: a base parameter, or Coulomb, viscous or constant friction of a
/// joint.
struct ParameterVerdict {
  std::string name{};         ///< "joint_a2 m cx + 0.3 joint_a3 m"
  double value = 0;           ///< estimate of the linear regression
  double standard_error = 0;  ///< of the regression
  double size = 0;            ///< reference of the error, see `judged_size`
  Verdict verdict = Verdict::kNot;
  std::string words{};  ///< why not identified, or what it is confused with; empty: identified
};

/// A standard parameter that no data of this robot determine alone.
struct Grouping {
  std::string name;
  std::string words;  ///< "no effect on any torque", or the base parameters that contain it
};

/// Friction regimes that the motion of one joint covers.
struct Coverage {
  bool slides = false;           ///< rad are m
  double fastest = 0;            ///< [rad/s]
  double slow_s = 0;             ///< time moving below `stribeck_speed` [s]
  int reversals = 0;             ///< reversals after enough travel for friction to settle
  int presliding = 0;            ///< reversals before that travel
  double samples_per_climb = 0;  ///< samples within that travel after a reversal, median
  double load_low = 0;           ///< torque range [N m]
  double load_high = 0;          //
  double temperature_low = 0;    ///< [K]
  double temperature_high = 0;   //
  double resolution = 0;         ///< smallest step of the logged position [rad]
  bool memory = false;           ///< whether held-out torque shows that friction has one
};

/// Whether the torque of a joint has both signs or a wide range, half of its largest: without that
/// friction that grows with the load looks like Coulomb friction.
/// @param low, high  of the torque [N m]
bool varies_enough(double low, double high);

/// Whether a family of friction laws can be fitted; `words` say why not, or what is weak, or are
/// empty.
struct FamilyVerdict {
  std::string family;
  bool supported = false;
  std::string words;
};

struct Identifiability {
  std::string message;  ///< why there is no result; empty: there is one
  std::vector<ParameterVerdict> parameters;
  std::vector<Grouping> groupings;
  std::vector<Coverage> joints;
  std::vector<FamilyVerdict> families;
  /// Joints whose armature a fit will hold, see `RigidBodyFit::without_inertia`.
  std::vector<JointInertia> without_inertia;
  std::vector<Coupling> couplings;        ///< (n) beside Coulomb and viscous friction
  GearSide growth_of = GearSide::kMotor;  ///< torque with which friction grows, where it does
  std::vector<std::string> doubts;        ///< of the torque as it is read, with what to do
};

struct IdentifiabilityOptions {
  RigidBodyOptions rigid_body;
  double stribeck_speed = 0.05;  ///< [rad/s]
  double presliding = 2e-3;      ///< travel of presliding after a reversal [rad]
};

/// Regresses the torque on rigid body and linear friction as a fit does (`prepare`), without a
/// prior, and takes its standard errors; coverage and families from the motion; joints without
/// inertia and couplings from the regression of a fit, with guesses and prior.
Identifiability examine_data(const dynamics::RobotModel& robot,
                             std::span<const signals::Recording> recordings,
                             const IdentifiabilityOptions& options);

/// integral of Y_b' W Y_b dt over the recordings, but beside missing samples, W = diag(1 /
/// effort^2), to which a further trajectory adds. Base columns of `base_parameters`.
Eigen::MatrixXd base_information(const dynamics::RobotModel& robot,
                                 std::span<const signals::Recording> recordings, double cutoff_hz);

/// The report as a part of check.json.
data::CheckedIdentifiability checked(const Identifiability& report,
                                     const dynamics::RobotModel& robot);
std::string to_text(const Identifiability& report, const dynamics::RobotModel& robot);
/// The same in short: rigid body, friction per joint, families of laws, what to record next.
std::string to_summary(const Identifiability& report, const dynamics::RobotModel& robot,
                       bool damaged = false);

}  // namespace fricid::estimate
