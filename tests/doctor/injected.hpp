// Damage put into logs at random, to count what the doctor finds of it.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::doctor {

inline constexpr double kSimulatorStep = 5e-4;  ///< of the logs [s]: a doctor sees no finer

/// What was done to a log, and what the doctor must say of it.
struct Injected {
  std::string name{};  ///< of the finding; empty: no damage must be found
  int joint = -1;      ///< -1: any
  double samples = 0;  ///< size of a delay
};

/// A kind of damage, to the log or to what is said of the robot; one that a log cannot have (a turn
/// of a sliding joint) gives nothing.
struct Injection {
  std::string what;
  std::function<Injected(data::Dataset&, dynamics::RobotModel&, Rng&)> apply;
  bool harmless = false;  ///< no damage must be found
};

/// In the order of the table; the place of a kind seeds what is random in it.
const std::vector<Injection>& injections();

/// A robot as its file might have it: links and armatures off by some 15 %; without armatures if
/// `i` is odd.
dynamics::RobotModel as_in_a_file(dynamics::RobotModel robot, int i);

/// A clean log at 1 kHz, with velocity and temperature, and the robot as in a file.
struct CleanLog {
  std::string what;
  data::Dataset data;
  dynamics::RobotModel robot;
};
/// Log number `i`: every arm moves slowly for 21 s and fast for 6.3 s.
int number_of_clean_logs();
CleanLog simulate_log(int i);
/// Delays the torque by a number of samples; between samples it is linear.
void delay_torque(data::Dataset& d, double samples);
/// Every so many-th sample.
data::Dataset decimated(const data::Dataset& log, int every);

/// What the doctor said about one damaged log.
struct Judged {
  bool found = false;      ///< by name and joint
  int others = 0;          ///< damage of other names
  double delay_error = 0;  ///< [samples], of a delay that was found
  std::string said{};      ///< all damage, one per line
};
Judged judge(const data::Dataset& damaged, const dynamics::RobotModel& robot,
             const Injected& truth);

}  // namespace fricid::doctor
