// One bad scene per mistake a user can make, with the whole message.
#include <gmock/gmock.h>

#include "fricid/scene/problem.hpp"
#include "scene_folder.hpp"
#include "source_dir.hpp"

namespace fricid::scene {
namespace {

class BadScene : public FolderTest {
 protected:
  std::string error_of(const std::string& text) const {
    return message_of([&] { load_problem(write("scene.toml", text)); });
  }
  // The simple scene with one more line at the end of [robot] or with further sections.
  std::string with_robot(const std::string& line) const {
    return error_of(replaced(kScene, "[robot]\n", "[robot]\n" + line + "\n"));
  }
  std::string with(const std::string& sections) const { return error_of(kScene + sections); }
};

TEST_F(BadScene, UnknownKeyNamesTheNearest) {
  EXPECT_EQ(with("[excitation]\nharmonic = 5\n"),
            "scene.toml:13: unknown key excitation.harmonic; nearest known key: harmonics");
  EXPECT_EQ(error_of(std::string("sead = 5\n") + kScene),
            "scene.toml:1: unknown key sead; nearest known key: seed");
  EXPECT_EQ(with("[sensor]\nrate_hz = 5\n"),
            "scene.toml:12: unknown key sensor; nearest known key: sensors");
  EXPECT_EQ(with("[plant]\nxyzzy = 5\n"),
            "scene.toml:13: unknown key plant.xyzzy; known keys: step_s");
  EXPECT_EQ(with("[[model]]\nname = \"lugre\"\nseed = [1]\n"),
            "scene.toml:14: unknown key model[1].seed; nearest known key: seeds");
}

TEST_F(BadScene, WrongRange) {
  EXPECT_EQ(with("[excitation]\nharmonics = 700\n"),
            "scene.toml:13: excitation.harmonics = 700; allowed: a whole number from 2 to 200");
  EXPECT_EQ(with("[sensors]\nrate_hz = 0.0\n"),
            "scene.toml:13: sensors.rate_hz = 0; allowed: a number from 1 to 100000 Hz");
  EXPECT_EQ(with_robot("payload_kg = -1"),
            "scene.toml:3: robot.payload_kg = -1; allowed: a number from 0 to 2000 kg");
  EXPECT_EQ(with("[sensors]\ntorque_noise = nan\n"),
            "scene.toml:13: sensors.torque_noise = nan; allowed: a number from 0 to 1");
}

TEST_F(BadScene, JointsThatCannotBeFixedOrHeld) {
  EXPECT_EQ(with_robot("fix = {elbow = \"bent\"}"),
            "scene.toml:3: robot.fix.elbow = \"bent\"; allowed: {NAME = a number from -1000 to "
            "1000 rad or m, ...}");
  EXPECT_EQ(with_robot("fix = 0.3"),
            "scene.toml:3: robot.fix = 0.3; allowed: {NAME = a number from -1000 to 1000 rad or m, "
            "...}");
  EXPECT_EQ(with_robot("fix = {elbo = 0.3}"),
            "scene.toml:3: robot.fix: elbo is not a moving joint of arm.urdf; allowed: elbow, "
            "shoulder");
  EXPECT_EQ(with_robot("hold = [\"elbo\"]"),
            "scene.toml:3: robot.hold: elbo is not a moving joint of arm.urdf; allowed: elbow, "
            "shoulder");
  const std::string simulated =
      replaced(replaced(kScene, "[1.0, 0.5]", "1"), "mjcf = \"arm.xml\"\n", "");
  EXPECT_EQ(error_of(replaced(simulated, "[robot]", "[robot]\nhold = \"elbow\"")),
            "scene.toml:3: robot.hold = \"elbow\" without logs; allowed: robot.fix = {elbow = "
            "POSITION}");
  EXPECT_EQ(error_of(replaced(replaced(kScene, "[1.0, 0.5]", "1"), "[robot]",
                              "[robot]\nfix = {elbow = 0.5}")),
            "scene.toml:3: robot.fix beside robot.mjcf; allowed: one of them, without mjcf the "
            "simulator's arm is made of the URDF");
}

TEST_F(BadScene, MotorsThatCannotBeCoupled) {
  const auto coupled = [&](const std::string& joint, const std::string& motor,
                           const std::string& factor) {
    return with("[[robot.coupling]]\njoint = \"" + joint + "\"\nmotor = \"" + motor +
                "\"\nfactor = " + factor + "\n");
  };
  EXPECT_EQ(coupled("elbo", "shoulder", "1"),
            "scene.toml:13: robot.coupling[1].joint = \"elbo\"; allowed: shoulder, elbow");
  EXPECT_EQ(coupled("elbow", "motor", "1"),
            "scene.toml:14: robot.coupling[1].motor = \"motor\"; allowed: shoulder, elbow");
  EXPECT_EQ(coupled("elbow", "elbow", "1"),
            "scene.toml:12: robot.coupling[1] couples elbow with itself");
  EXPECT_EQ(coupled("elbow", "shoulder", "100"),
            "scene.toml:15: robot.coupling[1].factor = 100; allowed: a number from -10 to 10");
  EXPECT_EQ(with("[[robot.coupling]]\njoint = \"elbow\"\nmotor = \"shoulder\"\nfactor = 1\n"
                 "[[robot.coupling]]\njoint = \"shoulder\"\nmotor = \"elbow\"\nfactor = 1\n"),
            "scene.toml:16: robot.coupling[2], with those before it, leaves a joint that no motor "
            "turns alone; allowed: factors by which the motors turn every joint");
}

TEST_F(BadScene, PriorsThatAreNotThereOrDoNotApply) {
  EXPECT_THAT(with("[[model]]\nname = \"lvm\"\nprior = \"missing.json\"\n"),
              testing::StartsWith("scene.toml:14: model[0].prior: "));
  EXPECT_EQ(with("[[model]]\nname = \"gms\"\nprior = \"scene.toml\"\n"),
            "scene.toml:14: model[1].prior of a model of method conventional; allowed: joint");
  EXPECT_EQ(with("[[model]]\nname = \"gms\"\nnetworks = false\n"),
            "scene.toml:14: model[1].networks of a model that is no lvm; allowed: law = \"lvm\"");
}

TEST_F(BadScene, LatentsThatAModelCannotHave) {
  for (const int n_z : {0, 13})
    EXPECT_EQ(
        with(fmt::format("[[model]]\nname = \"lvm_paper\"\nn_z = {}\n", n_z)),
        fmt::format("scene.toml:14: model[1].n_z = {}; allowed: a whole number from 1 to 12", n_z));
  EXPECT_EQ(with("[[model]]\nname = \"gms\"\nn_z = 6\n"),
            "scene.toml:14: model[1].n_z = 6; allowed for gms: none");
  EXPECT_EQ(with("[[model]]\nname = \"lvm_paper\"\nlength = 2.0\n"),
            "scene.toml:14: model[1].length = 2; allowed: a number from 1e-06 to 1 rad");
  EXPECT_EQ(with("[[model]]\nname = \"nn\"\nlength = 0.004\n"),
            "scene.toml:14: model[1].length = 0.004; allowed for nn: none");
  EXPECT_EQ(with("[[model]]\nname = \"gms\"\nrigid_body_of = \"lugre\"\n"),
            "scene.toml:14: model[1].rigid_body_of = \"lugre\"; allowed for gms: none");
  EXPECT_THAT(with("[[model]]\nname = \"nn\"\nrigid_body_of = \"rnn\"\n"),
              testing::StartsWith("scene.toml:14: model[1].rigid_body_of = \"rnn\"; allowed: "));
}

// Degrees and millimetres fall outside the ranges in radians and metres.
TEST_F(BadScene, WrongUnit) {
  EXPECT_EQ(
      with("[excitation]\nhalf_range = 90\n"),
      "scene.toml:13: excitation.half_range = 90; allowed: a number from 0 to 12.6 rad, or an "
      "array of them for the 2 joints");
  EXPECT_EQ(with_robot("mount_rpy = [180, 0, 0]"),
            "scene.toml:3: robot.mount_rpy[1] = 180; allowed: an array of 3, each a number from "
            "-6.2832 to 6.2832 rad");
  EXPECT_EQ(
      with_robot("payload_com = [0, 0, 80]"),
      "scene.toml:3: robot.payload_com[3] = 80; allowed: an array of 3, each a number from -5 "
      "to 5 m");
}

TEST_F(BadScene, WrongType) {
  EXPECT_EQ(with("[sensors]\nrate_hz = \"fast\"\n"),
            "scene.toml:13: sensors.rate_hz = \"fast\"; allowed: a number from 1 to 100000 Hz");
  EXPECT_EQ(with("[sensors]\nvelocity = 1\n"),
            "scene.toml:13: sensors.velocity = 1; allowed: true or false");
  EXPECT_EQ(with("[excitation]\ntrain = 2.5\n"),
            "scene.toml:13: excitation.train = 2.5; allowed: a whole number from 1 to 1000");
  EXPECT_EQ(
      with("[excitation]\ncriterion = \"best\"\n"),
      "scene.toml:13: excitation.criterion = \"best\"; allowed: d_optimal, condition or none");
  EXPECT_EQ(error_of(std::string("name = 5\n") + kScene),
            "scene.toml:1: name = 5; allowed: a text");
  EXPECT_EQ(with("[evaluate]\nhorizons_s = 1\n"),
            "scene.toml:13: evaluate.horizons_s = 1; allowed: an array, each a number from 0 to "
            "100000 s");
  EXPECT_EQ(error_of(std::string("sensors = 5\n") + kScene),
            "scene.toml:1: sensors = 5; allowed: a table");
  EXPECT_EQ(with("[model]\nname = \"lugre\"\n"),
            "scene.toml:12: model = a table; allowed: tables [[model]]");
  EXPECT_EQ(
      with("[[model]]\nname = \"lugre\"\nseeds = [1, \"2\"]\n"),
      "scene.toml:14: model[1].seeds[2] = \"2\"; allowed: an array, each a whole number from 0 "
      "to 1e+09");
  EXPECT_EQ(
      with("[[model]]\nname = \"lugre\"\nseeds = 1979-05-27\n"),
      "scene.toml:14: model[1].seeds = a date or time; allowed: an array, each a whole number "
      "from 0 to 1e+09");
}

TEST_F(BadScene, WrongJointCount) {
  EXPECT_EQ(with("[sensors]\nencoder_noise_rad = [1e-5, 1e-5, 1e-5]\n"),
            "scene.toml:13: sensors.encoder_noise_rad = an array of 3; allowed: a number from 0 to "
            "0.1 rad, or an array of them for the 2 joints");
}

TEST_F(BadScene, MissingParts) {
  EXPECT_EQ(error_of(""), "scene.toml: robot.urdf is missing: the engine's robot");
  EXPECT_EQ(error_of("[robot]\nmount = \"floor\"\n"),
            "scene.toml:1: robot.urdf is missing: the engine's robot; beside the scene or in the "
            "share folder");
  EXPECT_EQ(error_of("[robot]\nurdf = \"arm.urdf\"\n"),
            "scene.toml: neither friction to inject nor logs; allowed: [friction] or data.train");
  EXPECT_EQ(with("[[model]]\nlabel = \"?\"\n"),
            "scene.toml:12: model[1].name is missing: name of its files, used once: letters, "
            "digits, _ - and .");
  EXPECT_EQ(
      error_of("[robot]\nurdf = \"arm.urdf\"\n[data]\ntrain = [\"a.csv\"]\n"),
      "scene.toml:3: data.contract is missing: column contract of the logs; only data sets of "
      "`fricid import` (.h5) need none");
  EXPECT_EQ(with("[data]\ntrain = [\"a.csv\"]\n"),
            "scene.toml:13: data.train beside [friction]; allowed: one of them");
}

TEST_F(BadScene, FilesThatAreNotThere) {
  EXPECT_EQ(message_of([&] { load_problem(path("none.toml")); }),
            "none.toml: cannot be read: No such file or directory");
  EXPECT_EQ(message_of([&] { load_problem(folder); }).find("folder") != std::string::npos, true);
  EXPECT_EQ(error_of(replaced(kScene, "arm.urdf", "leg.urdf")),
            "scene.toml:3: robot.urdf: leg.urdf is neither in  nor in " + source_dir().string());
  EXPECT_EQ(error_of(std::string("extends = \"base.toml\"\n") + kScene),
            "scene.toml:1: extends: base.toml is neither in  nor in " + source_dir().string());
}

TEST_F(BadScene, ExtendsInACircle) {
  write("a.toml", "extends = \"scene.toml\"\n");
  EXPECT_EQ(error_of("extends = \"a.toml\"\n"),
            "a.toml:1: extends = \"scene.toml\" leads back to a scene that extends it");
  EXPECT_EQ(error_of("extends = \"/dev/zero\"\n"),
            "scene.toml:1: extends: /dev/zero: is not a regular file");
  EXPECT_EQ(error_of("extends = \"/\"\n"),
            "scene.toml:1: extends: /: is a folder, a file is expected");
  EXPECT_EQ(error_of("[robot]\nurdf = \"/dev/zero\"\n"),
            "scene.toml:2: robot.urdf: /dev/zero: is not a regular file");
  EXPECT_EQ(error_of("extends = 3\n"),
            "scene.toml:1: extends = 3; allowed: a file name or an array of them");
}

// A mistake in a base scene is reported where it stands.
TEST_F(BadScene, MistakesOfABaseSceneNameItsFile) {
  write("base.toml", std::string(kScene) + "[sensors]\nrate_hz = -1\n");
  EXPECT_EQ(error_of("extends = \"base.toml\"\nseed = 3\n"),
            "base.toml:13: sensors.rate_hz = -1; allowed: a number from 1 to 100000 Hz");
  EXPECT_EQ(error_of("extends = \"base.toml\"\n[sensors]\nrate_hz = -2\n"),
            "scene.toml:3: sensors.rate_hz = -2; allowed: a number from 1 to 100000 Hz");
}

TEST_F(BadScene, NotToml) {
  EXPECT_THAT(error_of("[robot\nurdf = 1\n"), testing::StartsWith("scene.toml:1: not TOML: "));
  EXPECT_THAT(error_of(std::string(kScene) + "[robot]\n"),
              testing::StartsWith("scene.toml:12: not TOML: "));
  EXPECT_THAT(error_of("a = \"\xff\xfe\"\n"), testing::StartsWith("scene.toml:1: not TOML: "));
}

TEST_F(BadScene, StepMustDivideTheSamplePeriod) {
  EXPECT_EQ(
      with("[plant]\nstep_s = 0.003\n"),
      "scene.toml:13: plant.step_s = 0.003 s; allowed: the sample period 0.004 s over a whole "
      "number");
  EXPECT_EQ(with("[plant]\nstep_s = 0.01\n"),
            "scene.toml:13: plant.step_s = 0.01 s; allowed: the sample period 0.004 s over a whole "
            "number");
}

TEST_F(BadScene, Models) {
  EXPECT_EQ(with("[[model]]\nname = \"lugre\"\n[[model]]\nname = \"lugre\"\n"),
            "scene.toml:15: model[2].name = \"lugre\" is used twice");
  EXPECT_EQ(
      with("[[model]]\nname = \"../x\"\n"),
      "scene.toml:13: name of a model = \"../x\"; allowed: 1 to 100 letters, digits, _ - and ., "
      "not beginning with - or .");
  EXPECT_THAT(with("[[model]]\nname = \"lugree\"\n"),
              testing::StartsWith(
                  "scene.toml:13: model[1].name = \"lugree\"; allowed: lvm, injected, none, "));
  EXPECT_THAT(
      with("[[model]]\nname = \"a\"\nlaw = \"b\"\n"),
      testing::StartsWith("scene.toml:14: model[1].law = \"b\"; allowed: lvm, injected, none, "));
}

TEST_F(BadScene, Torques) {
  const auto torque = [&](const std::string& lines) {
    return error_of(
        replaced(kScene, "[friction]\n", "[[robot.torque]]\n" + lines + "\n[friction]\n"));
  };
  EXPECT_EQ(torque("joint = \"knee\"\nterms = [\"1\"]"),
            "scene.toml:7: robot.torque[1].joint = \"knee\"; allowed: shoulder, elbow");
  EXPECT_EQ(torque("joint = \"elbow\"\nterms = [\"1\", \"tan(q)\"]"),
            "scene.toml:8: robot.torque[1].terms[2] = \"tan(q)\"; allowed: 1, q, sin(q), cos(q), "
            "sin(2 q), sin(31.4 q), ...");
  for (const char* term :
       {"", "sin(", "sin(q", "sin(0 q)", "sin(inf q)", "sin(2e q)", "cos(-q)", "q q"})
    EXPECT_THAT(torque("joint = \"elbow\"\nterms = \"" + std::string(term) + "\""),
                testing::StartsWith("scene.toml:8: robot.torque[1].terms[1] = "));
  EXPECT_EQ(torque("joint = \"elbow\"\nterms = [\"1\"]\nprior_sd = [1, 2]"),
            "scene.toml:9: robot.torque[1].prior_sd = an array of 2; allowed: [] or 1 numbers, one "
            "per term");
  EXPECT_EQ(torque("joint = \"elbow\""),
            "scene.toml:6: robot.torque[1].terms is missing: shapes: 1, q, sin(q), cos(q), sin(2 "
            "q), sin(31.4 q), ...");
}

TEST_F(BadScene, Payload) {
  EXPECT_EQ(with_robot("payload_kg = 1\npayload_frame = \"hand\""),
            "scene.toml:4: robot.payload_frame = \"hand\"; allowed: base, upper, lower, flange");
  EXPECT_EQ(with_robot("payload_kg = 1\npayload_inertia = [0.1, 0.1, 0.5, 0, 0, 0]"),
            "scene.toml:4: robot.payload_inertia has principal moments 0.1, 0.1, 0.5 kg m^2; "
            "allowed: none negative, the largest at most the sum of the others");
}

TEST_F(BadScene, Robots) {
  const auto robot = [&](const std::string& from, const std::string& to) {
    write("arm.urdf", replaced(kArmUrdf, from, to));
    return error_of(kScene);
  };
  // Only the place and the object: the wording belongs to the reader of robots.
  EXPECT_THAT(robot("<mass value=\"2\"/>", "<mass value=\"-2\"/>"),
              testing::AllOf(testing::StartsWith("arm.urdf"), testing::HasSubstr("lower"),
                             testing::HasSubstr("-2")));
  const std::string lower = kArmUrdf;
  const std::size_t begin = lower.find("<inertial>", lower.find("name=\"lower\""));
  const std::size_t end = lower.find("</inertial>", begin) + 11;
  EXPECT_THAT(robot(lower.substr(begin, end - begin), ""),
              testing::AllOf(testing::StartsWith("arm.urdf"), testing::HasSubstr("lower"),
                             testing::HasSubstr("inertia")));
}

TEST_F(BadScene, ContractOfAnotherRobot) {
  write("contract.toml",
        "joint_names = [\"a\", \"b\", \"c\"]\nposition.columns = \"q{}\"\n"
        "torque.columns = \"tau{}\"\n");
  EXPECT_EQ(error_of("[robot]\nurdf = \"arm.urdf\"\n[data]\ncontract = \"contract.toml\"\n"
                     "train = [\"a.csv\"]\n"),
            "scene.toml:4: data.contract has the joints a, b, c; allowed: those of the robot, "
            "shoulder, elbow");
}

}  // namespace
}  // namespace fricid::scene
