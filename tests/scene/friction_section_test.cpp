#include <gmock/gmock.h>

#include "fricid/scene/problem.hpp"
#include "scene_folder.hpp"

namespace fricid::scene {
namespace {

using testing::ElementsAre;

class FrictionSection : public FolderTest {
 protected:
  static std::string scene(const std::string& friction) {
    return "[robot]\nurdf = \"arm.urdf\"\nmjcf = \"arm.xml\"\n[friction]\n" + friction;
  }
  friction::Friction load(const std::string& friction) const {
    return *load_problem(write("scene.toml", scene(friction))).scene.friction;
  }
  std::string error_of(const std::string& friction) const {
    return message_of([&] { load(friction); });
  }
};

double value_of(const friction::Friction& f, int joint, std::string_view symbol) {
  const auto& parameters = f.model.parameters();
  for (std::size_t p = 0; p < parameters.size(); ++p)
    if (parameters[p].joint == joint && parameters[p].symbol == symbol) return f.theta[p];
  ADD_FAILURE() << "no parameter " << symbol;
  return 0;
}

constexpr char kDahl[] = "[[friction.law]]\nlaw = \"dahl\"\nFc = 5\nsigma0 = 1e4\nFv = [1, 2]\n";

TEST_F(FrictionSection, NumbersAndArraysOverJoints) {
  EXPECT_THAT(load(kDahl).theta, ElementsAre(5, 1e4, 1, 5, 1e4, 2));
}

TEST_F(FrictionSection, LawsAddUpInFileOrderOnTheirJoints) {
  const friction::Friction f = load(std::string(kDahl) +
                                    "[[friction.law]]\nlaw = \"viscous_power\"\n"
                                    "joints = [\"elbow\"]\nc = [7]\np = 0.5\nv0 = 0.01\n");
  ASSERT_EQ(f.model.joints()[0].laws.size(), 1u);
  ASSERT_EQ(f.model.joints()[1].laws.size(), 2u);
  EXPECT_EQ(f.model.joints()[1].laws[1].law, "viscous_power");
  EXPECT_THAT(f.theta, ElementsAre(5, 1e4, 1, 5, 1e4, 2, 7, 0.5, 0.01));
}

TEST_F(FrictionSection, JointsMayComeInAnyOrder) {
  const friction::Friction f = load(
      "[[friction.law]]\nlaw = \"dahl\"\njoints = [\"elbow\", \"shoulder\"]\nFc = [1, 2]\n"
      "sigma0 = 1e4\nFv = 0\n");
  EXPECT_THAT(f.theta, ElementsAre(2, 1e4, 0, 1, 1e4, 0));
}

// The same values said in three ways: per joint and element, as a product, and as one number.
TEST_F(FrictionSection, FamiliesOfElements) {
  const std::string law = "[[friction.law]]\nlaw = \"maxwell_slip\"\nelements = 3\nW = 2\n";
  const auto rows = load(law + "K = [[10, 20, 30], [5, 10, 15]]\n").theta;
  const auto product = load(law + "K = {elements = [10, 20, 30], joints = [1, 0.5]}\n").theta;
  const auto scaled = load(law + "K = {elements = [10, 20, 30], joints = 1}\n").theta;
  EXPECT_THAT(rows, testing::UnorderedElementsAre(10, 20, 30, 2, 2, 2, 5, 10, 15, 2, 2, 2));
  EXPECT_EQ(product, rows);
  EXPECT_EQ(std::vector<double>(scaled.begin(), scaled.begin() + 6),
            std::vector<double>(rows.begin(), rows.begin() + 6));
  const friction::Friction f = load(law + "K = [[10, 20, 30], [5, 10, 15]]\n");
  EXPECT_EQ(value_of(f, 1, "K3"), 15);
}

// The most elements a law can have, and one more.
TEST_F(FrictionSection, NumberOfElements) {
  const auto law = [](int elements) {
    return "[[friction.law]]\nlaw = \"maxwell_slip\"\nelements = " + std::to_string(elements) +
           "\nK = 10\nW = 2\n";
  };
  const auto rows = friction::law_table();
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [](const auto& info) { return info.name == "maxwell_slip"; });
  const int most = row->most_elements;
  EXPECT_EQ(load(law(1)).theta.size(), 2u * 2);
  EXPECT_EQ(load(law(most)).theta.size(), 2u * 2 * static_cast<std::size_t>(most));
  EXPECT_EQ(error_of(law(most + 1)),
            fmt::format("scene.toml:7: friction.law[1].elements = {}; allowed: a whole number from "
                        "1 to {}",
                        most + 1, most));
}

// Whatever order the keys come in, modifiers apply in the order of the table.
TEST_F(FrictionSection, ModifiersFollowTheTable) {
  std::string text = kDahl;
  std::vector<std::string> known;
  for (const friction::LawInfo& row : friction::modifier_table()) known.emplace_back(row.name);
  for (auto row = friction::modifier_table().rbegin(); row != friction::modifier_table().rend();
       ++row) {
    text += std::string(row->name) + " = {";
    std::string separator;
    for (const friction::ParameterInfo& info : friction::parameters_of_modifier(row->name, 1)) {
      std::string key(info.symbol);
      if (row->has_elements) key = key.substr(0, key.find_last_not_of("0123456789") + 1);
      text += separator + key + " = " + std::to_string(info.typical);
      separator = ", ";
    }
    text += "}\n";
  }
  const friction::Friction f = load(text);
  std::vector<std::string> found;
  for (const friction::ModifierSpec& modifier : f.model.joints()[1].laws[0].modifiers)
    found.push_back(modifier.name);
  EXPECT_EQ(found, known);
  EXPECT_EQ(f.theta.size(), static_cast<std::size_t>(f.model.parameter_count()));
}

TEST_F(FrictionSection, RippleOfTwoOrders) {
  const friction::Friction f = load(
      std::string(kDahl) +
      "ripple = {order = 2, n = {elements = [1, 2], joints = [100, 120]}, A = 0.1, phi = 0}\n");
  const friction::ModifierSpec& ripple = f.model.joints()[0].laws[0].modifiers[0];
  EXPECT_EQ(ripple.order, 2);
  EXPECT_EQ(value_of(f, 0, "n1"), 100);
  EXPECT_EQ(value_of(f, 0, "n2"), 200);
  EXPECT_EQ(value_of(f, 1, "n1"), 120);
  EXPECT_EQ(value_of(f, 1, "n2"), 240);
}

TEST_F(FrictionSection, MissingParameterIsNamedWithUnitAndBounds) {
  EXPECT_EQ(error_of("[[friction.law]]\nlaw = \"dahl\"\nFc = 5\nFv = 1\n"),
            "scene.toml:5: friction.law[1].sigma0 is missing; dahl needs it: bristle stiffness, "
            "allowed: 0.01 to 1e+09 N m/rad");
  EXPECT_EQ(error_of(std::string(kDahl) + "load = {}\n"),
            "scene.toml:10: friction.law[1].load.mu is missing; load needs it: relative growth per "
            "N m of load, allowed: 0 to 1 1/(N m)");
}

TEST_F(FrictionSection, OutOfBounds) {
  EXPECT_EQ(error_of(replaced(kDahl, "Fc = 5", "Fc = -3")),
            "scene.toml:7: friction.law[1].Fc = -3 N m (joint shoulder); allowed: 1e-06 to 1e+06 "
            "N m");
  EXPECT_EQ(error_of(replaced(kDahl, "[1, 2]", "[1, 2e9]")),
            "scene.toml:9: friction.law[1].Fv = 2000000000 N m s/rad (joint elbow); allowed: 0 to "
            "1e+06 N m s/rad");
  EXPECT_EQ(error_of(replaced(kDahl, "Fc = 5", "Fc = nan")),
            "scene.toml:7: friction.law[1].Fc = nan N m (joint shoulder); allowed: 1e-06 to 1e+06 "
            "N m");
}

TEST_F(FrictionSection, WrongShape) {
  EXPECT_EQ(error_of(replaced(kDahl, "[1, 2]", "[1, 2, 3]")),
            "scene.toml:9: friction.law[1].Fv = an array of 3; allowed: a number, or an array of 2 "
            "numbers, one per joint");
  EXPECT_EQ(error_of("[[friction.law]]\nlaw = \"maxwell_slip\"\nelements = 3\nW = 2\nK = [1, 2]\n"),
            "scene.toml:9: friction.law[1].K = an array of 2; allowed: a number, 2 arrays (joints) "
            "of 3 numbers (elements), or {elements = [3 numbers], joints = [2 numbers]}");
}

TEST_F(FrictionSection, UnknownNames) {
  EXPECT_THAT(error_of("[[friction.law]]\nlaw = \"dhal\"\n"),
              testing::StartsWith("scene.toml:6: friction.law[1].law = \"dhal\"; allowed: none, "));
  EXPECT_EQ(error_of(std::string(kDahl) + "Fs = 6\n"),
            "scene.toml:10: unknown key friction.law[1].Fs; nearest known key: Fc");
  EXPECT_EQ(error_of(std::string(kDahl) + "joints = [\"knee\"]\n"),
            "scene.toml:10: friction.law[1].joints has \"knee\"; allowed: shoulder, elbow");
  EXPECT_EQ(error_of(std::string(kDahl) + "joints = [\"elbow\", \"elbow\"]\n"),
            "scene.toml:10: friction.law[1].joints has \"elbow\" twice");
  EXPECT_EQ(error_of(std::string(kDahl) + "load = {mv = 1}\n").substr(0, 14), "scene.toml:10:");
  EXPECT_EQ(error_of(std::string(kDahl) + "load = 0.1\n"),
            "scene.toml:10: friction.law[1].load = 0.1; allowed: a table of its parameters");
  EXPECT_EQ(error_of("load = \"gear\"\n" + std::string(kDahl)),
            "scene.toml:5: friction.load = \"gear\"; allowed: motor_torque");
  EXPECT_EQ(error_of("law = 3\n"),
            "scene.toml:5: friction.law = 3; allowed: tables [[friction.law]]");
}

// Oracle: the shares of the header, by hand; the efforts are 80 and 40 N m.
TEST_F(FrictionSection, WithoutLawsIsSizedByTheEffortLimits) {
  const std::string text =
      replaced(kScene, std::string(kScene).substr(std::string(kScene).find("[[")), "");
  const Problem problem = load_problem(write("scene.toml", text));
  const friction::Friction& friction = *problem.scene.friction;
  std::vector<double> Fc, sigma2;
  for (std::size_t i = 0; i < friction.theta.size(); ++i) {
    if (friction.model.parameters()[i].symbol == "Fc") Fc.push_back(friction.theta[i]);
    if (friction.model.parameters()[i].symbol == "sigma2") sigma2.push_back(friction.theta[i]);
  }
  EXPECT_THAT(Fc, testing::ElementsAre(0.06 * 80, 0.06 * 40));
  EXPECT_THAT(sigma2, testing::ElementsAre(0.2 * 80 / 4, 0.2 * 40 / 5));
  const std::string again = to_toml(problem.scene);
  EXPECT_EQ(load_problem(write("again.toml", again)).scene.friction->theta, friction.theta);
}

}  // namespace
}  // namespace fricid::scene
