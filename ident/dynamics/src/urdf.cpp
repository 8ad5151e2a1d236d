#include <console_bridge/console.h>
#include <tinyxml2.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <mutex>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/names.hpp"
#include "fricid/dynamics/rest_positions.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::dynamics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// files round moments of inertia, so a thin body may miss the triangle inequality by this share
constexpr double kRounding = 1e-3;

/// Keeps what urdfdom would print. Its errors come from the inside out, so joined they name the
/// number, then the link.
class Messages : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    if (!errors_.empty()) errors_ += "; ";
    for (const char c : text) errors_ += c == '\n' ? ' ' : c;
  }
  const std::string& errors() const { return errors_; }

 private:
  std::string errors_;
};

/// @throws UserError on anything that urdfdom calls an error, even where it goes on with zeros
urdf::ModelInterfaceSharedPtr parse_tree(const std::string& text, const std::string& source) {
  static std::mutex console;  // console_bridge has one handler per process
  const std::lock_guard lock(console);
  Messages messages;
  console_bridge::useOutputHandler(&messages);
  urdf::ModelInterfaceSharedPtr tree = urdf::parseURDF(text);
  console_bridge::restorePreviousOutputHandler();
  if (!messages.errors().empty()) throw UserError("{}: {}", source, messages.errors());
  if (!tree) throw UserError("{}: not a URDF", source);
  return tree;
}

/// Information that urdfdom does not give: line numbers, order in the file, the <fricid> element.
struct JointElement {
  int line = 0;
  int order = 0;
  double armature = 0, acceleration = 0, jerk = 0;
};
struct Document {
  std::string source;
  std::map<std::string, int> link_lines;
  std::map<std::string, JointElement> joints;

  std::string at_link(const std::string& name) const {
    return fmt::format("{}:{}: link {}", source, link_lines.at(name), name);
  }
  std::string at_joint(const std::string& name) const {
    return fmt::format("{}:{}: joint {}", source, joints.at(name).line, name);
  }
};

double non_negative(const tinyxml2::XMLAttribute& attribute, const std::string& place) {
  double value = 0;
  if (attribute.QueryDoubleValue(&value) != tinyxml2::XML_SUCCESS || !std::isfinite(value) ||
      value < 0)
    throw UserError("{}: fricid {} = \"{}\"; must be a number >= 0", place, attribute.Name(),
                    attribute.Value());
  return value;
}

/// urdfdom refuses elements without a name.
void check_name(Named kind, const tinyxml2::XMLElement& element, const std::string& source) {
  if (const char* name = element.Attribute("name"))
    require_name(kind, name, fmt::format("{}:{}", source, element.GetLineNum()));
}

/// Limits that urdfdom demands. @throws UserError naming what is missing
void require_limit(const tinyxml2::XMLElement& joint, const std::string& place) {
  const std::string_view type = joint.Attribute("type") ? joint.Attribute("type") : "";
  if (type != "revolute" && type != "prismatic") return;
  const tinyxml2::XMLElement* limit = joint.FirstChildElement("limit");
  if (limit && limit->Attribute("effort") && limit->Attribute("velocity")) return;
  const std::string_view missing = !limit                        ? ""
                                   : !limit->Attribute("effort") ? " with effort"
                                                                 : " with velocity";
  throw UserError(
      "{}: {} without <limit>{}; allowed: <limit lower= upper= velocity= effort=/> (0: no limit of "
      "velocity or effort){}, or type=\"fixed\"",
      place, type, missing,
      type == "revolute" ? ", type=\"continuous\" where it turns without end" : "");
}

Document read_document(const std::string& text, const std::string& source) {
  tinyxml2::XMLDocument xml;
  if (xml.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    throw UserError("{}:{}: not well-formed XML ({})", source, xml.ErrorLineNum(), xml.ErrorName());
  const tinyxml2::XMLElement* robot = xml.FirstChildElement("robot");
  if (!robot) throw UserError("{}: no <robot> element", source);
  for (auto* e = robot->FirstChildElement(); e; e = e->NextSiblingElement())
    if (std::string_view(e->Name()).starts_with("xacro:"))
      throw UserError(
          "{}:{}: <{}> is a macro that was not expanded; allowed: a URDF, as `xacro FILE > "
          "robot.urdf` "
          "writes it",
          source, e->GetLineNum(), e->Name());

  Document document{.source = source, .link_lines = {}, .joints = {}};
  check_name(Named::kRobot, *robot, source);
  std::int64_t links = 0;  // urdfdom and Builder go down the tree link by link
  for (auto* e = robot->FirstChildElement("link"); e; e = e->NextSiblingElement("link")) ++links;
  require_within(limits::kLinks, links, source);
  for (auto* e = robot->FirstChildElement("link"); e; e = e->NextSiblingElement("link")) {
    check_name(Named::kLink, *e, source);
    if (e->Attribute("name")) document.link_lines[e->Attribute("name")] = e->GetLineNum();
  }
  int order = 0;
  for (auto* e = robot->FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
    check_name(Named::kJoint, *e, source);
    if (!e->Attribute("name")) continue;
    JointElement& joint = document.joints[e->Attribute("name")];
    joint.line = e->GetLineNum();
    joint.order = order++;
    require_limit(*e, document.at_joint(e->Attribute("name")));
    const tinyxml2::XMLElement* own = e->FirstChildElement("fricid");
    if (!own) continue;
    const std::string place = document.at_joint(e->Attribute("name"));
    for (auto* a = own->FirstAttribute(); a; a = a->Next()) {
      const std::string_view key = a->Name();
      if (key == "armature") {
        joint.armature = non_negative(*a, place);
      } else if (key == "acceleration") {
        joint.acceleration = non_negative(*a, place);
      } else if (key == "jerk") {
        joint.jerk = non_negative(*a, place);
      } else {
        throw UserError("{}: fricid: unknown attribute \"{}\"; known: armature, acceleration, jerk",
                        place, key);
      }
    }
  }
  return document;
}

Vector3d to_eigen(const urdf::Vector3& a) { return {a.x, a.y, a.z}; }

Matrix3d to_eigen(const urdf::Rotation& r) {
  return Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
}

Matrix3d inertia_matrix(const urdf::Inertial& i) {
  return Matrix3d{{i.ixx, i.ixy, i.ixz}, {i.ixy, i.iyy, i.iyz}, {i.ixz, i.iyz, i.izz}};
}

// What no arm exceeds: beyond it a file is not in metres and kilograms.
constexpr double kLongest = 20, kHeaviest = 5000;  // [m] from the first joint, [kg] of a link

/// @throws UserError unless mass > 0 (or nothing at all) and the inertia is that of a body
void check_inertial(const urdf::Inertial& inertial, const std::string& place) {
  const Matrix3d I = inertia_matrix(inertial);
  if (inertial.mass == 0 && I.isZero(0)) return;
  if (!(inertial.mass > 0)) throw UserError("{}: mass = {} kg; must be > 0", place, inertial.mass);
  if (inertial.mass > kHeaviest)
    throw UserError(
        "{}: mass = {:.6g} kg; allowed: up to {} kg; a URDF is in kilograms and metres: this one "
        "seems to be in grams (masses and moments of inertia times 0.001)",
        place, inertial.mass, kHeaviest);
  const Vector3d moments = Eigen::SelfAdjointEigenSolver<Matrix3d>(I).eigenvalues();
  const double trace = moments.sum();
  constexpr std::string_view kRemedy =
      "; correct its <inertia>, or take the nearest that a body can have: mend_inertia = true in "
      "[robot] of a scene, --mend-inertia beside --robot";
  if (moments(0) < -kRounding * std::abs(trace))
    throw UserError("{}: principal moment of inertia {:.4g} kg m^2; must be > 0{}", place,
                    moments(0), kRemedy);
  if (moments(2) > (0.5 + kRounding) * trace)
    throw UserError(
        "{}: principal moments of inertia {:.4g}, {:.4g}, {:.4g} kg m^2; the largest must not "
        "exceed the sum of the other two{}",
        place, moments(0), moments(1), moments(2), kRemedy);
}

/// Replaces an inertia that no body has by the nearest one, see `load_urdf`. @return whether it did
bool mend(urdf::Inertial& inertial) {
  constexpr double kThin = 0.01;
  const Matrix3d I = inertia_matrix(inertial);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> mass(
      Matrix3d(I.trace() / 2 * Matrix3d::Identity() - I));
  const Vector3d& moments = mass.eigenvalues();
  if (moments(0) >= -kRounding / 2 * I.trace() || !(moments(2) > 0)) return false;
  const Matrix3d mended = mass.eigenvectors() * moments.cwiseMax(kThin * moments(2)).asDiagonal() *
                          mass.eigenvectors().transpose();
  const Matrix3d J = mended.trace() * Matrix3d::Identity() - mended;
  inertial.ixx = J(0, 0), inertial.iyy = J(1, 1), inertial.izz = J(2, 2);
  inertial.ixy = J(0, 1), inertial.ixz = J(0, 2), inertial.iyz = J(1, 2);
  return true;
}

bool moves(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS ||
         joint.type == urdf::Joint::PRISMATIC;
}

/// Walks the tree from the base, adds joints, lumps links behind fixed joints.
class Builder {
 public:
  Builder(const urdf::ModelInterface& tree, const Document& document, const Welds& welds,
          bool mend_inertia)
      : document_(document), welds_(welds.at), mend_inertia_(mend_inertia) {
    check_welds(tree, welds.where);
    weld_followers(tree, welds.where);
    model_.name = tree.getName();
    walk(*tree.getRoot());
    if (model_.joints.empty())
      throw UserError("{}: no revolute, continuous or prismatic joint", document_.source);
    check_moving();
    check_reach();
    fill_armature();
  }
  RobotModel model() && { return std::move(model_); }

 private:
  /// A link to visit, behind a joint (null: the base) of a link at `parent`.
  struct Visit {
    const urdf::Link* link;
    const urdf::Joint* joint;
    Frame parent;  ///< in the moving link (or base) that carries it
  };

  /// Depth first, the joints of a link in the order of the file. Without recursion: a chain may be
  /// as long as the stack is deep.
  void walk(const urdf::Link& base) {
    std::vector<Visit> next{{&base, nullptr, Frame{}}};
    while (!next.empty()) {
      const Visit visit = next.back();
      next.pop_back();
      const Frame frame = enter(visit);
      auto joints = visit.link->child_joints;
      std::ranges::sort(joints, std::greater<>(), [this](const auto& joint) {
        return document_.joints.at(joint->name).order;
      });
      for (const auto& joint : joints) {
        const auto child = std::ranges::find(visit.link->child_links, joint->child_link_name,
                                             [](const auto& link) { return link->name; });
        next.push_back({child->get(), joint.get(), frame});
      }
    }
  }

  /// Adds the joint, the frame and the inertia of a link. @return the frame
  Frame enter(const Visit& visit) {
    Frame frame = visit.joint == nullptr ? Frame{} : behind(*visit.joint, visit.parent);
    const urdf::Link& link = *visit.link;
    frame.name = link.name;
    model_.frames.push_back(frame);
    if (link.inertial && frame.link >= 0) {  // inertia of the base is not used
      if (mend_inertia_ && mend(*link.inertial)) model_.mended_links.push_back(link.name);
      check_inertial(*link.inertial, document_.at_link(link.name));
      add_payload(model_, frame, link.inertial->mass, to_eigen(link.inertial->origin.position),
                  inertia_about_com(*link.inertial));
    }
    return frame;
  }

  /// The frame behind a joint, which is added if it moves.
  Frame behind(const urdf::Joint& joint, const Frame& parent) {
    Frame placed = parent;
    const urdf::Pose& origin = joint.parent_to_joint_origin_transform;
    placed.p = parent.R * to_eigen(origin.position) + parent.p;
    placed.R = parent.R * to_eigen(origin.rotation);
    if (joint.type == urdf::Joint::FIXED) return placed;
    if (const auto weld = welds_.find(joint.name); weld != welds_.end()) {
      move(joint, weld->second, placed);
      return placed;
    }
    add_joint(joint, placed);
    return {.name = "", .link = model_.n() - 1};
  }

  static Matrix3d inertia_about_com(const urdf::Inertial& inertial) {
    const Matrix3d R = to_eigen(inertial.origin.rotation);
    return R * inertia_matrix(inertial) * R.transpose();
  }

  /// @throws UserError for a weld of an unknown or fixed joint, or beyond its limits
  void check_welds(const urdf::ModelInterface& tree, const std::string& where) const {
    std::vector<std::string> known;
    for (const auto& [name, joint] : tree.joints_)
      if (moves(*joint)) known.push_back(name);
    for (const auto& [name, position] : welds_) {
      if (std::ranges::find(known, name) == known.end())
        throw UserError("{}: {} is not a moving joint of {}; allowed: {}", where, name,
                        document_.source, fmt::join(known, ", "));
      const urdf::Joint& joint = *tree.joints_.at(name);
      if (joint.type == urdf::Joint::CONTINUOUS || !joint.limits) continue;
      if (position < joint.limits->lower || position > joint.limits->upper)
        throw UserError("{}: {} = {:g}; allowed: {:g} to {:g} {}, its limits in {}", where, name,
                        position, joint.limits->lower, joint.limits->upper,
                        joint.type == urdf::Joint::PRISMATIC ? "m" : "rad", document_.source);
    }
  }

  /// Welds joints that mimic a welded joint, directly or through others.
  void weld_followers(const urdf::ModelInterface& tree, const std::string& where) {
    for (bool found = true; found;) {
      found = false;
      for (const auto& [name, joint] : tree.joints_) {
        if (!joint->mimic || welds_.contains(name)) continue;
        const auto leader = welds_.find(joint->mimic->joint_name);
        if (leader == welds_.end()) continue;
        welds_[name] = joint->mimic->multiplier * leader->second + joint->mimic->offset;
        found = true;
      }
    }
    for (const auto& [name, position] : welds_)
      if (tree.joints_.at(name)->mimic) check_follower(tree, name, position, where);
  }

  /// @throws UserError for a welded joint that mimics one which moves or is welded elsewhere
  void check_follower(const urdf::ModelInterface& tree, const std::string& name, double position,
                      const std::string& where) const {
    constexpr double kWritten = 1e-4;  // [rad or m] to which a file rounds a position
    const urdf::JointMimic& mimic = *tree.joints_.at(name)->mimic;
    if (const auto leader = welds_.find(mimic.joint_name); leader != welds_.end()) {
      const double follows = mimic.multiplier * leader->second + mimic.offset;
      if (std::abs(position - follows) > kWritten)
        throw UserError(
            "{}: {} = {:g}, but by its <mimic> in {} it is {:g} where {} = {:g}; allowed: {:g}, or "
            "leave {} out",
            where, name, position, document_.source, follows, mimic.joint_name, leader->second,
            follows, name);
      return;
    }
    const auto leader = tree.joints_.find(mimic.joint_name);
    if (leader != tree.joints_.end() && moves(*leader->second))
      throw UserError(
          "{}: is fixed, but its <mimic> follows {}, which moves; allowed: both fixed by [robot] "
          "fix, or no <mimic>",
          document_.at_joint(name), mimic.joint_name);
  }

  /// Moves a frame along a joint to a position.
  static void move(const urdf::Joint& joint, double position, Frame& frame) {
    const Vector3d axis = to_eigen(joint.axis).normalized();
    if (joint.type == urdf::Joint::PRISMATIC)
      frame.p += frame.R * axis * position;
    else
      frame.R = frame.R * Eigen::AngleAxisd(position, axis).toRotationMatrix();
  }

  void add_joint(const urdf::Joint& joint, const Frame& placed) {
    const std::string place = document_.at_joint(joint.name);
    const JointElement& element = document_.joints.at(joint.name);
    if (!moves(joint))
      throw UserError("{}: type is {}; allowed: revolute, continuous, prismatic, fixed", place,
                      joint.type == urdf::Joint::PLANAR ? "planar" : "floating");
    if (joint.mimic)
      throw UserError(
          "{}: <mimic> follows {}, which moves; each joint must be free: fix both at a position "
          "by [robot] fix = {{{} = POSITION}}, or remove <mimic>",
          place, joint.mimic->joint_name, joint.mimic->joint_name);
    const Vector3d axis = to_eigen(joint.axis);
    if (!(axis.norm() > 1e-6))
      throw UserError("{}: axis = ({}, {}, {}); must not be zero", place, axis.x(), axis.y(),
                      axis.z());

    Joint added;
    added.name = joint.name;
    added.link = joint.child_link_name;
    added.type =
        joint.type == urdf::Joint::PRISMATIC ? JointType::kPrismatic : JointType::kRevolute;
    added.continuous = joint.type == urdf::Joint::CONTINUOUS;
    added.parent = placed.link;
    added.R0 = placed.R;
    added.p0 = placed.p;
    added.axis = axis.normalized();
    if (joint.limits) {
      added.lower = joint.limits->lower;
      added.upper = joint.limits->upper;
      added.velocity = joint.limits->velocity;
      added.effort = joint.limits->effort;
    }
    added.acceleration = element.acceleration;
    added.jerk = element.jerk;
    check_limits(added, place);
    model_.joints.push_back(added);
    model_.pi.conservativeResize(model_.pi.size() + 10);
    model_.pi.tail<10>().setZero();
  }

  static void check_limits(Joint& joint, const std::string& place) {
    if (joint.continuous) {
      joint.lower = -std::numeric_limits<double>::infinity();
      joint.upper = std::numeric_limits<double>::infinity();
    } else if (!(joint.lower < joint.upper)) {
      throw UserError(
          "{}: limits lower = {}, upper = {}; lower must be below upper, or the joint fixed: "
          "robot.fix = {{{} = {}}} in a scene",
          place, joint.lower, joint.upper, joint.name, joint.lower);
    }
    if (!(joint.velocity >= 0))
      throw UserError("{}: limit velocity = {}; must be >= 0", place, joint.velocity);
    if (!(joint.effort >= 0))
      throw UserError("{}: limit effort = {}; must be >= 0", place, joint.effort);
  }

  void check_moving() const {
    for (int i = 0; i < model_.n(); ++i) {
      if (model_.pi(10 * i) > 0) continue;
      const Joint& joint = model_.joints[static_cast<size_t>(i)];
      throw UserError("{}: moved by joint {} but without mass; needs <inertial> with mass > 0",
                      document_.at_link(joint.link), joint.name);
    }
  }

  /// The way along the links to each joint, and to the centre of mass behind it.
  void check_reach() const {
    std::vector<double> way(static_cast<std::size_t>(model_.n()), 0.0);
    for (int i = 0; i < model_.n(); ++i) {
      const auto j = static_cast<std::size_t>(i);
      const Joint& joint = model_.joints[j];
      if (joint.parent >= 0) way[j] = way[static_cast<std::size_t>(joint.parent)] + joint.p0.norm();
      const double reach = way[j] + model_.pi.segment<3>(10 * i + 1).norm() / model_.pi(10 * i);
      if (reach > kLongest)
        throw UserError(
            "{}: its link reaches {:.4g} m from the first joint; allowed: up to {} m; a URDF is in "
            "metres: this one seems to be in millimetres (lengths times 0.001, moments of inertia "
            "of kg mm^2 times 1e-6)",
            document_.at_joint(joint.name), reach, kLongest);
    }
  }

  void fill_armature() {
    model_.pi.conservativeResize(model_.parameter_count());
    for (int i = 0; i < model_.n(); ++i)
      model_.pi(model_.armature_begin() + i) =
          document_.joints.at(model_.joints[static_cast<size_t>(i)].name).armature;
  }

  const Document& document_;
  std::map<std::string, double> welds_;
  bool mend_inertia_;
  RobotModel model_;
};

}  // namespace

std::map<std::string, double> rest_positions(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  read_document(text, path.string());
  std::map<std::string, double> positions;
  const urdf::ModelInterfaceSharedPtr tree = parse_tree(text, path.string());
  for (const auto& [name, joint] : tree->joints_) {
    if (!moves(*joint) || joint->mimic) continue;
    double position = 0;
    if (joint->limits && joint->type != urdf::Joint::CONTINUOUS)
      position = std::max(joint->limits->lower, std::min(joint->limits->upper, position));
    positions[name] = position;
  }
  return positions;
}

RobotModel load_urdf(const std::filesystem::path& path, const Matrix3d& mount, const Welds& welds,
                     bool mend_inertia) {
  return parse_urdf(read_file(path), path.string(), mount, welds, mend_inertia);
}

RobotModel parse_urdf(const std::string& text, const std::string& source_name,
                      const Matrix3d& mount, const Welds& welds, bool mend_inertia) {
  const Document document = read_document(text, source_name);
  const urdf::ModelInterfaceSharedPtr tree = parse_tree(text, source_name);
  RobotModel model = Builder(*tree, document, welds, mend_inertia).model();
  model.gravity = mount.transpose() * Vector3d(0, 0, -9.81);
  return model;
}

}  // namespace fricid::dynamics
