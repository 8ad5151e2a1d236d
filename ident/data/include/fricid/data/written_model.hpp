// A model file as it is written: fields by name, law by law. ModelFile is the same as a program
// uses it, see save_model and load_model.
#pragma once

#include <Eigen/Core>

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::data {

/// A number that is always there.
constexpr Field finite(std::string_view unit, std::string_view meaning) {
  return required(any_number(unit, meaning));
}
constexpr Field whole(double lower, double upper, std::string_view meaning) {
  return required(number("", lower, upper, meaning));
}

/// Inertia of a link about the origin of its joint frame, in that frame.
struct WrittenInertia {
  double Ixx = 0, Ixy = 0, Iyy = 0, Ixz = 0, Iyz = 0, Izz = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("Ixx", Ixx, finite("kg m^2", "about the origin of the joint frame"));
    archive("Ixy", Ixy, finite("kg m^2", "about the origin of the joint frame"));
    archive("Iyy", Iyy, finite("kg m^2", "about the origin of the joint frame"));
    archive("Ixz", Ixz, finite("kg m^2", "about the origin of the joint frame"));
    archive("Iyz", Iyz, finite("kg m^2", "about the origin of the joint frame"));
    archive("Izz", Izz, finite("kg m^2", "about the origin of the joint frame"));
  }
};

struct WrittenLink {
  double mass = 0;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();
  WrittenInertia inertia;

  template <class Archive>
  void visit(Archive& archive) {
    archive("mass", mass, finite("kg", "above 0"));
    archive("first_moment", first_moment, finite("kg m", "mass times centre of mass"));
    archive.section("inertia", inertia, "that of a body of this mass and first moment");
  }
};

struct WrittenJoint {
  dynamics::Joint joint;
  double armature = 0;
  WrittenLink moves;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", joint.name, text("of the joint"));
    archive("link", joint.link, text("name of the link that it moves"));
    archive("type", joint.type, choice("of a prismatic joint, angles are lengths in m"));
    archive("continuous", joint.continuous, flag("revolute without position limits"));
    archive("parent", joint.parent,
            whole(-1, 1e9, "index of the joint that moves the link before; -1: the base"));
    archive("R0", joint.R0, finite("1", "rotation of the joint frame in the parent's, at q = 0"));
    archive("p0", joint.p0, finite("m", "origin of the joint frame in the parent's"));
    archive("axis", joint.axis, finite("1", "unit vector in the joint frame"));
    archive("lower", joint.lower, any_number("rad", "position limit; null: continuous"));
    archive("upper", joint.upper, any_number("rad", "position limit; null: continuous"));
    archive("velocity", joint.velocity, required(not_negative("rad/s", "limit; 0: none")));
    archive("effort", joint.effort, required(not_negative("N m", "limit; 0: none")));
    archive("acceleration", joint.acceleration,
            required(not_negative("rad/s^2", "limit; 0: none")));
    archive("jerk", joint.jerk, required(not_negative("rad/s^3", "limit; 0: none")));
    archive("armature", armature,
            required(not_negative("kg m^2", "inertia of the rotor at the joint")));
    archive.section("moves", moves, "the link, in the joint frame");
  }
};

struct WrittenFrame {
  dynamics::Frame frame;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", frame.name, text("of the link that the frame stands for"));
    archive("link", frame.link, whole(-1, 1e9, "index of the joint that carries it; -1: the base"));
    archive("R", frame.R, finite("1", "rotation in the joint frame"));
    archive("p", frame.p, finite("m", "origin in the joint frame"));
  }
};

/// A torque c phi(q) on one joint.
struct WrittenTorque {
  dynamics::LinearTorque torque;
  double c = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", torque.name, text("for tables"));
    archive("joint", torque.joint, whole(0, 1e9, "index of the joint"));
    archive("shape", torque.shape, choice("phi(q)"));
    archive("k", torque.k, finite("1/rad", "of the shape"));
    archive("c", c, finite("N m", "factor of the shape"));
  }
};

struct WrittenCoupling {
  dynamics::Coupling coupling;

  template <class Archive>
  void visit(Archive& archive) {
    archive("joint", coupling.joint, whole(0, 1e9, "index of the joint that turns too"));
    archive("motor", coupling.motor, whole(0, 1e9, "index of the motor that turns it"));
    archive("factor", coupling.factor, finite("1", "turns of the joint per turn of the motor"));
  }
};

struct WrittenRobot {
  std::string name;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  std::vector<WrittenJoint> joints = {};
  std::vector<WrittenFrame> frames = {};
  std::vector<WrittenTorque> linear_torques = {};
  std::optional<std::vector<WrittenCoupling>> couplings = {};

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("of the robot"));
    archive("gravity", gravity, finite("m/s^2", "in the base frame"));
    archive.sections("joints", joints, "from the base to the tool");
    archive.sections("frames", frames, "fixed to links");
    archive.sections("linear_torques", linear_torques, "torques c phi(q), as of springs");
    archive.sections("couplings", couplings, "motors that turn a further joint too");
  }
};

/// A parameter of a law; its bounds are those of the table of laws.
struct WrittenParameter {
  double value = 0;
  std::string unit;

  template <class Archive>
  void visit(Archive& archive) {
    archive("value", value, finite("", "within the bounds of the law's table"));
    archive(
        "unit", unit,
        text("of the value: that of the law's table; of a joint that slides N for N m, m for rad"));
  }
};

/// By symbol, in the order of the law's table.
using WrittenParameters = std::vector<std::pair<std::string, WrittenParameter>>;

struct WrittenModifier {
  std::string modifier;
  int order = 1;
  WrittenParameters parameters;

  template <class Archive>
  void visit(Archive& archive) {
    archive("modifier", modifier, text("name of the modifier"));
    archive("order", order, whole(0, 1e9, "number of terms; 1 for modifiers with one"));
    archive.named("parameters", "SYMBOL", parameters, "every parameter of the modifier");
  }
};

struct WrittenLaw {
  std::string law;
  int elements = 0;
  WrittenParameters parameters;
  std::vector<WrittenModifier> modifiers;

  template <class Archive>
  void visit(Archive& archive) {
    archive("law", law, text("name of the law"));
    archive("elements", elements, whole(0, 1e9, "of laws that have elements; else 0"));
    archive.named("parameters", "SYMBOL", parameters, "every parameter of the law");
    archive.sections("modifiers", modifiers, "that apply to the law, innermost first");
  }
};

struct WrittenRobotLaw {
  std::string law;
  int elements = 0;
  WrittenParameters parameters;
  std::optional<int> latents;

  template <class Archive>
  void visit(Archive& archive) {
    archive("law", law, text("name of the law"));
    archive("elements", elements, whole(0, 1e9, "width of its networks"));
    archive.named("parameters", "SYMBOL", parameters, "every parameter of the law");
    archive("n_z", latents, whole(1, 1e9, "latent states; only of laws that have them"));
  }
};

struct WrittenNoise {
  double sample_s = 0;
  Eigen::VectorXd variance_q, variance_v, variance_z, variance_observation;
  std::optional<Eigen::VectorXd> variance_friction;

  template <class Archive>
  void visit(Archive& archive) {
    constexpr auto variance = [](std::string_view unit, std::string_view meaning) {
      return required(number(unit, std::numeric_limits<double>::min(),
                             std::numeric_limits<double>::max(), meaning));
    };
    archive("sample_s", sample_s, required(number("s", 1e-9, 1e9, "period of one transition")));
    archive("variance_q", variance_q, variance("rad^2", "of the transition, per joint"));
    archive("variance_v", variance_v, variance("rad^2/s^2", "of the transition, per joint"));
    archive("variance_z", variance_z, variance("", "of the transition, per friction state"));
    archive("variance_observation", variance_observation,
            variance("rad^2", "of q per joint, then of v if it is measured"));
    archive("variance_friction", variance_friction,
            not_negative("N^2 m^2", "per joint, of what the law leaves of the friction torque"));
  }
};

/// The whole file.
struct WrittenModel {
  static constexpr std::string_view kFormat = "fricid.model/1";

  std::string name, label;
  int seed = 1;
  bool is_oracle = false;
  int free_parameters = 0;
  std::optional<std::string> budget;
  std::optional<std::vector<std::string>> doubts;
  WrittenRobot robot;
  std::vector<std::vector<WrittenLaw>> friction = {};
  std::optional<WrittenRobotLaw> friction_of_robot = {};
  std::optional<WrittenNoise> noise = {};

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("of the model"));
    archive("label", label, text("name in tables and plots"));
    archive("seed", seed, whole(0, 1e9, "of the fit"));
    archive("is_oracle", is_oracle, flag("the true model"));
    archive("free_parameters", free_parameters, whole(0, 1e9, "number of fitted values"));
    archive("budget", budget, text("training budget; empty: none"));
    archive("doubts", doubts, text("why the fit is not to be trusted; absent: it may be"));
    archive.section("robot", robot, "kinematic tree with inertia");
    archive.lists("friction", friction, "per joint, the laws whose torques add up");
    archive.section("friction_of_robot", friction_of_robot, "one law that sees all joints");
    archive.section("noise", noise, "for filters: of the transition and of the measurement");
  }
};

}  // namespace fricid::data
