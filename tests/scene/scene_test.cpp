#include "fricid/scene/problem.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "fricid/dynamics/nominal.hpp"
#include "scene_folder.hpp"
#include "source_dir.hpp"

namespace fricid::scene {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pointwise;

class SceneFile : public FolderTest {
 protected:
  Problem load(const std::string& text, const std::string& name = "scene.toml") const {
    return load_problem(write(name, text));
  }
};

TEST_F(SceneFile, SimpleSceneHasDefaults) {
  const Problem e = load(kScene);
  EXPECT_EQ(e.scene.name, "scene");
  EXPECT_EQ(e.scene.seed, 1u);
  EXPECT_EQ(e.robot.n(), 2);
  EXPECT_EQ(e.scene.sensors.rate_hz, 250);
  EXPECT_THAT(e.scene.sensors.encoder_noise_rad, ElementsAre(0, 0));
  EXPECT_THAT(e.scene.evaluate.horizons_s, ElementsAre(0.1, 1, 10, 0));
  ASSERT_TRUE(e.scene.simulates());
  EXPECT_THAT(e.scene.friction->theta, ElementsAre(3, 1, 0.01, 3, 0.5, 0.01));
  EXPECT_THAT(e.inputs, ElementsAre(path("scene.toml"), path("arm.urdf"), path("arm.xml")));
}

/// A text without a file: what it extends has its places, its own keys have none.
TEST_F(SceneFile, MayBeATextAlone) {
  write("base.toml", kScene);
  const std::string extends = fmt::format("extends = \"{}\"\n", (folder / "base.toml").string());
  const Problem of_text = resolve(load_scene_text(extends + "sensors = {rate_hz = 500}\n"));
  EXPECT_EQ(of_text.scene.name, "scene");
  EXPECT_EQ(of_text.scene.sensors.rate_hz, 500);
  EXPECT_EQ(of_text.robot.n(), 2);
  EXPECT_THAT(of_text.inputs, ElementsAre(path("base.toml"), path("arm.urdf"), path("arm.xml")));

  const auto refusal = [&](const std::string& text) {
    return message_of([&] { resolve(load_scene_text(text)); });
  };
  EXPECT_THAT(refusal(extends + "sensors = {rate_hz = -2}\n"),
              testing::StartsWith("<scene>: sensors.rate_hz = -2; allowed"));
  EXPECT_THAT(refusal(extends + "seeds = 2\n"), testing::StartsWith("<scene>: unknown key"));
  EXPECT_THAT(refusal("seed ="), testing::StartsWith("<scene>: not TOML: "));
  EXPECT_THAT(refusal("extends = \"none.toml\""),
              testing::StartsWith("<scene>: extends: none.toml is neither"));
  EXPECT_THAT(refusal("seed = " + std::string(40, '[')), HasSubstr("levels"));
}

TEST_F(SceneFile, FixedJointsAreWelded) {
  const Problem e = load(R"toml(
[robot]
urdf = "arm.urdf"
fix = {elbow = 0.5}
[friction]
[[friction.law]]
law = "coulomb_viscous"
Fc = [3]
Fv = [1]
v0 = 0.01
)toml");
  EXPECT_EQ(e.robot.n(), 1);
  EXPECT_THAT(e.scene.joints, ElementsAre("shoulder"));
  EXPECT_DOUBLE_EQ(e.robot.pi[0], 6);
  EXPECT_EQ(load_problem(write("again.toml", to_toml(e.scene))).robot.pi, e.robot.pi);
}

// A published URDF states no armatures: the scene does, or asks for those usual for the limits.
TEST_F(SceneFile, ArmaturesAreStatedOrGuessed) {
  const std::string text = R"toml(
[robot]
urdf = "arm.urdf"
armature = {elbow = 0.25}
[friction]
)toml";
  const Problem stated = load(text);
  const int first = stated.robot.armature_begin();
  EXPECT_EQ(stated.robot.pi[first], 0);
  EXPECT_DOUBLE_EQ(stated.robot.pi[first + 1], 0.25);
  const Problem guessed = load(replaced(text, "armature = {elbow = 0.25}",
                                        "armature = {shoulder = 0.5}\nguess_armature = true"),
                               "guessed.toml");
  EXPECT_DOUBLE_EQ(guessed.robot.pi[first], 0.5);
  EXPECT_DOUBLE_EQ(guessed.robot.pi[first + 1], dynamics::usual_armature(stated.robot)[1]);
  EXPECT_EQ(load_problem(write("again.toml", to_toml(guessed.scene))).robot.pi, guessed.robot.pi);
  EXPECT_EQ(message_of([&] { load(replaced(text, "elbow", "elbo"), "bad.toml"); }),
            "bad.toml:4: robot.armature: no joint elbo; allowed: shoulder, elbow");
  EXPECT_EQ(message_of([&] { load(replaced(text, "0.25", "-1"), "bad.toml"); }),
            "bad.toml:4: robot.armature.elbow = -1; allowed: {NAME = a number from 0 to 100000 kg "
            "m^2 or kg, ...}");
  EXPECT_EQ(message_of([&] {
              load(replaced(text, "[friction]", "mjcf = \"arm.xml\"\n[friction]"), "bad.toml");
            }),
            "bad.toml:4: robot.armature beside robot.mjcf; allowed: one of them, without mjcf the "
            "simulator's arm is made of the URDF");
}

// What is held is where the first training log has it, and the scene says so.
TEST_F(SceneFile, HeldJointsAreWhereTheLogHasThem) {
  write("contract.toml", R"toml(
joint_names = ["shoulder", "elbow"]
[position]
columns = "q{}"
[torque]
columns = "tau{}"
)toml");
  std::string log = "t,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 20; ++k)
    log += fmt::format("{},{},{},1,1\n", 0.004 * k, 0.1 * k, k == 3 ? 0.2 : 0.75);
  write("log.csv", log);
  const std::string text = R"toml(
[robot]
urdf = "arm.urdf"
hold = ["elbow"]
[data]
contract = "contract.toml"
train = "log.csv"
)toml";
  const Problem e = load(text);
  EXPECT_THAT(e.scene.joints, ElementsAre("shoulder"));
  EXPECT_EQ(e.scene.robot.fix.at("elbow"), 0.75);
  const Problem again = load_problem(write("again.toml", to_toml(e.scene)));
  EXPECT_EQ(again.robot.pi, e.robot.pi);
  EXPECT_EQ(to_toml(again.scene), to_toml(e.scene));
  EXPECT_EQ(message_of([&] {
              load(replaced(text, "hold = [\"elbow\"]\n", "fix = {shoulder = 1.9}\n"),
                   "other.toml");
            }),
            "no error");
  write(
      "short.toml",
      "joint_names = [\"shoulder\"]\n[position]\ncolumns = \"q1\"\n[torque]\ncolumns = \"tau1\"\n");
  EXPECT_EQ(message_of([&] { load(replaced(text, "contract.toml", "short.toml"), "other.toml"); }),
            "other.toml:4: robot.hold = \"elbow\"; allowed: joints of the log, shoulder; or "
            "robot.fix = {elbow = POSITION}");
  EXPECT_EQ(
      message_of([&] {
        load(replaced(replaced(text, "contract.toml", "short.toml"), "hold = [\"elbow\"]\n", ""),
             "other.toml");
      }),
      "other.toml:5: data.contract has the joints shoulder; allowed: those of the robot, "
      "shoulder, elbow; fix a joint that is not logged: robot.fix = {JOINT = "
      "POSITION}");
}

TEST_F(SceneFile, EveryKindOfValueIsRead) {
  const Problem e = load(R"toml(
name = "all"
seed = 12
[robot]
urdf = "arm.urdf"
mjcf = "arm.xml"
mount = "ceiling"
[sensors]
rate_hz = 500
encoder_noise_rad = 1e-5
encoder_step_rad = [1e-6, 2e-6]
velocity = true
[excitation]
harmonics = 7
centre = [0.5, -0.5]
[evaluate]
horizons_s = [0.5, 2]
[[model]]
name = "simple"
seeds = [3, 1, 3]
[[model]]
name = "gms_8"
law = "gms"
label = "GMS"
elements = 8
[[friction.law]]
law = "none"
)toml");
  EXPECT_EQ(e.scene.name, "all");
  EXPECT_EQ(e.scene.seed, 12u);
  EXPECT_EQ(e.scene.sensors.rate_hz, 500);
  EXPECT_THAT(e.scene.sensors.encoder_noise_rad, ElementsAre(1e-5, 1e-5));
  EXPECT_THAT(e.scene.sensors.encoder_step_rad, ElementsAre(1e-6, 2e-6));
  EXPECT_TRUE(e.scene.sensors.velocity);
  EXPECT_EQ(e.scene.excitation.harmonics, 7);
  EXPECT_THAT(e.scene.excitation.centre, ElementsAre(0.5, -0.5));
  EXPECT_THAT(e.scene.evaluate.horizons_s, ElementsAre(0.5, 2));
  ASSERT_EQ(e.scene.models.size(), 2u);
  EXPECT_EQ(e.scene.models[0].law, "coulomb_viscous");
  EXPECT_EQ(e.scene.models[0].label, "simple");
  EXPECT_THAT(e.scene.models[0].seeds, ElementsAre(1, 3));
  EXPECT_EQ(e.scene.models[1].law, "gms");
  EXPECT_EQ(e.scene.models[1].elements, 8);
}

// Oracle: gravity in the base frame is the world's, turned back by the mount.
TEST_F(SceneFile, MountTurnsGravity) {
  const auto gravity = [&](const std::string& mount) {
    return Eigen::Vector3d(
        load(replaced(kScene, "[robot]\n", "[robot]\n" + mount + "\n")).robot.gravity);
  };
  const double g = 9.81;
  EXPECT_EQ(gravity("mount = \"floor\""), Eigen::Vector3d(0, 0, -g));
  EXPECT_EQ(gravity("mount = \"ceiling\""), Eigen::Vector3d(0, 0, g));
  EXPECT_EQ(gravity("mount = \"wall\""), Eigen::Vector3d(g, 0, 0));
  const Eigen::Vector3d rolled = gravity("mount = \"rpy\"\nmount_rpy = [0.5, 0, 2.0]");
  EXPECT_LT((rolled - Eigen::Vector3d(0, -g * std::sin(0.5), -g * std::cos(0.5))).norm(), 1e-12);
  RobotSection tilted;
  tilted.mount = Mount::kRpy;
  tilted.mount_rpy = {0.1, 0.2, 0.3};
  const Eigen::Matrix3d R = mount_rotation(tilted);
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-15);
  EXPECT_EQ(mount_rotation("0.1,0.2,0.3"), R);
  EXPECT_EQ(mount_rotation("wall") * Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ());
  for (const char* words : {"rpy", "", "0.1,0.2", "0.1,0.2,0.3,0", "0.1,0.2,x", "0.1,0.2,inf", "1"})
    EXPECT_THROW(mount_rotation(words), UserError) << words;
  // Yaw last: the base x axis leaves the horizontal by the pitch alone.
  EXPECT_NEAR(R(2, 0), -std::sin(0.2), 1e-15);
}

// Oracle: mass and first moment of the link grow by those of a point at the flange, 0.3 m out.
TEST_F(SceneFile, PayloadJoinsTheLastLink) {
  const Eigen::VectorXd bare = load(kScene).robot.pi;
  const Eigen::VectorXd loaded =
      load(replaced(kScene, "[robot]\n",
                    "[robot]\npayload_kg = 2\npayload_com = [0.1, 0, 0]\n"
                    "payload_inertia = [0.1, 0.2, 0.2, 0, 0, 0]\n"))
          .robot.pi;
  EXPECT_EQ(loaded.head(10), bare.head(10));
  EXPECT_NEAR(loaded[10] - bare[10], 2, 1e-12);
  EXPECT_NEAR(loaded[11] - bare[11], 2 * 0.4, 1e-12);
  EXPECT_NEAR(loaded[14] - bare[14], 0.1, 1e-12);
  EXPECT_NEAR(loaded[16] - bare[16], 0.2 + 2 * 0.4 * 0.4, 1e-12);
}

TEST_F(SceneFile, LinearTorquesAreParsed) {
  const Problem e = load(replaced(kScene, "[friction]\n", R"toml([[robot.torque]]
joint = "elbow"
terms = ["1", "q", "sin(q)", "cos( 2 q )", "sin(31.4*q)"]
prior_sd = [1, 2, 3, 4, 5]
[[robot.torque]]
joint = "shoulder"
terms = "cos(q)"
[friction]
)toml"));
  using Shape = dynamics::LinearTorque::Shape;
  const auto& torques = e.robot.linear_torques;
  ASSERT_EQ(torques.size(), 6u);
  EXPECT_EQ(e.robot.pi.size(), 11 * 2 + 6);
  const std::vector<Shape> shapes{Shape::kConstant, Shape::kLinear, Shape::kSin,
                                  Shape::kCos,      Shape::kSin,    Shape::kCos};
  const std::vector<double> k{1, 1, 1, 2, 31.4, 1};
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    EXPECT_EQ(torques[i].shape, shapes[i]) << i;
    EXPECT_EQ(torques[i].k, k[i]) << i;
    EXPECT_EQ(torques[i].joint, i < 5 ? 1 : 0) << i;
  }
  EXPECT_EQ(torques[3].name, "elbow cos( 2 q )");
  EXPECT_THAT(e.scene.identify.linear_prior_sd,
              ElementsAre(1, 2, 3, 4, 5, std::numeric_limits<double>::infinity()));
}

TEST_F(SceneFile, ExtendsMergesTablesAndReplacesArrays) {
  write("base/arm.urdf", kArmUrdf);
  write("base/arm.xml", "<mujoco/>");
  write("base/base.toml", std::string(kScene) + R"toml(
[sensors]
rate_hz = 500
torque_noise = 0.002
[evaluate]
horizons_s = [1, 2, 3]
[[model]]
name = "simple"
[[model]]
name = "dahl"
)toml");
  write("middle.toml", "extends = \"base/base.toml\"\n[sensors]\ntorque_noise = 0.003\n");
  const Problem e = load(R"toml(extends = "middle.toml"
seed = 5
[evaluate]
horizons_s = [4]
[[model]]
name = "lugre"
[[friction.law]]
law = "none"
)toml");
  EXPECT_EQ(e.scene.seed, 5u);
  EXPECT_EQ(e.scene.sensors.rate_hz, 500);
  EXPECT_EQ(e.scene.sensors.torque_noise, 0.003);
  EXPECT_THAT(e.scene.evaluate.horizons_s, ElementsAre(4));
  ASSERT_EQ(e.scene.models.size(), 1u);
  EXPECT_EQ(e.scene.models[0].name, "lugre");
  EXPECT_EQ(e.scene.friction->model.joints()[0].laws.size(), 1u);
  EXPECT_EQ(e.scene.friction->model.joints()[0].laws[0].law, "none");
  // Of several bases the last wins, and the scene itself over all of them.
  write("models.toml", "seed = 7\n[[model]]\nname = \"gms\"\n[sensors]\ntorque_noise = 0.004\n");
  const Problem two = load("extends = [\"middle.toml\", \"models.toml\"]\nseed = 8\n");
  EXPECT_EQ(two.scene.seed, 8u);
  EXPECT_EQ(two.scene.sensors.torque_noise, 0.004);
  EXPECT_EQ(two.scene.sensors.rate_hz, 500);
  ASSERT_EQ(two.scene.models.size(), 1u);
  EXPECT_EQ(two.scene.models[0].name, "gms");
  // The robot is found beside the file that names it.
  EXPECT_EQ(e.urdf_path, path("base/arm.urdf"));
  EXPECT_THAT(e.inputs, ElementsAre(path("scene.toml"), path("middle.toml"), path("base/base.toml"),
                                    path("base/arm.urdf"), path("base/arm.xml")));
}

TEST_F(SceneFile, WritingIsAFixedPointOfLoading) {
  write("logs/a.csv", "t");
  write("contract.toml",
        "joint_names = [\"shoulder\", \"elbow\"]\n"
        "position.columns = \"q{}\"\ntorque.columns = \"tau{}\"\n");
  const std::string rich = replaced(kScene, "[friction]\n", R"toml(mount = "rpy"
mount_rpy = [0.1, 0.2, 0.30000000000000004]
payload_kg = 1e-3
[[robot.torque]]
joint = "elbow"
terms = ["1", "sin(2 q)"]
prior_sd = [0.1, 1e3]
[[model]]
name = "lugre"
seeds = [2, 3]
[friction]
)toml");
  const std::string log_scene = R"toml(description = "quotes \" and \\ and \u00e9"
[robot]
urdf = "arm.urdf"
[data]
contract = "contract.toml"
train = ["logs/a.csv", "$FRICID_TEST_LOGS/b.csv"]
)toml";
  for (const std::string& text : {std::string(kScene), rich, log_scene}) {
    const std::string once = to_toml(load(text).scene);
    const std::string twice = to_toml(load(once, "elsewhere/again.toml").scene);
    EXPECT_EQ(twice, once);
  }
}

// What lies in the share folder is named relative to it, so that a run folder can be moved.
TEST_F(SceneFile, FilesOfTheShareFolderStayRelative) {
  setenv("FRICID_SHARE", folder.c_str(), 1);
  const std::string text = to_toml(load(kScene, "scenes/scene.toml").scene);
  unsetenv("FRICID_SHARE");
  EXPECT_THAT(text, HasSubstr("urdf = \"arm.urdf\"\n"));
}

TEST_F(SceneFile, LogsThatAreMissingAreTold) {
  write("contract.toml",
        "joint_names = [\"shoulder\", \"elbow\"]\n"
        "position.columns = \"q{}\"\ntorque.columns = \"tau{}\"\n");
  const std::string scene = R"toml([robot]
urdf = "arm.urdf"
[data]
contract = "contract.toml"
train = ["$FRICID_TEST_LOGS/a.csv"]
)toml";
  unsetenv("FRICID_TEST_LOGS");
  const auto refusal = [&] { return message_of([&] { require_logs(load(scene)); }); };
  EXPECT_EQ(refusal(),
            "scene.toml:5: $FRICID_TEST_LOGS/a.csv needs the environment variable "
            "FRICID_TEST_LOGS, which is not set");
  setenv("FRICID_TEST_LOGS", path("logs").c_str(), 1);
  EXPECT_EQ(refusal(), "scene.toml:5: logs/a.csv does not exist");
  EXPECT_FALSE(logs_are_there(load(scene)));
  write("logs/a.csv", "t");
  const Problem found = load(scene);
  EXPECT_TRUE(logs_are_there(found));
  EXPECT_EQ(found.inputs.back(), path("logs/a.csv"));
  EXPECT_FALSE(found.scene.simulates());
  unsetenv("FRICID_TEST_LOGS");
}

TEST_F(SceneFile, TemplateIsASceneWithTheDefaults) {
  std::string text = scene_template();
  for (const char* name : {"arm.urdf", "arm.xml"}) {
    const std::string shown = std::string(name) == "arm.urdf" ? "kr6_r700.urdf" : "kr6_r700.xml";
    text = replaced(text, "models/kr6_r700/" + shown, name);
  }
  const Problem e = load(text);
  const Problem defaults = load(kScene);
  EXPECT_EQ(e.scene.sensors.torque_noise, defaults.scene.sensors.torque_noise);
  // Everything but the robot, the friction and the models is the default scene.
  const auto tail = [](const Problem& problem) {
    Scene copy = problem.scene;
    copy.models.clear();
    const std::string all = to_toml(copy);
    return all.substr(all.find("[plant]"));
  };
  EXPECT_EQ(tail(e), tail(defaults));
}

// A scene made of the commented parts, too: every example in the template is valid.
TEST_F(SceneFile, CommentedExamplesOfTheTemplateLoad) {
  std::istringstream lines(scene_template());
  std::string text = std::string(kScene), block, line;
  bool in_law = false;
  while (std::getline(lines, line)) {
    if (line == "# [[friction.law]]") in_law = true;
    if (in_law && line.empty()) in_law = false;
    if (!in_law || !line.starts_with("# ")) continue;
    const std::string code = line.substr(2);
    if (code.starts_with("[[") || code.find(" = ") != std::string::npos) text += code + "\n";
  }
  const Problem e = load(text);
  EXPECT_EQ(e.scene.friction->model.joints()[0].laws.size(), friction::law_table().size());
}

// What a scene leaves open of the paper's model is its own; what it says stays, written and read
// too.
TEST_F(SceneFile, ThePapersModelHasDefaultsOfItsOwn) {
  const std::string models =
      "[[model]]\nname = \"lvm_paper\"\n[[model]]\nname = \"few\"\nlaw = \"lvm_paper\"\nn_z = 6\n"
      "method = \"torque\"\nem = {iterations = 0}\n";
  const Problem first = load(kScene + models);
  const Problem again = load(to_toml(first.scene), "again.toml");
  for (const Problem* e : {&first, &again}) {
    const estimate::ModelOptions &whole = e->scene.models[0], &few = e->scene.models[1];
    EXPECT_EQ(whole.method, estimate::Method::kEm);
    EXPECT_EQ(whole.elements, 32);
    EXPECT_EQ(whole.n_z, 2);
    EXPECT_EQ(whole.em.e_step, estimate::EStep::kAdapted);
    EXPECT_FALSE(whole.em.rigid_body);
    EXPECT_EQ(few.method, estimate::Method::kTorque);
    EXPECT_EQ(few.n_z, 6);
    EXPECT_EQ(few.em.iterations, 0);
    EXPECT_EQ(few.em.m_steps, whole.em.m_steps);
  }
}

TEST(SceneKeys, DocumentIsTheTemplate) {
  std::stringstream document;
  document << std::ifstream(source_dir() / "docs/scene_keys.md").rdbuf();
  EXPECT_THAT(document.str(), HasSubstr("```toml\n" + scene_template() + "```\n"))
      << "write the output of `fricid template scene` between the fences of docs/scene_keys.md";
}

}  // namespace
}  // namespace fricid::scene
