// A load as `fricid payload` found it: payload.json, and `fricid payload --json`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/fit_file.hpp"

namespace fricid::data {

struct PayloadFile {
  static constexpr std::string_view kFormat = "fricid.payload/1";

  std::vector<std::string> without, with;
  std::string robot, frame;
  Outcome outcome = Outcome::kFailed;
  std::string message;
  std::vector<std::string> doubts;
  double mass = 0, mass_error = 0;
  std::vector<double> com, com_error, inertia, inertia_error;
  std::vector<double> parameters, free_parameters, parameter_errors;

  template <class Archive>
  void visit(Archive& archive) {
    const auto any = [](std::string_view unit, std::string_view meaning) {
      return any_number(unit, meaning);
    };
    const auto error = [](std::string_view unit, std::string_view meaning) {
      return not_negative(unit, meaning);
    };
    archive("without", without, text("names of the logs without the load"));
    archive("with", with, text("names of the logs with the load"));
    archive("robot", robot, text("name of the robot"));
    archive("frame", frame, text("frame that carries the load; all values are in its axes"));
    archive("outcome", outcome, choice("how the regression ended"));
    archive("message", message, text("one line about it"));
    archive("doubts", doubts, text("what is wrong with the logs, one line each"));
    archive("mass_kg", mass, error("kg", "mass"));
    archive("mass_error_kg", mass_error, error("kg", "its standard error"));
    archive("com_m", com, any("m", "centre of mass (3)"));
    archive("com_error_m", com_error, error("m", "standard errors"));
    archive("inertia_kg_m2", inertia,
            any("kg m^2", "about the centre of mass: Ixx, Iyy, Izz, Ixy, Ixz, Iyz"));
    archive("inertia_error_kg_m2", inertia_error, error("kg m^2", "standard errors"));
    archive("parameters", parameters,
            any("", "m, m cx, m cy, m cz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the frame's origin"));
    archive("free_parameters", free_parameters,
            any("", "the same by least squares, not held to those of a body"));
    archive("parameter_errors", parameter_errors, error("", "standard errors of the latter"));
  }
};

}  // namespace fricid::data
