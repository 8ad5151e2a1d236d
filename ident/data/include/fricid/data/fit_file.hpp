// Report of a fit: the files fit/NAME_sSEED.json of a run folder.
#pragma once

#include <Eigen/Core>

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"
#include "fricid/data/mended_links.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::data {

/// How a fit ended. Numerical failure is reported, not thrown; the best values found are kept.
enum class Outcome {
  kConverged,       ///< the stopping rule was met
  kIterationLimit,  ///< best so far within the budget of evaluations
  kIllConditioned,  ///< the data do not determine the parameters; see `condition`
  kFailed           ///< no finite result
};

constexpr std::string_view names(Outcome) {
  return "converged|iteration limit|ill conditioned|failed";
}

/// A parameter of a joint's friction as fitted.
struct FittedParameter {
  std::string symbol;
  double value = 0;
  double standard_error = 0;  ///< NaN if the parameter was held fixed or the error is not known
  std::optional<double> motion_error{};  ///< part of it that filter and samples of the motion make

  template <class Archive>
  void visit(Archive& archive) {
    archive("symbol", symbol, text("of the law's table"));
    archive("value", value, any_number("", "in the unit of the law's table"));
    archive("standard_error", standard_error,
            not_negative("",
                         "of method joint: a jackknife, together with the rigid body, as Coulomb "
                         "and viscous friction of others is; else with the rigid body given; null: "
                         "unknown or held"));
    archive(
        "motion_error", motion_error,
        not_negative("",
                     "part of standard_error: what the filter of the motion and the time between "
                     "its samples may have changed; absent: not known"));
  }
};

/// The fitted friction of one joint and its torque residual.
struct FittedJoint {
  std::string joint;
  Outcome outcome = Outcome::kFailed;
  std::string message;
  double offset = 0, rms = 0, explained = 0, residual_rms = 0, r2 = 0;
  std::vector<double> start_rms;
  std::vector<std::string> at_bound, guessed;
  int evaluations = 0;
  std::vector<FittedParameter> parameters;
  Eigen::MatrixXd correlation;  ///< of `parameters`, in the coordinates of the search; or empty

  template <class Archive>
  void visit(Archive& archive) {
    const auto torque = [](std::string_view meaning) { return any_number("N m", meaning); };
    archive("joint", joint, text("name of the joint"));
    archive("outcome", outcome, choice("how the search ended"));
    archive("message", message, text("the same in words"));
    archive("offset_Nm", offset, torque("constant torque in addition to the law"));
    archive("rms_Nm", rms, torque("residual of the friction torque"));
    archive("explained", explained, at_most_one("1", "1 - residual / target mean square"));
    archive("residual_rms_Nm", residual_rms, torque("residual of the motor torque"));
    archive("r2", r2, at_most_one("1", "share of the motor torque's variance explained"));
    archive("start_rms_Nm", start_rms, torque("residual at the end of each start of the search"));
    archive("at_bound", at_bound, text("symbols of parameters that ended on a bound"));
    archive("guessed", guessed,
            text("symbols of static friction that the motion does not show, taken as twice that of "
                 "sliding"));
    archive("evaluations", evaluations, number("", 0, 1e9, "of the objective"));
    archive.sections("parameters", parameters, "friction parameters");
    archive("correlation", correlation,
            number("1", -1, 1, "of the parameters, in the coordinates of the search"));
  }
};

struct FittedBaseParameter {
  std::string name, verdict;
  double value = 0;
  double standard_error = 0;  ///< NaN if the data do not determine the parameter
  double physical = 0;

  template <class Archive>
  void visit(Archive& archive) {
    const auto inertial = [](std::string_view meaning) {
      return any_number("kg, kg m, kg m^2", meaning);
    };
    archive("name", name, text("combination of standard parameters"));
    archive("value", value, inertial("least squares"));
    archive("verdict", verdict, text("whether the data determine it"));
    archive("standard_error", standard_error, inertial("null: not determined by the data"));
    archive("physical", physical,
            inertial("value in the model: the nearest physically consistent one"));
  }
};

/// A joint whose torque shows no inertia, see estimate::RigidBodyFit.
struct HeldArmature {
  std::string joint;
  double inertia = 0, inertia_se = 0, armature = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("joint", joint, text("name of the joint"));
    archive(
        "inertia", inertia,
        any_number("kg m^2 or kg", "by the torque alone, the largest over the poses of the log"));
    archive("inertia_se", inertia_se, not_negative("kg m^2 or kg", "its standard error"));
    archive("armature", armature, not_negative("kg m^2 or kg", "the value that is held"));
  }
};

/// Side of the gear whose torque loads it: what the motor gives, or what reaches the link.
enum class GearSide { kMotor, kLink };
constexpr std::string_view names(GearSide) { return "motor|link"; }

/// Friction that grows with the torque of a gear, see estimate::rigid_body_under_load.
struct FittedLoadGrowth {
  bool modelled = false;
  std::optional<GearSide> side;  ///< none: of the motor
  Eigen::VectorXd coefficient, standard_error;

  bool is_of_motor() const { return side.value_or(GearSide::kMotor) == GearSide::kMotor; }

  /// Whether a joint shows it: by four standard errors.
  static bool is_seen(double coefficient, double standard_error) {
    constexpr double kSeen = 4;
    return coefficient > kSeen * standard_error;
  }

  template <class Archive>
  void visit(Archive& archive) {
    archive(
        "modelled", modelled,
        flag("whether the law has it; if not, growth with the motor's torque scales the bodies, "
             "and the standard errors of `rigid_body` contain that"));
    archive("side", side,
            choice("side of the gear whose torque is the load: the motor's, or what reaches the "
                   "link, which scales no body; absent: the motor's"));
    archive("coefficient", coefficient,
            not_negative("1", "per joint, Coulomb friction per torque of that side"));
    archive("standard_error", standard_error, not_negative("1", "per joint"));
  }
};

/// The regression of the rigid body with linear friction.
struct FittedRigidBody {
  Outcome outcome = Outcome::kFailed;
  std::string message;
  std::string prior;  ///< why the nominal values entered; empty: they did not
  std::optional<std::string> slower;
  std::vector<HeldArmature> held_armatures;
  std::vector<std::string> mended_links;
  double condition = 0;
  std::vector<int> rows, rows_total, equations;
  Eigen::VectorXd sigma, Fc, Fv, offset, Fc_se, Fv_se, offset_se, law_factor;
  std::optional<FittedLoadGrowth> load_growth;
  std::vector<FittedBaseParameter> base;

  template <class Archive>
  void visit(Archive& archive) {
    const auto per_joint = [](std::string_view unit, std::string_view meaning) {
      return any_number(unit, meaning);
    };
    archive("outcome", outcome, choice("how the regression ended"));
    archive("message", message, text("the same in words"));
    archive("prior", prior, text("why nominal values entered as a prior; empty: they did not"));
    archive("slower", slower,
            text("speeds of rows of joints that are too slow for the min_speed_rad_s asked for"));
    archive.sections("held_armatures", held_armatures,
                     "joints whose torque shows no inertia: the armature is held");
    archive("mended_links", mended_links, kMendedLinks);
    archive("condition", condition,
            not_negative("1", "of the weighted regressor, columns of unit length"));
    archive("rows_used", rows, number("", 0, 1e9, "per joint, samples"));
    archive("rows_total", rows_total, number("", 0, 1e9, "per joint, samples"));
    archive("equations", equations, number("", 0, 1e9, "per joint, after decimation"));
    archive("residual_sd_Nm", sigma, per_joint("N m", "per joint"));
    archive("coulomb_Nm", Fc, per_joint("N m", "per joint, of the linear friction"));
    archive("viscous_Nms_rad", Fv, per_joint("N m s/rad", "per joint, of the linear friction"));
    archive("offset_Nm", offset, per_joint("N m", "per joint, constant torque"));
    archive("coulomb_se_Nm", Fc_se, per_joint("N m", "standard error"));
    archive("viscous_se_Nms_rad", Fv_se, per_joint("N m s/rad", "standard error"));
    archive("offset_se_Nm", offset_se, per_joint("N m", "standard error"));
    archive("law_factor", law_factor,
            per_joint("1",
                      "per joint, of the law's torque beside which the rigid body was found, about "
                      "1; empty: it was found beside the linear friction"));
    archive.section("load_growth", load_growth,
                    "friction that grows with the load, where the data show it");
    archive.sections("base_parameters", base, "base parameters of the rigid body");
  }
};

/// Training by gradients: on the torque, or on open-loop windows.
struct FittedTraining {
  Outcome outcome = Outcome::kFailed;
  std::string message;
  std::vector<double> loss;
  std::vector<int> checked;
  std::vector<double> held_out;
  int chosen = 0, skipped = 0, returns = 0, leap = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("outcome", outcome, choice("how it ended"));
    archive("message", message, text("the same in words"));
    archive("loss", loss, not_negative("1", "loss per step"));
    archive("checked", checked,
            number("", 0, 1e9, "steps after which the held-out error was evaluated"));
    archive(
        "held_out", held_out,
        not_negative("",
                     "error on the held-out part, one per entry of `checked`: MSE of q [rad^2] of "
                     "windows, residual share of the friction torque of torque training"));
    archive("chosen", chosen,
            number("", 0, 1e9, "index in `checked` of the parameters that were kept"));
    archive("skipped", skipped, number("", 0, 1e9, "steps without a finite gradient"));
    archive("returns", returns, number("", 0, 1e9, "number of returns to the best parameters"));
    archive("leap", leap, number("", 0, 1e9, "engine steps per integration step of the training"));
  }
};

struct FittedIteration {
  double log_likelihood = 0, nis = 0, least_roots = 0, least_backward_ess = 0, objective = 0,
         velocity_sd = 0, held_out = 0;

  template <class Archive>
  void visit(Archive& archive) {
    const auto value = [](std::string_view unit, std::string_view meaning) {
      return any_number(unit, meaning);
    };
    archive("log_likelihood", log_likelihood, value("nat", "of the training parts"));
    archive("nis", nis, value("1", "normalised innovation squared per channel"));
    archive("least_roots", least_roots,
            value("1", "smallest share of distinct ancestors of the smoothed paths"));
    archive(
        "least_backward_ess", least_backward_ess,
        value("",
              "smallest median over the recordings of the ESS of backward sampling; 0: not used"));
    archive("objective", objective, value("nat", "mean negative log transition density"));
    archive("velocity_sd", velocity_sd,
            value("rad/s", "noise of v per sample, geometric mean over the joints"));
    archive("held_out_q_mse", held_out, value("rad^2", "after the iteration"));
  }
};

/// Expectation-maximisation.
struct FittedEm {
  Outcome outcome = Outcome::kFailed;
  std::string message;
  double held_out_start = 0;
  std::vector<FittedIteration> iterations;
  int chosen = 0;
  std::vector<std::string> warnings;
  Eigen::VectorXd variance_q, variance_v, variance_z, variance_observation;

  template <class Archive>
  void visit(Archive& archive) {
    const auto variance = [](std::string_view unit, std::string_view meaning) {
      return not_negative(unit, meaning);
    };
    archive("outcome", outcome, choice("how it ended"));
    archive("message", message, text("the same in words"));
    archive("held_out_q_mse_start", held_out_start,
            not_negative("rad^2", "before the first iteration"));
    archive.sections("iterations", iterations, "E- and M-steps");
    archive("chosen", chosen,
            number("", -1, 1e9, "index of the iteration that was kept; -1: the start"));
    archive("warnings", warnings, text("warnings of the filters and smoothers"));
    archive("variance_q", variance_q, variance("rad^2", "of the transition, per joint"));
    archive("variance_v", variance_v, variance("rad^2/s^2", "of the transition, per joint"));
    archive("variance_z", variance_z, variance("", "of the transition, per latent state"));
    archive("variance_observation", variance_observation, variance("rad^2", "per joint"));
  }
};

/// A reason not to trust a fit.
struct FittedFault {
  std::string joint, found, remedy;

  template <class Archive>
  void visit(Archive& archive) {
    archive("joint", joint, text("name of the joint; empty: the whole robot"));
    archive("found", found, text("what is wrong"));
    archive("remedy", remedy, text("what to do"));
  }
};

/// What the parameters of a fit do not say though they look as if they did. Its predictions may be
/// good.
struct FittedRemark {
  std::string found, meaning, remedy;

  template <class Archive>
  void visit(Archive& archive) {
    archive("found", found, text("which parameters of which joints"));
    archive("meaning", meaning, text("what they do not say"));
    archive("remedy", remedy, text("what to do"));
  }
};

/// One of several fits of which held-out data chose.
struct FittedCandidate {
  std::string name;
  double held_out = 0, torque = 0;
  int parameters = 0;
  bool eligible = false, taken = false;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("model and method"));
    archive("held_out_q_mse", held_out,
            not_negative("rad^2", "of held-out rollouts, geometric mean"));
    archive("held_out_torque", torque,
            not_negative("1", "residual share of the torque's variance, held-out rows"));
    archive("parameters", parameters, number("", 0, 1e9, "free parameters of the friction"));
    archive("eligible", eligible,
            flag("whether its rollouts are as good as the best, but for chance"));
    archive("taken", taken,
            flag("whether it was chosen: of the eligible ones the simplest near the least torque "
                 "error"));
  }
};

/// Effect of one part of the sum of laws on the held-out torque of one joint.
struct FittedPart {
  std::string joint, part;
  double gain = 0, error = 0;
  bool on = false;

  template <class Archive>
  void visit(Archive& archive) {
    archive("joint", joint, text("name of the joint"));
    archive(
        "part", part,
        text("backlash, load, power_flow, asymmetry, ripple, second_ripple, third_ripple, "
             "temperature, network; two_springs, four_springs, eight_springs: a bank of as many; "
             "bristle: lugre instead of the bank; memoryless: stribeck "
             "instead of either; gear_load: of what the gear hands on, not of the motor's torque; "
             "viscous: linear viscous torque beside that of a power; inner_viscous: in the memory, "
             "not beside it; loaded_viscous: viscous torque grows with load; stribeck: of the "
             "speed alone, beside the memory; loaded_stribeck: it grows with load; "
             "further_modifiers: temperature and direction of power flow, Stribeck torque and "
             "cable; cable: a soft spring beside the memory"));
    archive("gain", gain,
            any_number("1", "relative rise of the held-out mean square without the part"));
    archive("gain_se", error, not_negative("1", "standard error of gain, from blocks of a second"));
    archive("on", on, flag("whether the model that was taken has it"));
  }
};

/// The same laws fitted without samples [begin, end) of a recording, and others of its fold.
struct FittedWithout {
  std::string recording;
  int begin = 0, end = 0;
  Eigen::VectorXd pi, theta;

  template <class Archive>
  void visit(Archive& archive) {
    const auto value = any_number("", "of the model, in its order");
    archive("recording", recording, text("name of the training recording"));
    archive("begin", begin, number("", 0, 1e9, "first sample left out"));
    archive("end", end, number("", 0, 1e9, "sample behind the last one left out"));
    archive("rigid_body", pi, value);
    archive("friction", theta, value);
  }
};

/// Parameters that the same data might as well have given, one draw per row.
struct FittedDraws {
  Eigen::MatrixXd pi, theta;

  template <class Archive>
  void visit(Archive& archive) {
    const auto value = any_number("", "of the model, in its order, one draw per row");
    archive("rigid_body", pi, value);
    archive("friction", theta, value);
  }
};

/// Training data of which a fit used pieces that are spread over all of them (`training_part`).
struct FittedTo {
  double seconds = 0, of_seconds = 0;
  int pieces = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("seconds", seconds, not_negative("s", "length of the pieces together"));
    archive("of_seconds", of_seconds, not_negative("s", "length of the training data"));
    archive("pieces", pieces, number("", 0, 1e9, "drawn at random, one of each equal share"));
  }
};

/// "320 of 3600 s, 16 pieces drawn over all of it".
std::string in_words(const FittedTo& part);

/// The whole file.
struct FitFile {
  static constexpr std::string_view kFormat = "fricid.fit/2";

  std::string name, label;
  int seed = 1;
  std::string method;
  Outcome outcome = Outcome::kFailed;
  bool usable = false;
  std::string message;
  std::optional<std::string> prior_left_out;         ///< why; none: it stayed, or there was none
  std::vector<FittedFault> faults;                   ///< why not to trust it
  std::optional<std::vector<FittedRemark>> remarks;  ///< on parameters; none: nothing to say
  std::vector<double> objective;
  int parameters = 0;
  std::optional<FittedTo> fitted_to;  ///< none: all training data
  FittedRigidBody rigid_body;
  std::vector<FittedJoint> joints;           ///< (n); empty where no law was fitted joint by joint
  std::optional<FittedTraining> torque;      ///< of method torque, and where windows follow it
  std::optional<FittedTraining> multi_step;  ///< of method multi_step
  std::optional<FittedEm> em;                ///< of method em
  std::vector<FittedCandidate> candidates;   ///< of method joint
  std::vector<FittedPart> parts;             ///< of model lvm
  std::vector<FittedWithout> without;        ///< of method joint
  std::optional<FittedDraws> draws;          ///< of method joint

  /// @throws UserError naming `place` when lists do not agree in length
  void check(const std::string& place) const;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("of the model"));
    archive("label", label, text("name in tables and plots"));
    archive("seed", seed, number("", 0, 1e9, "of the fit"));
    archive("method", method, text("how it was fitted"));
    archive("outcome", outcome, choice("how it ended"));
    archive("usable", usable, flag("whether the model may be trusted"));
    archive("message", message, text("the outcome in words"));
    archive("prior_left_out", prior_left_out,
            text("why the prior of the model was left out, in words"));
    archive.sections("faults", faults, "why not to trust it");
    archive.sections("remarks", remarks, "what parameters do not say though they look like it");
    archive("objective", objective,
            not_negative("1",
                         "per pass, mean over joints of residual / torque mean "
                         "square"));
    archive("parameters", parameters, number("", 0, 1e9, "number of fitted values"));
    archive.section("fitted_to", fitted_to, "the part of long training data that was used");
    archive.section("rigid_body", rigid_body, "the regression of the rigid body");
    archive.sections("joints", joints, "friction joint by joint");
    archive.section("torque", torque, "training on the torque residual of the rigid body");
    archive.section("multi_step", multi_step, "training on open-loop windows");
    archive.section("em", em, "expectation-maximisation");
    archive.sections("candidates", candidates, "of method joint: fits of which one was chosen");
    archive.sections(
        "parts", parts,
        "of model lvm: what the parts of its sum gain on the held-out torque, as judged last");
    archive.sections("without", without,
                     "of method joint: fits that left recordings out in turn, for its bands");
    archive.section("draws", draws,
                    "of method joint: parameters that the same data might as well have given");
  }
};

/// The fit's record of entry i of theta; null without one.
const FittedParameter* fitted_parameter(const FitFile& fit, const friction::RobotFriction& friction,
                                        int i);

}  // namespace fricid::data
