// Result of `fricid check`: faults of recordings, and identifiability of the robot and its
// friction. The file check.json of a run folder, and `fricid check --json`.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/diagnosis_file.hpp"
#include "fricid/data/mended_links.hpp"

namespace fricid::data {

/// An unknown of the linear model: a base parameter, or linear friction of a joint.
struct CheckedParameter {
  std::string name, verdict;
  double value = 0, standard_error = 0, percent = 0;
  std::string words;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("base parameter, or Coulomb, viscous or constant friction"));
    archive("verdict", verdict, text("whether the data determine it"));
    archive("value", value, any_number("", "estimate by linear regression"));
    archive("standard_error", standard_error, not_negative("", "predicted standard error"));
    archive(
        "percent", percent,
        not_negative("%",
                     "standard error over the size of the parameter, or over the size at which it "
                     "would matter"));
    archive("words", words,
            text("why it is not determined, or what it is confused with; empty: determined"));
  }
};

/// A standard parameter that no data of the robot determine alone.
struct CheckedGrouping {
  std::string name, words;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("of the standard parameter"));
    archive("words", words,
            text("the combinations that contain it, or that it does not affect the torque"));
  }
};

/// Friction regimes that the motion of one joint covers.
struct CheckedJoint {
  std::string joint;
  double fastest = 0, slow_s = 0;
  int reversals = 0, presliding = 0;
  double samples_per_climb = 0;
  std::vector<double> load, temperature;
  double resolution = 0;

  template <class Archive>
  void visit(Archive& archive) {
    const auto size = [](std::string_view unit, std::string_view meaning) {
      return not_negative(unit, meaning);
    };
    archive("joint", joint, text("name of the joint"));
    archive("fastest_rad_s", fastest, size("rad/s", "largest speed"));
    archive("slow_s", slow_s, size("s", "time moving below the Stribeck speed"));
    archive("reversals", reversals,
            size("", "reversals after enough travel for friction to settle"));
    archive("presliding_excursions", presliding, size("", "reversals before that travel"));
    archive("samples_per_climb", samples_per_climb,
            size("", "samples within that travel after a reversal, median"));
    archive("load_Nm", load, any_number("N m", "least and largest torque"));
    archive("temperature_K", temperature, size("K", "least and largest; empty: not measured"));
    archive("resolution_rad", resolution, size("rad", "smallest step of the logged position"));
  }
};

/// A family of friction laws.
struct CheckedFamily {
  std::string family;
  bool supported = false;
  std::string words;

  template <class Archive>
  void visit(Archive& archive) {
    archive("family", family, text("name of a law or modifier"));
    archive("supported", supported, flag("the data allow to fit it"));
    archive("words", words, text("what the data lack; empty: nothing"));
  }
};

/// Friction of a joint that depends on the speed of another one too.
struct CheckedCoupling {
  std::string joint, with;
  double factor = 0, percent = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("joint", joint, text("name of the joint"));
    archive("with", with, text("joint whose speed matters too"));
    archive("factor", factor, any_number("1", "of a coupling that would explain it"));
    archive("percent", percent,
            not_negative("%", "of what Coulomb and viscous friction of the joint alone leave"));
  }
};

/// Identifiability of a robot and its friction from the data.
struct CheckedIdentifiability {
  std::string message;
  std::vector<CheckedParameter> parameters;
  std::vector<CheckedGrouping> groupings;
  std::vector<CheckedJoint> joints;
  std::vector<CheckedFamily> families;
  std::vector<std::string> without_inertia, mended_links, doubts;
  std::vector<CheckedCoupling> couplings;

  template <class Archive>
  void visit(Archive& archive) {
    archive("message", message, text("why there is no result; empty: there is one"));
    archive.sections("parameters", parameters, "base parameters and linear friction");
    archive.sections("not_alone", groupings, "standard parameters that no data determine alone");
    archive.sections("friction_coverage", joints,
                     "friction regimes covered by the motion, per joint");
    archive.sections("families", families, "friction laws and modifiers");
    archive("without_inertia", without_inertia,
            text("joints whose torque shows no inertia: a fit holds their armature"));
    archive("mended_links", mended_links, kMendedLinks);
    archive("doubts", doubts,
            text("why the torque as it is read is not to be trusted, with what to do"));
    archive.sections("couplings", couplings, "joints with friction that another joint's motor has");
  }
};

/// The whole file.
struct CheckFile {
  static constexpr std::string_view kFormat = "fricid.check/2";

  std::vector<DiagnosisFile> doctor;
  std::optional<CheckedIdentifiability> identifiability;

  template <class Archive>
  void visit(Archive& archive) {
    archive.sections("doctor", doctor, "what is wrong with each recording");
    archive.section(
        "identifiability", identifiability,
        "identifiability of the parameters; absent: no robot was given, or the times are damaged");
  }
};

}  // namespace fricid::data
