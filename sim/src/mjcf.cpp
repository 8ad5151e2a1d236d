#include "fricid/sim/mjcf.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "fricid/base/names.hpp"
#include "fricid/base/xml.hpp"
#include "fricid/dynamics/body.hpp"

namespace fricid::sim {
namespace {

Xml numbers(const Eigen::Vector3d& x) {
  return Xml::of("{:.17g} {:.17g} {:.17g}", x[0], x[1], x[2]);
}

// Mass, centre and central inertia of link i from the standard parameters.
Xml inertial(const dynamics::RobotModel& robot, int i) {
  const auto [m, c, I] = dynamics::body_of(robot.pi.segment<10>(10 * i));
  return Xml::of(
      "<inertial mass=\"{:.17g}\" pos=\"{}\" fullinertia=\"{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} "
      "{:.17g}\"/>\n",
      m, numbers(c), I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
}

// A capsule from the joint to the next joint of the link, or to its centre of mass.
Xml shape(const Eigen::Vector3d& end) {
  constexpr double kThickness = 0.12, kThinnest = 0.015;  // share of the length, [m]
  const double length = end.norm();
  const Xml looks = Xml::of("contype=\"0\" conaffinity=\"0\" rgba=\"0.85 0.45 0.1 1\"/>\n");
  if (length < kThinnest) return Xml::of("<geom type=\"sphere\" size=\"0.03\" {}", looks);
  return Xml::of("<geom type=\"capsule\" size=\"{:.4g}\" fromto=\"0 0 0 {}\" {}",
                 std::max(kThinnest, kThickness * length), numbers(end), looks);
}

Xml bodies_of(const dynamics::RobotModel& robot, int parent) {
  Xml text;
  for (int i = 0; i < robot.n(); ++i) {
    const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    if (joint.parent != parent) continue;
    const Eigen::Quaterniond turn(joint.R0);
    Eigen::Vector3d end = robot.pi.segment<3>(10 * i + 1) / robot.pi[10 * i];
    for (const dynamics::Joint& child : robot.joints)
      if (child.parent == i && child.p0.norm() > end.norm()) end = child.p0;
    const bool revolute = joint.type == dynamics::JointType::kRevolute;
    text += Xml::of(
        "<body name={} pos=\"{}\" quat=\"{:.17g} {:.17g} {:.17g} {:.17g}\">\n"
        "<joint name={} type={} axis=\"{}\" armature=\"{:.17g}\"/>\n",
        xml_attribute(joint.link), numbers(joint.p0), turn.w(), turn.x(), turn.y(), turn.z(),
        xml_attribute(joint.name), xml_attribute(revolute ? "hinge" : "slide"), numbers(joint.axis),
        robot.pi[robot.armature_begin() + i]);
    text += inertial(robot, i) + shape(end) + bodies_of(robot, i) + Xml::of("</body>\n");
  }
  return text;
}

}  // namespace

std::string mjcf_of(const dynamics::RobotModel& robot) {
  constexpr double kColumn = 0.04;  // [m] radius of what carries the first joints
  Xml carrier =
      Xml::of("<geom type=\"cylinder\" size=\"0.06 0.02\" contype=\"0\" conaffinity=\"0\"/>\n");
  for (const dynamics::Joint& joint : robot.joints)
    if (joint.parent < 0 && joint.p0.norm() > kColumn)
      carrier += Xml::of(
          "<geom type=\"capsule\" size=\"{}\" fromto=\"0 0 0 {}\" contype=\"0\" "
          "conaffinity=\"0\"/>\n",
          kColumn, numbers(joint.p0));
  return Xml::of(
             "<mujoco model={}>\n<compiler angle=\"radian\" balanceinertia=\"false\"/>\n"
             "<option gravity=\"0 0 {:.17g}\"/>\n"
             "<visual>\n<global offwidth=\"1920\" offheight=\"1080\" fovy=\"32\"/>\n"
             "<headlight ambient=\"0.35 0.35 0.36\" diffuse=\"0.3 0.3 0.3\"/>\n</visual>\n"
             "<asset>\n<texture type=\"skybox\" builtin=\"gradient\" width=\"256\" height=\"1536\" "
             "rgb1=\"0.78 0.82 0.87\" rgb2=\"0.9 0.915 0.935\"/>\n</asset>\n"
             "<worldbody>\n<light directional=\"true\" pos=\"1.6 -2 4\" dir=\"-0.5 0.55 -1\" "
             "diffuse=\"0.6 0.6 0.58\"/>\n"
             "<body name=\"carrier of the robot\">\n{}{}</body>\n</worldbody>\n</mujoco>\n",
             xml_attribute(robot.name), -robot.gravity.norm(), carrier, bodies_of(robot, -1))
      .text();
}

}  // namespace fricid::sim
