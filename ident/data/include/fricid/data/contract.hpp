// Import of real logs: a contract defines the columns and the meaning of the torque; nothing is
// guessed. The formats are those of `log_reader.hpp`.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/dynamics/couplings.hpp"

namespace fricid::data {

inline constexpr char kColumns[] =
    "one header per joint, or one pattern: {} stands for 1, 2, ..., {0} for 0, 1, ..., {name} for "
    "the joint";
inline constexpr char kColumnsOptional[] =
    "one header per joint, or one pattern: {} stands for 1, 2, ..., {0} for 0, 1, ..., {name} for "
    "the joint; []: absent, or as the format has it";

/// [time]
struct TimeColumn {
  std::string column = "t";
  std::string unit = "s";

  template <class Archive>
  void visit(Archive& archive) {
    archive("column", column, text("header of the column"));
    archive("unit", unit, choice("s|ms|us|ns", "unit of the column"));
  }
};

/// [position], [velocity]: the joint value is sign (scale raw / gear_ratio) + offset, gear_ratio
/// used for motor_* units, coupled motors then added (`Contract::couplings`).
struct MotionColumns {
  std::vector<std::string> columns;
  std::string unit = "rad";
  std::vector<double> sign;
  std::vector<double> scale;
  std::vector<double> offset_rad;

  template <class Archive>
  void visit(Archive& archive) {
    archive("columns", columns, text(kColumnsOptional));
    archive("unit", unit,
            choice("rad|deg|motor_rad|motor_deg",
                   "unit (per second for a velocity), at the joint or "
                   "at the motor; of joints that slide m, motor_ units apart"));
    archive("sign", sign,
            per_joint("1", -1, 1, "+1 or -1: sign of the column along the joint axis; []: +1"));
    archive("scale", scale, per_joint("1", 1e-12, 1e12, "factor of the raw values; []: 1"));
    archive("offset_rad", offset_rad,
            per_joint("rad", -12.6, 12.6,
                      "added at the joint after sign and gear (position only); []: 0"));
  }
};

/// [torque]: meaning of `tau`. Values at the joint are taken as they are, motor_torque is
/// multiplied by gear_ratio, current by torque_constant and gear_ratio.
struct TorqueColumns {
  std::vector<std::string> columns;
  std::string kind = "joint_torque";
  std::vector<double> sign;
  std::vector<double> scale;
  std::vector<double> percent_of;
  std::vector<double> torque_constant;
  double delay_s = 0;
  std::string timing = "auto";

  template <class Archive>
  void visit(Archive& archive) {
    archive("columns", columns, text(kColumns));
    archive("kind", kind,
            choice("joint_torque|motor_torque|current|gear_torque|gear_torque_less_friction|"
                   "link_torque",
                   "meaning of the torque, see above"));
    archive("sign", sign,
            per_joint("1", -1, 1, "+1 or -1: sign of the column along the joint axis; []: +1"));
    archive("scale", scale, per_joint("1", 1e-12, 1e12, "factor of the raw values; []: 1"));
    archive("percent_of", percent_of,
            per_joint("N m or A", 1e-6, 1e6,
                      "value of 100 % (rated torque, largest current); []: columns are not in %"));
    archive("torque_constant", torque_constant,
            per_joint("N m/A", 0, 1e4, "motor torque per ampere (current only)"));
    archive("delay_s", delay_s,
            number("s", -1, 1,
                   "known time by which the torque of a row is later than its motion: it is moved "
                   "back by it"));
    archive(
        "timing", timing,
        choice("auto|held|measured",
               "when the torque of a row acts: held from its sample to the next, as that of a "
               "controller, or measured at it; auto: as a regression finds, with delay_s held"));
  }
};

/// [temperature]
struct TemperatureColumns {
  std::vector<std::string> columns;
  std::string unit = "K";

  template <class Archive>
  void visit(Archive& archive) {
    archive("columns", columns, text(kColumnsOptional));
    archive("unit", unit, choice("K|C", "unit of the columns"));
  }
};

/// A column contract (TOML).
struct Contract {
  std::vector<std::string> joint_names;
  std::string format = "auto";
  std::string topic;
  std::string separator = "auto";
  bool decimal_comma = false;
  int skip_rows = 0;
  std::vector<double> gear_ratio;
  TimeColumn time;
  MotionColumns position;
  TorqueColumns torque;
  MotionColumns velocity;
  TemperatureColumns temperature;
  /// [[coupling]]: q = A m, and motor torques count as A^-T tau_m.
  std::vector<dynamics::NamedCoupling> couplings;

  int n() const { return static_cast<int>(joint_names.size()); }

  template <class Archive>
  void visit(Archive& archive) {
    archive("joint_names", joint_names,
            required(text("joints of the robot, in the order of columns")));
    archive("format", format,
            choice("auto|csv|rsi_xml|rsi_csv|kuka_trace|ur_csv|franka_csv|mcap|db3|hdf5|mat",
                   "format of the log; unless auto, columns of time and position may be left out "
                   "if the format has its own"));
    archive("topic", topic, text("topic of the joint states in a bag; empty: the only one"));
    archive("separator", separator,
            choice("auto|comma|semicolon|tab|space", "separator of the columns"));
    archive("decimal_comma", decimal_comma, flag("numbers are written 1,5 instead of 1.5"));
    archive("skip_rows", skip_rows,
            number("1", 0, 10'000, "lines above the header of a text file, whatever they hold"));
    archive("gear_ratio", gear_ratio,
            per_joint("1", 1e-3, 1e5, "motor turns per joint turn, for motor_* units and torques"));
    archive.section("time", time, "sample times");
    archive.section("position", position, "joint positions");
    archive.section("torque", torque, "torques of the joints");
    archive.section("velocity", velocity, "measured velocities, if the log has them");
    archive.section("temperature", temperature, "temperatures of the gears, if the log has them");
    archive.sections("coupling", couplings, "motors that move two joints (motor_* units only)");
  }
};

/// The couplings by index, in the order of `joint_names`. @throws UserError as `load_contract`
std::vector<dynamics::Coupling> couplings_of(const Contract& contract);

/// @throws UserError "file:line: ..." on anything wrong
Contract load_contract(const std::filesystem::path& path);

/// A commented contract with every key, its unit, range and default.
std::string contract_template();

/// What the columns of logs are taken for, a line each: the kind of the torque with the limits of a
/// fit to it, "FILE: torque.kind = ..."; and a position that by its name was commanded.
std::vector<std::string> meaning_in_words(const Contract& contract, const std::string& file);
/// Limits of a fit to the torque of a data set, whose source names its kind; empty: none.
std::string_view warning_of_torque(const Dataset& dataset);

/// Whether its torque was measured beyond the gear, where its rotor and its friction are not.
bool is_link_torque(const Dataset& dataset);

/// Takes warnings, one line each.
using Warn = std::function<void(const std::string&)>;

/// Reads a log without checking its times: they may have gaps, repeat or jitter, which the doctor
/// reports (`fricid/doctor/doctor.hpp`). Slight jitter (`is_slight_jitter`) is evened out, or
/// interpolated (`taken`), which `source` and a warning say. t starts at 0; rate_hz is the usual
/// rate. Text may have lines that start with # or are blank; empty cells, "nan", "null" and "none"
/// are missing values.
/// @throws UserError "file:line: ..." for a missing column, a cell that is no number, a row of
///         another length, a file that is empty or torn
Dataset read_log(const std::filesystem::path& path, const Contract& contract,
                 const Warn& warn = {});

/// As read_log, but refuses uneven times.
/// @throws UserError as read_log, and for a time that does not rise, a gap or jitter above 1 % of
///         the period
Dataset import_log(const std::filesystem::path& path, const Contract& contract,
                   const Warn& warn = {});

}  // namespace fricid::data
