// Options of the robot: section [robot].
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"
#include "fricid/dynamics/couplings.hpp"

namespace fricid::scene {

/// [[robot.torque]]: torques of one joint, each a known shape times an unknown coefficient.
struct LinearTorqueSection {
  std::string joint;
  std::vector<std::string> terms;
  std::vector<double> prior_sd;

  /// For the template.
  static LinearTorqueSection example() {
    return {.joint = "joint_a2", .terms = {"1", "sin(q)", "cos(q)"}, .prior_sd = {10, 500, 500}};
  }
  template <class Archive>
  void visit(Archive& archive) {
    archive("joint", joint, required(text("name of the joint")));
    archive("terms", terms,
            required(text("shapes: 1, q, sin(q), cos(q), sin(2 q), sin(31.4 q), ...")));
    archive(
        "prior_sd", prior_sd,
        number("N m", 0, 1e6, "standard deviation of each coefficient about 0; []: none known"));
  }
};

/// How the base is fixed.
enum class Mount { kFloor, kCeiling, kWall, kRpy };
constexpr std::string_view names(Mount) { return "floor|ceiling|wall|rpy"; }

/// [robot]
struct RobotSection {
  std::string urdf;
  std::string mjcf;
  Mount mount = Mount::kFloor;
  std::array<double, 3> mount_rpy{};
  double payload_kg = 0;
  std::array<double, 3> payload_com{};
  std::array<double, 6> payload_inertia{};
  std::string payload_frame = "flange";
  bool mend_inertia = false;
  std::map<std::string, double> armature;
  bool guess_armature = false;
  std::vector<std::string> hold;
  std::map<std::string, double> fix;
  std::vector<LinearTorqueSection> torques;
  /// [[robot.coupling]]: rotor inertia and friction are then the motors', under the names of their
  /// joints.
  std::vector<dynamics::NamedCoupling> couplings;

  template <class Archive>
  void visit(Archive& archive) {
    archive("urdf", urdf,
            required(text("the engine's robot; beside the scene or in the share folder")));
    archive("mjcf", mjcf, text("the simulator's robot; empty for logs"));
    archive("mount", mount, choice("orientation of the base"));
    archive("mount_rpy", mount_rpy,
            number("rad", -6.2832, 6.2832, "roll, pitch, yaw of the base when mount = \"rpy\""));
    archive("payload_kg", payload_kg, number("kg", 0, 2000, "rigid payload"));
    archive("payload_com", payload_com,
            number("m", -5, 5, "centre of mass of the payload in payload_frame"));
    archive("payload_inertia", payload_inertia,
            number("kg m^2", -1e4, 1e4,
                   "Ixx, Iyy, Izz, Ixy, Ixz, Iyz of the payload about its centre of mass"));
    archive("payload_frame", payload_frame, text("frame of the URDF that carries the payload"));
    archive("mend_inertia", mend_inertia,
            flag("take the nearest inertia that a body can have where that of a link in the URDF "
                 "is none"));
    archive(
        "armature", armature,
        number("kg m^2 or kg", 0, 1e5, "inertia of the rotor at a joint, in place of the URDF's"));
    archive("guess_armature", guess_armature,
            flag("simulate joints for which none is stated with the armature that is usual for "
                 "their limits; a fit to logs always starts from that guess"));
    archive("hold", hold,
            text("joints that stand still in the logs: fixed at their position in the first "
                 "training log"));
    archive("fix", fix,
            number("rad or m", -1e3, 1e3,
                   "joints fixed at a position; those that <mimic> them follow"));
    archive.sections("torque", torques,
                     "known torques linear in a parameter, e.g. a counterbalance");
    archive.sections("coupling", couplings,
                     "motors that turn two joints; friction and armature act at the motors");
  }
};

/// Rotation that takes vectors of the base to the world (z up).
Eigen::Matrix3d mount_rotation(const RobotSection& robot);
/// The same of "floor", "ceiling", "wall" or roll, pitch and yaw [rad], "0.3,-0.45,0".
/// @throws UserError
Eigen::Matrix3d mount_rotation(const std::string& words);

}  // namespace fricid::scene
