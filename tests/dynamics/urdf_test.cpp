// What the URDF reader understands, and what it says when it does not.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/dynamics/physical_inertia.hpp"
#include "fricid/dynamics/rest_positions.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "robots.hpp"
#include "source_dir.hpp"
#include "temporary_folder.hpp"

namespace fricid::dynamics::test {
namespace {

const std::string kInertial =
    R"(<inertial><origin xyz="0 0 0.1"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" )"
    R"(ixy="0" ixz="0" iyz="0"/></inertial>)";
const std::string kLimit = R"(<limit lower="-1" upper="1" velocity="2" effort="3"/>)";

/// One joint "turn" of link "arm", on lines 3 and 4 of the file.
std::string one_joint(const std::string& inertial = kInertial, const std::string& limit = kLimit,
                      const std::string& type = "revolute",
                      const std::string& axis = R"(<axis xyz="0 0 1"/>)") {
  return "<robot name=\"r\">\n<link name=\"base\"/>\n<link name=\"arm\">" + inertial +
         "</link>\n<joint name=\"turn\" type=\"" + type +
         R"("><parent link="base"/><child link="arm"/>)" + axis + limit + "</joint>\n</robot>\n";
}

std::string inertial(const std::string& mass, const std::string& inertia) {
  return "<inertial><mass value=\"" + mass + "\"/><inertia " + inertia +
         R"( ixy="0" ixz="0" iyz="0"/></inertial>)";
}

std::string message(const std::string& text) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  std::string what = "no error";
  try {
    parse_urdf(text, "r.urdf");
  } catch (const UserError& error) {
    what = error.what();
  }
  // the parser's own messages stay unheard
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  return what;
}

TEST(Urdf, ReadsJointsLimitsAndOwnElement) {
  const RobotModel model = parse_urdf(
      one_joint(kInertial, kLimit + R"(<fricid armature="0.4" acceleration="9" jerk="80"/>)"),
      "r.urdf");
  ASSERT_EQ(model.n(), 1);
  const Joint& joint = model.joints[0];
  EXPECT_EQ(joint.name, "turn");
  EXPECT_EQ(joint.link, "arm");
  EXPECT_EQ(joint.parent, -1);
  EXPECT_EQ(joint.lower, -1);
  EXPECT_EQ(joint.upper, 1);
  EXPECT_EQ(joint.velocity, 2);
  EXPECT_EQ(joint.effort, 3);
  EXPECT_EQ(joint.acceleration, 9);
  EXPECT_EQ(joint.jerk, 80);
  EXPECT_EQ(model.gravity, Vector3d(0, 0, -9.81));
  const VectorXd pi{{1, 0, 0, 0.1, 0.02, 0, 0.02, 0, 0, 0.01, 0.4}};
  EXPECT_TRUE(close(model.pi, pi, 1e-15));
  EXPECT_EQ(model.parameter_names()[1], "turn m cx");
  EXPECT_EQ(model.parameter_names().back(), "turn Ia");
}

TEST(Urdf, ContinuousHasNoPositionLimits) {
  const RobotModel model = parse_urdf(one_joint(kInertial, "", "continuous"), "r.urdf");
  EXPECT_TRUE(model.joints[0].continuous);
  EXPECT_TRUE(std::isinf(model.joints[0].upper));
}

TEST(Urdf, KeepsEveryLinkAsAFrameAndTheOrderOfTheFile) {
  const RobotModel model = load("test/branched.urdf");
  std::vector<std::string> joints, frames;
  for (const Joint& joint : model.joints) joints.push_back(joint.name);
  for (const Frame& frame : model.frames) frames.push_back(frame.name);
  EXPECT_EQ(joints, (std::vector<std::string>{"waist", "left_shoulder", "left_elbow", "right_slide",
                                              "right_shoulder"}));
  EXPECT_EQ(frames, (std::vector<std::string>{"base", "pedestal", "torso", "head", "left_upper",
                                              "left_mount", "left_lower", "left_tool", "right_rail",
                                              "right_arm", "right_tip"}));
  EXPECT_EQ(model.frames[1].link, -1);
  EXPECT_EQ(model.frames[3].link, 0);
  EXPECT_DOUBLE_EQ(model.pi(0), 9 + 1.5);  // torso with the head behind a fixed joint
}

TEST(Urdf, IgnoresWhatDynamicsDoesNotNeed) {
  std::string text = one_joint();
  text.insert(text.find("</link>"), R"(<visual><geometry><mesh filename="package://none/arm.stl"/>
    </geometry></visual><collision><geometry><box size="1 1 1"/></geometry></collision>)");
  text.insert(text.find("</robot>"),
              R"(<transmission name="t"><type>x</type></transmission><gazebo reference="arm"/>)");
  EXPECT_EQ(parse_urdf(text, "r.urdf").n(), 1);
}

TEST(Urdf, ReadsAThinPlateWithRoundedMoments) {
  EXPECT_EQ(message(one_joint(inertial("1", R"(ixx="0.0333" iyy="0.0333" izz="0.06666")"))),
            "no error");
}

TEST(Urdf, TheBaseMayHaveAnyInertia) {
  std::string text = one_joint();
  const std::string base = "<link name=\"base\"/>";
  text.replace(text.find(base), base.size(),
               "<link name=\"base\">" + inertial("1", R"(ixx="1" iyy="1" izz="3")") + "</link>");
  EXPECT_EQ(message(text), "no error");
}

RobotModel mended(const std::string& inertia) {
  return parse_urdf(one_joint(inertial("1", inertia)), "r.urdf", Eigen::Matrix3d::Identity(), {},
                    true);
}

// A plate: its largest moment stays, up to a hundredth of the larger second moment of its mass.
TEST(Urdf, AnInertiaThatNoBodyHasIsMendedWhereAskedFor) {
  const RobotModel model = mended(R"(ixx="1" iyy="1.5" izz="3")");
  EXPECT_EQ(model.mended_links, std::vector<std::string>{"arm"});
  const Vector10 pi = model.pi.head<10>();
  EXPECT_TRUE(is_physical(pi));
  const double y = (1 + 3 - 1.5) / 2, x = (1.5 + 3 - 1) / 2, z = 0.01 * x;  // second moments
  EXPECT_NEAR(pi[4], y + z, 1e-12);
  EXPECT_NEAR(pi[6], x + z, 1e-12);
  EXPECT_NEAR(pi[9], x + y, 1e-12);

  EXPECT_TRUE(is_physical(mended(R"(ixx="-1" iyy="1" izz="1")").pi.head<10>()));
  EXPECT_TRUE(mended(R"(ixx="1" iyy="1" izz="1")").mended_links.empty());
  EXPECT_TRUE(mended(R"(ixx="0.0333" iyy="0.0333" izz="0.06666")").mended_links.empty());
  EXPECT_THROW(mended(R"(ixx="-1" iyy="-1" izz="-1")"), UserError);
}

/// Torque of the joints that are not welded, and of the same joints where the others stand still.
void expect_same_as_standing(const std::string& file, const Welds& welds) {
  const RobotModel whole = load(file);
  const RobotModel welded =
      load_urdf(source_dir() / "models" / file, Eigen::Matrix3d::Identity(), welds);
  ASSERT_EQ(welded.n() + std::ssize(welds.at), whole.n());
  Workspace<double> ws(whole), ws_welded(welded);
  Rng rng(7, 0);
  const auto n = static_cast<std::size_t>(whole.n()), m = static_cast<std::size_t>(welded.n());
  const auto pi = [](const RobotModel& robot) {
    return std::span<const double>(robot.pi.data(), static_cast<std::size_t>(robot.pi.size()));
  };
  for (int state = 0; state < 50; ++state) {
    std::vector<double> q(n), v(n), a(n), tau(n), some_q, some_v, some_a, tau_welded(m);
    for (std::size_t j = 0; j < n; ++j) {
      const auto weld = welds.at.find(whole.joints[j].name);
      if (weld != welds.at.end()) {
        q[j] = weld->second;
        continue;
      }
      some_q.push_back(q[j] = rng.normal());
      some_v.push_back(v[j] = rng.normal());
      some_a.push_back(a[j] = 5 * rng.normal());
    }
    rnea<double>(whole, ws, pi(whole), q, v, a, tau);
    rnea<double>(welded, ws_welded, pi(welded), some_q, some_v, some_a, tau_welded);
    std::size_t k = 0;
    for (std::size_t j = 0; j < n; ++j)
      if (!welds.at.contains(whole.joints[j].name)) {
        EXPECT_EQ(welded.joints[k].name, whole.joints[j].name);
        EXPECT_NEAR(tau_welded[k++], tau[j], tolerance(1e-11)) << whole.joints[j].name;
      }
  }
}

TEST(Urdf, AWeldedJointIsOneThatStandsStill) {
  expect_same_as_standing("kr6_r700/kr6_r700.urdf", {.at = {{"joint_a3", 0.4}}});
  expect_same_as_standing("kr6_r700/kr6_r700.urdf", {.at = {{"joint_a2", -1.1}, {"joint_a6", 2}}});
  expect_same_as_standing("test/branched.urdf", {.at = {{"right_slide", 0.15}, {"waist", 0.3}}});
}

/// An arm with a gripper of two fingers on slides, of which the second follows the first.
std::string gripper() {
  std::string text = one_joint();
  const std::string limit = R"(<limit lower="-0.01" upper="0.04" velocity="1" effort="20"/>)";
  std::string hand;
  for (const std::string name : {"one", "two"})
    hand +=
        "<link name=\"" + name + "\">" + kInertial + "</link>\n<joint name=\"finger_" + name +
        R"(" type="prismatic"><parent link="arm"/><child link=")" + name +
        R"("/><axis xyz="0 1 0"/>)" + limit +
        (name == "two" ? R"(<mimic joint="finger_one" multiplier="-0.5" offset="0.01"/>)" : "") +
        "</joint>\n";
  return text.insert(text.find("</robot>"), hand);
}

TEST(Urdf, WhatMimicsAWeldedJointIsWeldedWithIt) {
  const auto read = [](const Welds& welds) {
    return parse_urdf(gripper(), "r.urdf", Eigen::Matrix3d::Identity(), welds);
  };
  const RobotModel one = read({.at = {{"finger_one", 0.03}}});
  const RobotModel both = read({.at = {{"finger_one", 0.03}, {"finger_two", -0.005}}});
  const RobotModel rounded = read({.at = {{"finger_one", 0.03}, {"finger_two", -0.00495}}});
  ASSERT_EQ(one.n(), 1);
  EXPECT_TRUE(close(one.pi, both.pi, 1e-15));
  EXPECT_DOUBLE_EQ(one.pi[2], 0.03 - 0.005);  // m cy of the two
  EXPECT_DOUBLE_EQ(rounded.pi[2], 0.03 - 0.00495);
}

TEST(UrdfError, Welds) {
  const auto message_of = [](const Welds& welds) -> std::string {
    try {
      parse_urdf(gripper(), "r.urdf", Eigen::Matrix3d::Identity(), welds);
    } catch (const UserError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message_of({.at = {}}),
            "r.urdf:8: joint finger_two: <mimic> follows finger_one, which moves; each joint must "
            "be free: fix both at a position by [robot] fix = {finger_one = POSITION}, or remove "
            "<mimic>");
  EXPECT_EQ(
      message_of({.at = {{"finger_two", 0.02}}}),
      "r.urdf:8: joint finger_two: is fixed, but its <mimic> follows finger_one, which moves; "
      "allowed: both fixed by [robot] fix, or no <mimic>");
  EXPECT_EQ(message_of({.at = {{"finger_one", 0.03}, {"finger_two", 0.02}},
                        .where = "s.toml:4: robot.fix"}),
            "s.toml:4: robot.fix: finger_two = 0.02, but by its <mimic> in r.urdf it is -0.005 "
            "where finger_one = 0.03; allowed: -0.005, or leave finger_two out");
  EXPECT_EQ(message_of({.at = {{"finger", 0.1}}, .where = "s.toml:4: robot.fix"}),
            "s.toml:4: robot.fix: finger is not a moving joint of r.urdf; allowed: finger_one, "
            "finger_two, turn");
  EXPECT_EQ(message_of({.at = {{"finger_one", 20}}, .where = "s.toml:4: robot.fix"}),
            "s.toml:4: robot.fix: finger_one = 20; allowed: -0.01 to 0.04 m, its limits in r.urdf");
  EXPECT_EQ(message_of({.at = {{"finger_one", 0.02}, {"turn", 1.5}}}),
            "fix: turn = 1.5; allowed: -1 to 1 rad, its limits in r.urdf");
  EXPECT_EQ(message_of({.at = {{"finger_one", 0.02}, {"turn", 0.5}}}),
            "r.urdf: no revolute, continuous or prismatic joint");
}

TEST(UrdfError, Inertia) {
  EXPECT_EQ(message(one_joint("")),
            "r.urdf:3: link arm: moved by joint turn but without mass; needs <inertial> with mass "
            "> 0");
  EXPECT_EQ(message(one_joint(inertial("-1", R"(ixx="1" iyy="1" izz="1")"))),
            "r.urdf:3: link arm: mass = -1 kg; must be > 0");
  EXPECT_EQ(message(one_joint(inertial("0", R"(ixx="1" iyy="1" izz="1")"))),
            "r.urdf:3: link arm: mass = 0 kg; must be > 0");
  EXPECT_EQ(message(one_joint(inertial("0", R"(ixx="0" iyy="0" izz="0")"))),
            "r.urdf:3: link arm: moved by joint turn but without mass; needs <inertial> with mass "
            "> 0");
  EXPECT_EQ(message(one_joint(inertial("1", R"(ixx="1" iyy="1" izz="3")"))),
            "r.urdf:3: link arm: principal moments of inertia 1, 1, 3 kg m^2; the largest must not "
            "exceed the sum of the other two; correct its <inertia>, or take the nearest that a "
            "body can have: mend_inertia = true in [robot] of a scene, --mend-inertia beside "
            "--robot");
  EXPECT_EQ(message(one_joint(inertial("1", R"(ixx="-1" iyy="1" izz="1")"))),
            "r.urdf:3: link arm: principal moment of inertia -1 kg m^2; must be > 0; correct its "
            "<inertia>, or take the nearest that a body can have: mend_inertia = true in [robot] "
            "of a scene, --mend-inertia beside --robot");
  EXPECT_EQ(message(one_joint(inertial("1", R"(ixx="nan" iyy="1" izz="1")"))),
            "r.urdf: Inertial: inertia element ixx is not a valid double; Could not parse inertial "
            "element for Link [arm]");
}

TEST(UrdfError, OtherUnits) {
  const auto error = [](double length, double mass) {
    return message(one_joint(fmt::format(
        R"(<inertial><origin xyz="{} 0 0"/><mass value="{}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>)",
        length, mass)));
  };
  EXPECT_EQ(error(0.2, 4900), "no error");
  EXPECT_EQ(error(200, 5),
            "r.urdf:4: joint turn: its link reaches 200 m from the first joint; allowed: up to 20 "
            "m; a URDF is in metres: this one seems to be in millimetres (lengths times 0.001, "
            "moments of inertia of kg mm^2 times 1e-6)");
  EXPECT_EQ(error(0.2, 5100),
            "r.urdf:3: link arm: mass = 5100 kg; allowed: up to 5000 kg; a URDF is in kilograms "
            "and metres: this one seems to be in grams (masses and moments of inertia times "
            "0.001)");
}

TEST(UrdfError, Joint) {
  EXPECT_EQ(
      message(one_joint(kInertial, kLimit, "planar")),
      "r.urdf:4: joint turn: type is planar; allowed: revolute, continuous, prismatic, fixed");
  EXPECT_EQ(message(one_joint(kInertial, kLimit, "floating")),
            "r.urdf:4: joint turn: type is floating; allowed: revolute, continuous, prismatic, "
            "fixed");
  EXPECT_EQ(message(one_joint(kInertial, kLimit, "revolute", R"(<axis xyz="0 0 0"/>)")),
            "r.urdf:4: joint turn: axis = (0, 0, 0); must not be zero");
  EXPECT_EQ(
      message(one_joint(kInertial, R"(<limit velocity="1" effort="1"/>)")),
      "r.urdf:4: joint turn: limits lower = 0, upper = 0; lower must be below upper, or the joint "
      "fixed: robot.fix = {turn = 0} in a scene");
  EXPECT_EQ(
      message(one_joint(kInertial, R"(<limit lower="-1" upper="1" velocity="-2" effort="3"/>)")),
      "r.urdf:4: joint turn: limit velocity = -2; must be >= 0");
  EXPECT_EQ(
      message(one_joint(kInertial, R"(<limit lower="-1" upper="1" velocity="2" effort="-3"/>)")),
      "r.urdf:4: joint turn: limit effort = -3; must be >= 0");
  EXPECT_EQ(message(one_joint(kInertial, kLimit + R"(<mimic joint="other"/>)")),
            "r.urdf:4: joint turn: <mimic> follows other, which moves; each joint must be free: "
            "fix both at a position by [robot] fix = {other = POSITION}, or remove <mimic>");
  EXPECT_EQ(message(one_joint(kInertial, "", "fixed")),
            "r.urdf: no revolute, continuous or prismatic joint");
  EXPECT_EQ(message("<robot name=\"r\">\n<link name=\"base\"/>\n</robot>"),
            "r.urdf: no revolute, continuous or prismatic joint");
}

// urdfdom says "joint xml is not initialized correctly".
TEST(UrdfError, LimitsThatAreMissing) {
  const std::string remedy =
      "; allowed: <limit lower= upper= velocity= effort=/> (0: no limit of velocity or effort)";
  const std::string turning = ", type=\"continuous\" where it turns without end, or type=\"fixed\"";
  EXPECT_EQ(message(one_joint(kInertial, "")),
            "r.urdf:4: joint turn: revolute without <limit>" + remedy + turning);
  EXPECT_EQ(message(one_joint(kInertial, R"(<limit lower="-1" upper="1" velocity="2"/>)")),
            "r.urdf:4: joint turn: revolute without <limit> with effort" + remedy + turning);
  EXPECT_EQ(message(one_joint(kInertial, R"(<limit lower="-1" upper="1" effort="2"/>)")),
            "r.urdf:4: joint turn: revolute without <limit> with velocity" + remedy + turning);
  EXPECT_EQ(message(one_joint(kInertial, "", "prismatic")),
            "r.urdf:4: joint turn: prismatic without <limit>" + remedy + ", or type=\"fixed\"");
}

using UrdfFile = TemporaryFolder;

// What follows another joint is placed with it.
TEST_F(UrdfFile, JointsRestAtZeroOrAtTheirLimitNearestToIt) {
  const auto rest = [&](const std::string& limit) {
    write_file_atomically(folder / "r.urdf", one_joint(kInertial, limit));
    return rest_positions(folder / "r.urdf").at("turn");
  };
  EXPECT_EQ(rest(kLimit), 0);
  EXPECT_EQ(rest(R"(<limit lower="-2" upper="-1" velocity="2" effort="3"/>)"), -1);
  EXPECT_EQ(rest(R"(<limit lower="0.5" upper="1" velocity="2" effort="3"/>)"), 0.5);
  write_file_atomically(folder / "r.urdf", gripper());
  const std::map<std::string, double> expected{{"finger_one", 0}, {"turn", 0}};
  EXPECT_EQ(rest_positions(folder / "r.urdf"), expected);
}

TEST(UrdfError, OwnElement) {
  EXPECT_EQ(message(one_joint(kInertial, kLimit + R"(<fricid armature="-0.1"/>)")),
            "r.urdf:4: joint turn: fricid armature = \"-0.1\"; must be a number >= 0");
  EXPECT_EQ(message(one_joint(kInertial, kLimit + R"(<fricid jerk="fast"/>)")),
            "r.urdf:4: joint turn: fricid jerk = \"fast\"; must be a number >= 0");
  EXPECT_EQ(message(one_joint(kInertial, kLimit + R"(<fricid armatur="0.1"/>)")),
            "r.urdf:4: joint turn: fricid: unknown attribute \"armatur\"; known: armature, "
            "acceleration, jerk");
}

/// One line that names the file.
void expect_one_line(const std::string& what) {
  EXPECT_EQ(what.find("r.urdf:"), 0u) << what;
  EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  EXPECT_GT(what.size(), 12u) << what;
}

TEST(UrdfError, BrokenXmlIsOneLine) {
  EXPECT_EQ(message("<robot name=\"r\">\n<link name=\"base\">\n</robot>"),
            "r.urdf:2: not well-formed XML (XML_ERROR_MISMATCHED_ELEMENT)");
  EXPECT_EQ(message("<mujoco/>"), "r.urdf: no <robot> element");
  EXPECT_EQ(message(""), "r.urdf:0: not well-formed XML (XML_ERROR_EMPTY_DOCUMENT)");
  expect_one_line(message(one_joint(inertial("heavy", R"(ixx="1" iyy="1" izz="1")"))));
  expect_one_line(message(one_joint(kInertial, "")));  // revolute without <limit>
  expect_one_line(message("<robot name=\"r\"></robot>"));
  std::string orphan = one_joint();
  orphan.replace(orphan.find("parent link=\"base\""), 18, "parent link=\"none\"");
  expect_one_line(message(orphan));
  std::string loop = one_joint();
  loop.replace(loop.find("parent link=\"base\""), 18, "parent link=\"arm\"");
  expect_one_line(message(loop));
}

// Cut anywhere, a file is read or refused in one line.
TEST(UrdfError, NamesThatCouldBeCodeAreRefusedWithTheirLine) {
  const std::string hostile = "a&#10;system('touch marker')";
  const auto renamed = [&](std::string text, const std::string& word) {
    for (std::size_t at; (at = text.find("\"" + word + "\"")) != text.npos;)
      text.replace(at + 1, word.size(), hostile);
    return text;
  };
  const std::string found = " = \"a\\nsystem('touch marker')\"; allowed: 1 to 100 letters";
  EXPECT_EQ(message(renamed(one_joint(), "turn")).find("r.urdf:4: name of a joint" + found), 0u);
  EXPECT_EQ(message(renamed(one_joint(), "arm")).find("r.urdf:3: name of a link" + found), 0u);
  EXPECT_EQ(message(renamed(one_joint(), "r")).find("r.urdf:1: name of a robot" + found), 0u);
}

TEST(UrdfError, TruncatedAnywhereIsOneLine) {
  const std::string whole = one_joint();
  for (size_t size = 0; size + 2 < whole.size(); ++size)
    expect_one_line(message(whole.substr(0, size)));
}

// urdfdom and the engine walk the tree link by link.
TEST(UrdfError, LongChainsAreRefused) {
  const auto chain = [](int links) {
    std::string text = "<robot name=\"r\"><link name=\"l0\"/>";
    for (int i = 1; i < links; ++i)
      text += fmt::format(
          "<link name=\"l{0}\"/><joint name=\"j{0}\" type=\"fixed\"><parent link=\"l{1}\"/>"
          "<child link=\"l{0}\"/></joint>",
          i, i - 1);
    return text + "</robot>";
  };
  EXPECT_EQ(message(chain(1000)), "r.urdf: no revolute, continuous or prismatic joint");
  EXPECT_EQ(message(chain(1001)), "r.urdf: 1001 links of a URDF; allowed: up to 1000");
  EXPECT_EQ(message(chain(60'000)), "r.urdf: 60000 links of a URDF; allowed: up to 1000");
}

TEST(UrdfError, MissingFileAndDirectory) {
  const auto what = [](const std::filesystem::path& path) -> std::string {
    try {
      load_urdf(path);
    } catch (const UserError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(what("no/such.urdf"), "no/such.urdf: cannot be read: No such file or directory");
  const std::string folder = source_dir() / "models";
  EXPECT_EQ(what(folder), folder + ": is a folder, a file is expected");
}

}  // namespace
}  // namespace fricid::dynamics::test
