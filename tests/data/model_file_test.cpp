#include "fricid/data/model_file.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "fricid/base/enum_names.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

// The last of each: a name too few or too many would shift it.
static_assert(name_of(dynamics::JointType::kPrismatic) == "prismatic");
static_assert(name_of(dynamics::LinearTorque::Shape::kLinear) == "q");

class ModelJson : public FolderTest {
 protected:
  // Values with every bit in use, signed zeros, and each law and modifier of the tables.
  ModelFile make_model() const {
    ModelFile model{.name = "all",
                    .label = "Äll \"laws\"",
                    .seed = 3,
                    .arm = {},
                    .budget = "7 steps (windows)"};
    model.free_parameters = 12;
    model.is_oracle = true;
    dynamics::RobotModel& robot = model.arm.robot;
    robot = dynamics::load_urdf(path("arm.urdf"));
    dynamics::add_linear_torque(
        robot,
        {.name = "spring", .joint = 1, .shape = dynamics::LinearTorque::Shape::kCos, .k = 2});
    dynamics::add_linear_torque(robot, {.name = "offset"});
    for (int i = 0; i < robot.pi.size(); ++i) robot.pi[i] *= 1 + 1e-3 / (7 + i);
    robot.pi[12] = -0.0;
    const double c = std::cos(1.0), s = std::sin(1.0);
    robot.joints[1].R0 << c, -s, 0, s, c, 0, 0, 0, 1;
    robot.joints[1].continuous = true;
    robot.joints[1].upper = std::numeric_limits<double>::infinity();
    robot.joints[1].lower = -robot.joints[1].upper;
    robot.joints[1].acceleration = std::sqrt(2.0);
    robot.gravity = Eigen::Vector3d(0.1, 0.2, -9.81);
    robot.couplings = {{.joint = 1, .motor = 0, .factor = std::sqrt(0.1)}};

    std::vector<friction::JointSpec> joints(2);
    for (const friction::LawInfo& row : friction::law_table())
      joints[0].laws.push_back(
          {.law = std::string(row.name), .elements = row.has_elements ? 5 : 0, .modifiers = {}});
    joints[1].laws.push_back({.law = "lugre", .elements = 0, .modifiers = {}});
    for (const friction::LawInfo& row : friction::modifier_table())
      joints[1].laws[0].modifiers.push_back(
          {.name = std::string(row.name), .order = row.has_elements ? 3 : 1});
    model.arm.friction.model = friction::RobotFriction(joints, {.law = "nn", .elements = 3});
    const auto& parameters = model.arm.friction.model.parameters();
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      const friction::ParameterInfo& info = parameters[p].info;
      model.arm.friction.theta.push_back(info.lower + (info.upper - info.lower) /
                                                          (3.0 + static_cast<double>(p)));
    }
    return model;
  }

  std::string error_of(const std::string& text) const {
    write("bad.json", text);
    return message_of([&] { load_model(path("bad.json")); });
  }
};

template <class A, class B>
bool same_bits(const A& a, const B& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

TEST_F(ModelJson, RoundTripToTheLastBit) {
  const ModelFile model = make_model();
  save_model(model, path("models/all_s3.json"));
  const ModelFile read = load_model(path("models/all_s3.json"));
  EXPECT_EQ(read.name, model.name);
  EXPECT_EQ(read.label, model.label);
  EXPECT_EQ(read.seed, 3);
  EXPECT_EQ(read.free_parameters, 12);
  EXPECT_EQ(read.budget, model.budget);
  EXPECT_TRUE(read.is_oracle);

  const dynamics::RobotModel &a = read.arm.robot, &b = model.arm.robot;
  EXPECT_EQ(a.joints_of_motors(), b.joints_of_motors());
  EXPECT_EQ(a.name, b.name);
  EXPECT_TRUE(same_bits(a.pi, b.pi));
  EXPECT_TRUE(same_bits(a.gravity, b.gravity));
  ASSERT_EQ(a.n(), b.n());
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    const dynamics::Joint &x = a.joints[i], &y = b.joints[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.link, y.link);
    EXPECT_EQ(x.type, y.type);
    EXPECT_EQ(x.continuous, y.continuous);
    EXPECT_EQ(x.parent, y.parent);
    EXPECT_TRUE(same_bits(x.R0, y.R0));
    EXPECT_TRUE(same_bits(x.p0, y.p0));
    EXPECT_TRUE(same_bits(x.axis, y.axis));
    EXPECT_EQ(x.lower, y.lower);
    EXPECT_EQ(x.upper, y.upper);
    EXPECT_EQ(x.velocity, y.velocity);
    EXPECT_EQ(x.effort, y.effort);
    EXPECT_EQ(x.acceleration, y.acceleration);
    EXPECT_EQ(x.jerk, y.jerk);
  }
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].name, b.frames[i].name);
    EXPECT_EQ(a.frames[i].link, b.frames[i].link);
    EXPECT_TRUE(same_bits(a.frames[i].R, b.frames[i].R));
    EXPECT_TRUE(same_bits(a.frames[i].p, b.frames[i].p));
  }
  ASSERT_EQ(a.linear_torques.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(a.linear_torques[i].name, b.linear_torques[i].name);
    EXPECT_EQ(a.linear_torques[i].joint, b.linear_torques[i].joint);
    EXPECT_EQ(a.linear_torques[i].shape, b.linear_torques[i].shape);
    EXPECT_EQ(a.linear_torques[i].k, b.linear_torques[i].k);
  }
  EXPECT_TRUE(same_bits(read.arm.friction.theta, model.arm.friction.theta));
  const auto& laws = read.arm.friction.model.joints();
  for (std::size_t j = 0; j < laws.size(); ++j) {
    ASSERT_EQ(laws[j].laws.size(), model.arm.friction.model.joints()[j].laws.size());
    for (std::size_t i = 0; i < laws[j].laws.size(); ++i) {
      const friction::LawSpec& law = model.arm.friction.model.joints()[j].laws[i];
      EXPECT_EQ(laws[j].laws[i].law, law.law);
      EXPECT_EQ(laws[j].laws[i].elements, law.elements);
      ASSERT_EQ(laws[j].laws[i].modifiers.size(), law.modifiers.size());
      for (std::size_t m = 0; m < law.modifiers.size(); ++m) {
        EXPECT_EQ(laws[j].laws[i].modifiers[m].name, law.modifiers[m].name);
        EXPECT_EQ(laws[j].laws[i].modifiers[m].order, law.modifiers[m].order);
      }
    }
  }
  EXPECT_EQ(read.arm.friction.model.whole().law, "nn");
  EXPECT_EQ(read.arm.friction.model.whole().elements, 3);
  save_model(read, path("again.json"));
  EXPECT_EQ(this->read("again.json"), this->read("models/all_s3.json"));
}

TEST_F(ModelJson, KeepsWhyNotToTrustIt) {
  ModelFile model = make_model();
  EXPECT_EQ(model_text(model).find("doubts"), std::string::npos);
  model.doubts = {"joint 1: R2 -2; look for a wrong sign", "two"};
  save_model(model, path("doubtful.json"));
  EXPECT_EQ(load_model(path("doubtful.json")).doubts, model.doubts);
  model.doubts = {"a\x1b[31m"};
  EXPECT_EQ(parse_model(model_text(model), "m.json").doubts[0], "a\\x1b[31m");
}

TEST_F(ModelJson, ARobotWithoutFrictionIsAModelToo) {
  ModelFile model = make_model();
  model.arm.friction = {};
  save_model(model, path("a.json"));
  const friction::Friction friction = load_model(path("a.json")).arm.friction;
  EXPECT_EQ(friction.model.joint_count(), 2);
  EXPECT_TRUE(friction.theta.empty());
}

// A file of before has the units of a joint that turns; it is read.
TEST_F(ModelJson, FrictionOfASlidingJointIsAForce) {
  ModelFile model = make_model();
  friction::Friction& friction = model.arm.friction;
  friction.model = friction::RobotFriction({{{{"lugre", 0, {}}}}, {{{"lugre", 0, {}}}}});
  friction.theta = friction::default_theta(friction.model);
  save_model(model, path("turning.json"));
  model.arm.robot.joints[1].type = dynamics::JointType::kPrismatic;
  model.arm.robot.joints[1].continuous = false;
  model.arm.robot.joints[1].lower = -1;
  model.arm.robot.joints[1].upper = 1;
  save_model(model, path("a.json"));
  const auto unit = [](const std::string& text, int joint, const char* symbol) {
    return nlohmann::json::parse(
               text)["friction"][static_cast<std::size_t>(joint)][0]["parameters"][symbol]["unit"]
        .get<std::string>();
  };
  const std::string text = read("a.json");
  EXPECT_EQ(unit(text, 0, "Fc"), "N m");
  EXPECT_EQ(unit(text, 0, "sigma2"), "N m s/rad");
  EXPECT_EQ(unit(text, 1, "Fc"), "N");
  EXPECT_EQ(unit(text, 1, "sigma0"), "N/m");
  EXPECT_EQ(unit(text, 1, "sigma2"), "N s/m");
  EXPECT_EQ(unit(text, 1, "vs"), "m/s");
  EXPECT_EQ(load_model(path("a.json")).arm.friction.theta, friction.theta);

  auto older = nlohmann::ordered_json::parse(text);
  older["friction"] = nlohmann::ordered_json::parse(read("turning.json"))["friction"];
  write("older.json", older.dump());
  EXPECT_EQ(load_model(path("older.json")).arm.friction.theta, friction.theta);
  older["friction"][1][0]["parameters"]["Fc"]["unit"] = "kN";
  EXPECT_THAT(error_of(older.dump()), testing::HasSubstr("found \"kN\"; allowed: N"));
}

TEST_F(ModelJson, TruncatedAtEveryByteIsAnError) {
  ModelFile model = make_model();
  friction::Friction& friction = model.arm.friction;  // few parameters: every byte costs a file
  friction.model = friction::RobotFriction({{{{"lugre", 0, {{"ripple", 1}}}}}, {}});
  friction.theta = friction::default_theta(friction.model);
  save_model(model, path("a.json"));
  const std::string whole = read("a.json");
  // The last byte is the end of the line, after a complete object.
  for (std::size_t length = 1; length + 1 < whole.size(); ++length)
    ASSERT_THAT(error_of(whole.substr(0, length)),
                testing::AllOf(testing::StartsWith("bad.json:"),
                               testing::HasSubstr(": not JSON, or torn: ")))
        << "length " << length;
}

TEST_F(ModelJson, MistakesAreNamed) {
  save_model(make_model(), path("a.json"));
  const std::string whole = read("a.json");
  const auto changed = [&](const std::string& from, const std::string& to) {
    return error_of(replaced(whole, from, to));
  };
  EXPECT_EQ(changed("\"seed\": 3", "\"seed\": -3"),
            "bad.json: seed: found -3; allowed: 0 to 1e+09");
  EXPECT_EQ(changed("\"seed\": 3", "\"sead\": 3"), "bad.json: found no seed");
  EXPECT_EQ(changed("\"is_oracle\": true", "\"is_oracle\": 1"),
            "bad.json: is_oracle: found 1; allowed: true or false");
  EXPECT_EQ(
      changed("fricid.model/1", "fricid.model/2"),
      "bad.json: format fricid.model/2 is newer than fricid.model/1, which this program reads");
  EXPECT_EQ(changed("fricid.model/1", "fricid.evaluation/1"),
            "bad.json: found \"fricid.evaluation/1\"; allowed: \"format\": \"fricid.model/1\"");
  EXPECT_EQ(changed("\"parent\": 0", "\"parent\": 1"),
            "bad.json: robot.joints[1].parent: found 1; allowed: -1 to 0");
  EXPECT_EQ(changed("\"type\": \"revolute\"", "\"type\": \"screw\""),
            "bad.json: robot.joints[0].type: found \"screw\"; allowed: revolute, prismatic");
  EXPECT_EQ(changed("\"shape\": \"cos(k q)\"", "\"shape\": \"tan(k q)\""),
            "bad.json: robot.linear_torques[0].shape: found \"tan(k q)\"; allowed: 1, sin(k q), "
            "cos(k q), q");
  EXPECT_EQ(changed("\"motor\": 0", "\"motor\": 1"),
            "bad.json: robot.couplings[0].motor: found 1; allowed: another joint");
  EXPECT_EQ(changed("\"motor\": 0", "\"motor\": 2"),
            "bad.json: robot.couplings[0].motor: found 2; allowed: 0 to 1");
  EXPECT_THAT(changed("\"law\": \"gms\"", "\"law\": \"gm\""),
              testing::StartsWith("bad.json: friction[0][10].law: found \"gm\"; allowed: "));
  EXPECT_THAT(changed("\"sigma0\"", "\"sigma9\""),
              testing::EndsWith(".parameters.sigma0"));  // found none
  EXPECT_THAT(changed("\"free_parameters\": 12", "\"free_parameters\": null"),
              testing::EndsWith("found null; allowed: a whole number"));
  EXPECT_THAT(changed("\"mass\": ", "\"mass\": null, \"was\": "),
              testing::EndsWith("moves.mass: found null; allowed: a number"));
  EXPECT_THAT(changed("\"unit\": \"N m/rad\"", "\"unit\": \"N m/deg\""),
              testing::EndsWith("found \"N m/deg\"; allowed: N m/rad"));
  EXPECT_EQ(error_of(""), "bad.json: an empty file");
  EXPECT_EQ(error_of("[]"), "bad.json: found no format; allowed: \"format\": \"fricid.model/1\"");
  EXPECT_EQ(error_of(std::string(100'000, '[')),
            "bad.json: 33 levels of lists and objects in a JSON file; allowed: up to 32");
  EXPECT_EQ(error_of("{\"format\": 1e400}"), "bad.json: not JSON: number overflow parsing '1e400'");
  EXPECT_EQ(message_of([&] { load_model(path("none.json")); }),
            "none.json: cannot be read: No such file or directory");
}

TEST_F(ModelJson, ParametersOutOfBoundsAreNamed) {
  ModelFile model = make_model();
  const auto& parameters = model.arm.friction.model.parameters();
  std::size_t p = 0;
  while (parameters[p].owner != "dahl" || parameters[p].symbol != "sigma0") ++p;
  model.arm.friction.theta[p] = -1;
  save_model(model, path("a.json"));
  EXPECT_EQ(message_of([&] { load_model(path("a.json")); }),
            "a.json: friction[0][7].parameters.sigma0.value: found -1; allowed: 0.01 to 1e+09");
}

TEST_F(ModelJson, RobotsThatNoBodyCanBeAreRefused) {
  const auto refused = [&](auto change) {
    ModelFile model = make_model();
    change(model.arm.robot);
    save_model(model, path("a.json"));
    return message_of([&] { load_model(path("a.json")); });
  };
  EXPECT_EQ(refused([](auto& robot) { robot.pi[0] = -1; }),
            "a.json: robot.joints[0].moves.mass: found -1; allowed: above 0");
  EXPECT_THAT(
      refused([](auto& robot) { robot.pi[4] = -1; }),
      testing::AllOf(testing::StartsWith("a.json: robot.joints[0].moves.inertia: found -1 "),
                     testing::EndsWith("of a body of this mass and first moment")));
  EXPECT_EQ(refused([](auto& robot) { robot.pi[robot.armature_begin()] = -1; }),
            "a.json: robot.joints[0].armature: found -1.0; allowed: 0 or more");
  EXPECT_EQ(refused([](auto& robot) { robot.joints[1].effort = -1; }),
            "a.json: robot.joints[1].effort: found -1.0; allowed: 0 or more");
}

TEST_F(ModelJson, WhatALawRefusesIsToldWithTheFile) {
  using Json = nlohmann::ordered_json;
  ModelFile model = make_model();
  model.arm.friction.model = friction::RobotFriction({{{{"lugre", 0, {{"load", 1}}}}}, {}});
  model.arm.friction.theta = friction::default_theta(model.arm.friction.model);
  save_model(model, path("a.json"));
  Json json = Json::parse(read("a.json"));
  Json& modifiers = json["friction"][0][0]["modifiers"];
  modifiers.push_back(modifiers[0]);
  EXPECT_EQ(error_of(json.dump()),
            "bad.json: friction: lugre: modifier 'load' is given more than once");
  json["robot"]["joints"] = Json(std::vector<Json>(1001, json["robot"]["joints"][0]));
  EXPECT_EQ(error_of(json.dump()),
            "bad.json: robot.joints: 1001 joints of a model; allowed: up to 1000");
}

TEST_F(ModelJson, NumbersThatJsonCannotHoldAreRefused) {
  ModelFile model = make_model();
  model.arm.robot.pi[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_of([&] { save_model(model, path("a.json")); }),
            "a.json: robot.joints[0].moves.first_moment: found nan; allowed: finite");
  EXPECT_FALSE(std::filesystem::exists(path("a.json")));
}

}  // namespace
}  // namespace fricid::data
