// Import of real logs: a contract says what each column of a CSV file is; nothing is guessed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/data/field.hpp"

namespace fricid::data {

/// [time]
struct TimeColumn {
  std::string column = "t";
  std::string unit = "s";

  template <class Archive>
  void visit(Archive& archive) {
    archive("column", column, text("header of the column"));
    archive("unit", unit, choice("s ms us", "unit of the column"));
  }
};

/// [position], [velocity]: the joint value is sign (raw / gear_ratio) + offset, gear_ratio used for
/// motor_* units.
struct MotionColumns {
  std::vector<std::string> columns;
  std::string unit = "rad";
  std::vector<double> sign;
  std::vector<double> offset_rad;

  template <class Archive>
  void visit(Archive& archive) {
    archive(
        "columns", columns,
        text(
            "one header per joint, or one pattern in which {} stands for 1, 2, ...; [] if absent"));
    archive("unit", unit,
            choice("rad deg motor_rad motor_deg",
                   "unit (per second for a velocity), at the joint or "
                   "at the motor"));
    archive("sign", sign,
            per_joint("1", -1, 1, "+1 or -1: sign of the column along the joint axis"));
    archive(
        "offset_rad", offset_rad,
        per_joint("rad", -12.6, 12.6, "added at the joint after sign and gear (position only)"));
  }
};

/// [torque]: joint_torque takes the column as the motor torque seen at the joint; motor_torque
/// multiplies by gear_ratio; current multiplies by torque_constant and gear_ratio.
struct TorqueColumns {
  std::vector<std::string> columns;
  std::string kind = "joint_torque";
  std::vector<double> sign;
  std::vector<double> torque_constant;

  template <class Archive>
  void visit(Archive& archive) {
    archive("columns", columns,
            text("one header per joint, or one pattern in which {} stands for 1, 2, ..."));
    archive(
        "kind", kind,
        choice("joint_torque motor_torque current",
               "joint_torque [N m]: motor torque at the joint; motor_torque [N m]: at the motor "
               "shaft; current [A]"));
    archive("sign", sign,
            per_joint("1", -1, 1, "+1 or -1: sign of the column along the joint axis"));
    archive("torque_constant", torque_constant,
            per_joint("N m/A", 0, 1e4, "motor torque per ampere (current only)"));
  }
};

/// [temperature]
struct TemperatureColumns {
  std::vector<std::string> columns;
  std::string unit = "K";

  template <class Archive>
  void visit(Archive& archive) {
    archive(
        "columns", columns,
        text(
            "one header per joint, or one pattern in which {} stands for 1, 2, ...; [] if absent"));
    archive("unit", unit, choice("K C", "unit of the columns"));
  }
};

/// A column contract (TOML).
struct Contract {
  std::vector<std::string> joint_names;
  std::string separator = "auto";
  bool decimal_comma = false;
  std::vector<double> gear_ratio;
  TimeColumn time;
  MotionColumns position;
  TorqueColumns torque;
  MotionColumns velocity;
  TemperatureColumns temperature;

  int n() const { return static_cast<int>(joint_names.size()); }

  template <class Archive>
  void visit(Archive& archive) {
    archive("joint_names", joint_names,
            required(text("joints of the robot, in the order of columns")));
    archive("separator", separator,
            choice("auto comma semicolon tab space", "between the columns of a row"));
    archive("decimal_comma", decimal_comma, flag("numbers are written 1,5 instead of 1.5"));
    archive("gear_ratio", gear_ratio,
            per_joint("1", 1e-3, 1e5, "motor turns per joint turn, for motor_* units and torques"));
    archive.section("time", time, "sample times");
    archive.section("position", position, "joint positions");
    archive.section("torque", torque, "what moves the joints");
    archive.section("velocity", velocity, "measured velocities, if the log has them");
    archive.section("temperature", temperature, "temperatures of the gears, if the log has them");
  }
};

/// @throws UserError "file:line: ..." on anything wrong
Contract load_contract(const std::filesystem::path& path);

/// A commented contract with every key, its unit, range and default.
std::string contract_template();

/// Reads a log as it stands: times may have gaps, repeat or jitter, which the doctor tells
/// (`fricid/doctor/doctor.hpp`). t starts at 0; rate_hz is the usual rate.
/// @throws UserError as import_csv, but for times
Dataset read_log(const std::filesystem::path& path, const Contract& contract);

/// Reads a log: a header line, then rows of numbers; empty cells and "nan" are missing values.
/// Lines that start with # are skipped; t starts at 0.
/// @throws UserError "file:line: ..." for a missing column, a cell that is no number, a row of
/// another
///         length, a time that does not rise, a gap or jitter above 1 % of the period, an empty
///         file
Dataset import_csv(const std::filesystem::path& path, const Contract& contract);

}  // namespace fricid::data
