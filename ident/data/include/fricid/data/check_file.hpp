// What `fricid check` found: what is wrong with recordings, and what they tell about the robot and
// its friction. The file check.json of a run folder, and `fricid check --json`.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/diagnosis_file.hpp"

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
    archive("value", value, number("", -1e300, 1e300, "of the linear regression"));
    archive("standard_error", standard_error, number("", 0, 1e300, "predicted"));
    archive("percent", percent,
            number("%", 0, 1e300, "the same of the size that the parameter has or would matter"));
    archive("words", words, text("why not, or what it is confused with; empty: determined"));
  }
};

/// A standard parameter that no data of the robot determine alone.
struct CheckedGrouping {
  std::string name, words;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("of the standard parameter"));
    archive("words", words, text("the combinations that hold it, or that no torque shows it"));
  }
};

/// What the motion shows of the friction of one joint.
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
      return number(unit, 0, 1e300, meaning);
    };
    archive("joint", joint, text("name of the joint"));
    archive("fastest_rad_s", fastest, size("rad/s", "largest speed"));
    archive("slow_s", slow_s, size("s", "time moving below the Stribeck speed"));
    archive("reversals", reversals, size("", "after a travel that makes friction settle"));
    archive("presliding_excursions", presliding, size("", "turns back before that travel"));
    archive("samples_per_climb", samples_per_climb,
            size("", "within that travel after a reversal, median"));
    archive("load_Nm", load, number("N m", -1e300, 1e300, "least and largest torque"));
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
    archive("words", words, text("what is lacking; empty: nothing"));
  }
};

/// What the data tell about a robot and its friction.
struct CheckedIdentifiability {
  std::string message;
  std::vector<CheckedParameter> parameters;
  std::vector<CheckedGrouping> groupings;
  std::vector<CheckedJoint> joints;
  std::vector<CheckedFamily> families;

  template <class Archive>
  void visit(Archive& archive) {
    archive("message", message, text("why nothing can be said; empty: it can"));
    archive.sections("parameters", parameters, "base parameters and linear friction");
    archive.sections("not_alone", groupings, "standard parameters that no data determine alone");
    archive.sections("friction_coverage", joints, "what the motion shows of friction, per joint");
    archive.sections("families", families, "friction laws and modifiers");
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
    archive.section("identifiability", identifiability,
                    "what they tell; absent: no robot was named, or their times are damaged");
  }
};

}  // namespace fricid::data
