// Every parameter of every table says what it is, and a law can be started by that alone.
#include "fricid/friction/role.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "fricid/friction/robot_friction.hpp"

namespace fricid::friction {
namespace {

// Calls f(name, parameters) for every law, modifier and law of the whole robot.
template <class F>
void for_each_table(F&& f) {
  for (const LawInfo& law : law_table())
    for (const int n : {1, 4}) f(std::string(law.name), parameters_of_law(law.name, n));
  for (const LawInfo& modifier : modifier_table())
    for (const int n : {1, 3})
      f(std::string(modifier.name), parameters_of_modifier(modifier.name, n));
  for (const LawInfo& law : robot_law_table())
    f(std::string(law.name), parameters_of_robot_law(law.name, {2, 4}));
}

TEST(Roles, EveryParameterHasOneAndItsUnit) {
  for_each_table([](const std::string& name, const std::vector<ParameterInfo>& parameters) {
    for (const ParameterInfo& p : parameters) {
      EXPECT_NE(p.role, Role::kNone) << name << " " << p.symbol;
      EXPECT_EQ(p.unit, role_unit(p.role)) << name << " " << p.symbol;
    }
  });
}

TEST(Roles, NumberedFamiliesCountFromOneAndOthersAreAlone) {
  for_each_table([](const std::string& name, const std::vector<ParameterInfo>& parameters) {
    std::set<std::string> symbols;
    for (const ParameterInfo& p : parameters) {
      EXPECT_TRUE(symbols.insert(std::string(p.symbol)).second) << name << " " << p.symbol;
      if (p.element == 0) continue;
      EXPECT_EQ(p.symbol, std::string(p.stem()) + std::to_string(p.element)) << name;
    }
  });
}

// A ripple is searched wave by wave: its amplitude and phase are looked for behind its number.
TEST(Roles, AmplitudeAndPhaseFollowTheirWaveNumber) {
  for_each_table([](const std::string& name, const std::vector<ParameterInfo>& parameters) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i].role != Role::kWaveNumber) continue;
      ASSERT_LT(i + 2, parameters.size()) << name;
      EXPECT_EQ(parameters[i + 1].role, Role::kAmplitude) << name;
      EXPECT_EQ(parameters[i + 2].role, Role::kPhase) << name;
    }
  });
}

// Twice the Coulomb torque starts every torque at twice its typical value, a viscous coefficient
// starts as given, and the rest, lengths, speeds and weights, where it is typical.
TEST(Roles, EveryLawStartsFromAGuess) {
  for (const LawInfo& law : law_table()) {
    const RobotFriction model({JointSpec{{{std::string(law.name), law.has_elements ? 4 : 0, {}}}}});
    const int sized = std::max(find_parameter(model, 0, Role::kCoulomb),
                               find_parameter(model, 0, Role::kNetworkTorque));
    const double typical =
        sized < 0 ? 1 : model.parameters()[static_cast<std::size_t>(sized)].info.typical;
    const double grows = sized < 0 ? 1 : 2;
    const std::vector<double> theta = start_from(model, {.Fc = 2 * typical, .Fv = 0.75});
    ASSERT_EQ(theta.size(), model.parameters().size());
    for (std::size_t i = 0; i < theta.size(); ++i) {
      const ParameterInfo& p = model.parameters()[i].info;
      EXPECT_DOUBLE_EQ(theta[i], p.role == Role::kViscous ? 0.75
                                 : is_torque(p.role)      ? grows * p.typical
                                                          : p.typical)
          << law.name << " " << p.symbol;
    }
  }
}

TEST(Roles, AGuessBeyondTheBoundsStartsOnThem) {
  const RobotFriction model({JointSpec{{{"lugre", 0, {}}}}});
  for (const double guess : {0.0, 1e12}) {
    const std::vector<double> theta = start_from(model, {.Fc = guess, .Fv = guess});
    for (std::size_t i = 0; i < theta.size(); ++i) {
      EXPECT_GE(theta[i], model.parameters()[i].info.lower);
      EXPECT_LE(theta[i], model.parameters()[i].info.upper);
    }
  }
}

TEST(Roles, FindsParametersByRoleAndByName) {
  const RobotFriction model(
      {JointSpec{{{"coulomb_viscous", 0, {}}}}, JointSpec{{{"dahl", 0, {{"viscosity"}}}}}});
  EXPECT_EQ(find_parameter(model, 1, Role::kStiffness), 4);
  EXPECT_EQ(find_parameter(model, 0, Role::kStiffness), -1);
  EXPECT_EQ(find_parameter(model, 1, "dahl", "Fv"), 5);
  EXPECT_EQ(find_parameter(model, 1, "", "Fv"), 5);
  EXPECT_EQ(find_parameter(model, 1, "viscosity", "Fv"), 6);
  EXPECT_EQ(find_parameter(model, 1, "dahl", "C"), -1);
}

// A legend is of use only where laws differ.
TEST(Roles, EveryLawHasAColourOfItsOwn) {
  std::set<std::string_view> colours;
  for (const auto table : {law_table(), robot_law_table()})
    for (const LawInfo& law : table) {
      EXPECT_TRUE(law.look.colour.size() == 7 && law.look.colour[0] == '#' &&
                  law.look.colour.find_first_not_of("0123456789ABCDEF", 1) ==
                      std::string_view::npos)
          << law.name;
      EXPECT_TRUE(colours.insert(law.look.colour).second) << law.name;
      EXPECT_GT(law.look.marker, 0) << law.name;
    }
}

}  // namespace
}  // namespace fricid::friction
