// The rigid body as URDF and MJCF.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/base/xml.hpp"
#include "fricid/deploy/c_header.hpp"
#include "fricid/dynamics/body.hpp"
#include "mjcf.hpp"
#include "writers.hpp"

namespace fricid::deploy {
namespace {

using dynamics::Joint;
using dynamics::JointType;
using dynamics::LinearTorque;
using dynamics::RobotModel;
Xml numbers(const Eigen::Vector3d& x) {
  return Xml::of("{:.17g} {:.17g} {:.17g}", x[0], x[1], x[2]);
}

/// The body of a link. @throws UserError when no body can have its inertia
dynamics::Body body_of(const data::ModelFile& model, int i) {
  const RobotModel& robot = model.arm.robot;
  const dynamics::Vector10 pi = robot.pi.segment<10>(10 * i);
  if (!(pi[0] > 0) || !dynamics::is_physical(pi))
    throw UserError(
        "{}: no body can have the inertia of link {} (mass {:.4g} kg); allowed: fits "
        "with physical inertias",
        model.name, robot.joints[static_cast<std::size_t>(i)].link, pi[0]);
  return dynamics::body_of(pi);
}

// Roll, pitch and yaw of URDF: R = Rz(y) Ry(p) Rx(r).
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) {
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  if (std::hypot(R(0, 0), R(1, 0)) < 1e-8)  // roll and yaw turn about one axis
    return {std::atan2(-R(1, 2), R(1, 1)), pitch, 0};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

constexpr const char* kFrictionLeftOut = "friction is left out";

bool is_link(const RobotModel& robot, const std::string& name) {
  return std::ranges::any_of(robot.joints, [&](const Joint& j) { return j.link == name; });
}

// The frame that is the base itself; else a name that no link or frame has.
std::string base_name(const RobotModel& robot) {
  for (const dynamics::Frame& frame : robot.frames)
    if (frame.link < 0 && frame.R.isIdentity(0) && frame.p.isZero(0)) return frame.name;
  std::string name = "base";
  while (is_link(robot, name) ||
         std::ranges::find(robot.frames, name, &dynamics::Frame::name) != robot.frames.end())
    name += '_';
  return name;
}

// Frames that are not the base or a moving link by themselves.
std::vector<dynamics::Frame> further_frames(const RobotModel& robot) {
  std::vector<dynamics::Frame> frames;
  for (const dynamics::Frame& frame : robot.frames)
    if (frame.name != base_name(robot) && !is_link(robot, frame.name)) frames.push_back(frame);
  return frames;
}

std::string fixed_joint_name(const RobotModel& robot, const dynamics::Frame& frame) {
  std::string name = fmt::format("{}_fixed", frame.name);
  while (std::ranges::find(robot.joints, name, &Joint::name) != robot.joints.end()) name += '_';
  return name;
}

Xml origin(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) {
  return Xml::of("<origin xyz=\"{}\" rpy=\"{}\"/>", numbers(p), numbers(roll_pitch_yaw(R)));
}

Xml comment_of_doubt(const data::ModelFile& model) {
  return model.doubts.empty() ? Xml() : xml_comment(doubt_in_words(model)) + Xml::of("\n");
}

Xml urdf_link(const data::ModelFile& model, int i) {
  const dynamics::Body b = body_of(model, i);
  return Xml::of(
      "  <link name={}>\n    <inertial>\n      <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n"
      "      <mass value=\"{:.17g}\"/>\n      <inertia ixx=\"{:.17g}\" ixy=\"{:.17g}\" "
      "ixz=\"{:.17g}\" iyy=\"{:.17g}\" iyz=\"{:.17g}\" izz=\"{:.17g}\"/>\n    </inertial>\n"
      "  </link>\n",
      xml_attribute(model.arm.robot.joints[static_cast<std::size_t>(i)].link), numbers(b.c), b.m,
      b.I(0, 0), b.I(0, 1), b.I(0, 2), b.I(1, 1), b.I(1, 2), b.I(2, 2));
}

/// A joint without end has no limits of its position: the format has no number for them.
Xml urdf_limit(const Joint& joint) {
  if (joint.continuous && joint.effort == 0 && joint.velocity == 0) return {};
  Xml text = Xml::of("    <limit");
  if (!joint.continuous)
    text += Xml::of(" lower=\"{:.17g}\" upper=\"{:.17g}\"", joint.lower, joint.upper);
  text += Xml::of(" effort=\"{:.17g}\" velocity=\"{:.17g}\"/>\n", joint.effort, joint.velocity);
  return text;
}

Xml urdf_joint(const RobotModel& robot, int i, const std::string& base) {
  const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
  const bool revolute = joint.type == JointType::kRevolute;
  const std::string_view type = !revolute          ? "prismatic"
                                : joint.continuous ? "continuous"
                                                   : "revolute";
  const std::string& parent =
      joint.parent < 0 ? base : robot.joints[static_cast<std::size_t>(joint.parent)].link;
  return Xml::of(
      "  <joint name={} type={}>\n    <parent link={}/>\n    <child link={}/>\n    {}\n"
      "    <axis xyz=\"{}\"/>\n{}    <fricid armature=\"{:.17g}\"/>\n  </joint>\n",
      xml_attribute(joint.name), xml_attribute(type), xml_attribute(parent),
      xml_attribute(joint.link), origin(joint.R0, joint.p0), numbers(joint.axis), urdf_limit(joint),
      robot.pi[robot.armature_begin() + i]);
}

Xml urdf_frame(const RobotModel& robot, const dynamics::Frame& frame, const std::string& base) {
  const std::string& parent =
      frame.link < 0 ? base : robot.joints[static_cast<std::size_t>(frame.link)].link;
  return Xml::of(
      "  <link name={}/>\n  <joint name={} type=\"fixed\">\n    <parent link={}/>\n"
      "    <child link={}/>\n    {}\n  </joint>\n",
      xml_attribute(frame.name), xml_attribute(fixed_joint_name(robot, frame)),
      xml_attribute(parent), xml_attribute(frame.name), origin(frame.R, frame.p));
}

// The attributes of a joint or motor, if there are any.
Xml attributes_of(const std::vector<Xml>& attributes, int i) {
  return attributes.empty() ? Xml() : attributes[static_cast<std::size_t>(i)];
}

// Rotors of motors that do not turn alone: inertias of tendons whose lengths are the motor angles.
Xml mjcf_rotors(const RobotModel& robot, const MjcfExtras& extras) {
  Xml text;
  for (int k = 0; k < robot.n(); ++k)
    if (!turns_alone(robot, k))
      text += Xml::of("<fixed name={} armature=\"{:.17g}\"{}>\n{}</fixed>\n",
                      xml_attribute(motor_name(robot, k)), robot.pi[robot.armature_begin() + k],
                      attributes_of(extras.motor_attributes, k), motor_angle(robot, k));
  return text;
}

Xml mjcf_bodies(const data::ModelFile& model, const MjcfExtras& extras, int parent) {
  const RobotModel& robot = model.arm.robot;
  Xml text;
  for (const dynamics::Frame& frame : robot.frames) {
    if (frame.link != parent) continue;
    const Eigen::Quaterniond turn(frame.R);
    text += Xml::of("<site name={} pos=\"{}\" quat=\"{:.17g} {:.17g} {:.17g} {:.17g}\"/>\n",
                    xml_attribute(frame.name), numbers(frame.p), turn.w(), turn.x(), turn.y(),
                    turn.z());
  }
  for (int i = 0; i < robot.n(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    if (joint.parent != parent) continue;
    const Eigen::Quaterniond turn(joint.R0);
    const dynamics::Body b = body_of(model, i);
    double stiffness = 0;
    for (int k = 0; k < static_cast<int>(robot.linear_torques.size()); ++k) {
      const LinearTorque& torque = robot.linear_torques[static_cast<std::size_t>(k)];
      if (torque.joint == i && torque.shape == LinearTorque::Shape::kLinear)
        stiffness += robot.pi[robot.linear_begin() + k];
    }
    const bool limited = joint.upper > joint.lower && !joint.continuous;
    text += Xml::of(
        "<body name={} pos=\"{}\" quat=\"{:.17g} {:.17g} {:.17g} {:.17g}\">\n"
        "<joint name={} type={} axis=\"{}\" armature=\"{:.17g}\" stiffness=\"{:.17g}\"",
        xml_attribute(joint.link), numbers(joint.p0), turn.w(), turn.x(), turn.y(), turn.z(),
        xml_attribute(joint.name),
        xml_attribute(joint.type == JointType::kRevolute ? "hinge" : "slide"), numbers(joint.axis),
        turns_alone(robot, i) ? robot.pi[robot.armature_begin() + i] : 0, stiffness);
    if (limited)
      text += Xml::of(" limited=\"true\" range=\"{:.17g} {:.17g}\"", joint.lower, joint.upper);
    text += attributes_of(turns_alone(robot, i) ? extras.motor_attributes : std::vector<Xml>{}, i);
    text += Xml::of(
        "/>\n<inertial mass=\"{:.17g}\" pos=\"{}\" fullinertia=\"{:.17g} {:.17g} {:.17g} {:.17g} "
        "{:.17g} {:.17g}\"/>\n{}</body>\n",
        b.m, numbers(b.c), b.I(0, 0), b.I(1, 1), b.I(2, 2), b.I(0, 1), b.I(0, 2), b.I(1, 2),
        mjcf_bodies(model, extras, i));
  }
  return text;
}

}  // namespace

bool turns_alone(const RobotModel& robot, int motor) {
  return (robot.motors_of_joints().row(motor).array() != 0).count() == 1;
}

std::string motor_name(const RobotModel& robot, int motor) {
  return "motor of " + robot.joints[static_cast<std::size_t>(motor)].name;
}

Xml motor_angle(const RobotModel& robot, int motor) {
  const Eigen::MatrixXd C = robot.motors_of_joints();
  Xml text;
  for (int j = 0; j < robot.n(); ++j)
    if (C(motor, j) != 0)
      text += Xml::of("<joint joint={} coef=\"{:.17g}\"/>\n",
                      xml_attribute(robot.joints[static_cast<std::size_t>(j)].name), C(motor, j));
  return text;
}

std::string motors_in_words(const RobotModel& robot) {
  const Eigen::MatrixXd C = robot.motors_of_joints();
  std::string words;
  for (int k = 0; k < robot.n(); ++k) {
    if (turns_alone(robot, k)) continue;
    const std::string& own = robot.joints[static_cast<std::size_t>(k)].name;
    words += fmt::format("{}the motor of {} turns by", words.empty() ? "" : ", ", own);
    bool first = true;
    const auto add = [&](int j) {
      if (C(k, j) == 0) return;
      const char* sign = C(k, j) < 0 ? " -" : first ? "" : " +";
      const std::string factor =
          std::abs(C(k, j)) == 1 ? "" : fmt::format("{:.6g} ", std::abs(C(k, j)));
      words += fmt::format("{} {}{}", sign, factor, robot.joints[static_cast<std::size_t>(j)].name);
      first = false;
    };
    add(k);
    for (int j = 0; j < robot.n(); ++j)
      if (j != k) add(j);
  }
  return words;
}

std::string coordinates_in_words(const RobotModel& robot) {
  if (!robot.coupled()) return "";
  return fmt::format(
      "q, v and torques are those of the motors: {}; the torque of a joint is the sum of those of "
      "the motors, each times the factor of that joint",
      motors_in_words(robot));
}

Exported write_urdf(const data::ModelFile& model) {
  const RobotModel& robot = model.arm.robot;
  const std::string base = base_name(robot);
  Xml text = Xml::of("<?xml version=\"1.0\"?>\n{}<robot name={}>\n  <link name={}/>\n",
                     comment_of_doubt(model), xml_attribute(robot.name), xml_attribute(base));
  for (int i = 0; i < robot.n(); ++i) text += urdf_link(model, i) + urdf_joint(robot, i, base);
  for (const dynamics::Frame& frame : further_frames(robot)) text += urdf_frame(robot, frame, base);
  text += Xml::of("</robot>\n");
  Exported exported{.files = {{code_name(model) + ".urdf", text.text()}},
                    .losses = torques_left_out(robot, false)};
  exported.losses.emplace_back(kFrictionLeftOut);
  const Eigen::Vector3d g = robot.gravity;
  if (std::abs(g[0]) + std::abs(g[1]) > 1e-9 || g[2] > 0)
    exported.losses.push_back(
        fmt::format("URDF has no mount: gravity in the base frame is {:.6g} {:.6g} {:.6g} m/s^2",
                    g[0], g[1], g[2]));
  exported.losses.emplace_back("armature is in the element <fricid>, which other tools skip");
  return exported;
}

std::string mjcf_text(const data::ModelFile& model, const MjcfExtras& extras) {
  const RobotModel& robot = model.arm.robot;
  const Xml tendons = mjcf_rotors(robot, extras) + extras.tendons;
  return Xml::of(
             "{}{}<mujoco model={}>\n<compiler angle=\"radian\" balanceinertia=\"false\"/>\n"
             "<option gravity=\"{}\"/>\n<worldbody>\n{}</worldbody>\n{}{}</mujoco>\n",
             comment_of_doubt(model), extras.head, xml_attribute(robot.name),
             numbers(robot.gravity), mjcf_bodies(model, extras, -1),
             tendons.empty() ? tendons : Xml::of("<tendon>\n{}</tendon>\n", tendons), extras.rest)
      .text();
}

std::string doubt_in_words(const data::ModelFile& model) {
  if (model.doubts.empty()) return {};
  return fmt::format("{} is NOT TO BE TRUSTED: {}", model.name, model.doubts.front());
}

std::string title_of(const data::ModelFile& model) {
  return fmt::format("{}, robot {}{}{}", model.label, model.arm.robot.name,
                     model.doubts.empty() ? "" : "; ", doubt_in_words(model));
}

std::vector<std::string> torques_left_out(const RobotModel& robot, bool springs_said) {
  std::vector<std::string> losses;
  for (int i = 0; i < static_cast<int>(robot.linear_torques.size()); ++i) {
    const LinearTorque& torque = robot.linear_torques[static_cast<std::size_t>(i)];
    if (springs_said && torque.shape == LinearTorque::Shape::kLinear) continue;
    const bool slides = dynamics::slides(robot.joints[static_cast<std::size_t>(torque.joint)]);
    losses.push_back(fmt::format("the torque {} ({:.6g} {}) is left out", torque.name,
                                 robot.pi[robot.linear_begin() + i], unit_of_joint("N m", slides)));
  }
  return losses;
}

Exported write_mjcf(const data::ModelFile& model) {
  Exported exported{.files = {{code_name(model) + ".xml", mjcf_text(model, {})}},
                    .losses = torques_left_out(model.arm.robot, true)};
  exported.losses.emplace_back(kFrictionLeftOut);
  return exported;
}

}  // namespace fricid::deploy
