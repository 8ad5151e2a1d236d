// RobotFriction: where parameters and states lie, sums and modifiers, messages, no allocation.
#include "fricid/friction/robot_friction.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <new>

#include "allocation_counter.hpp"
#include "fricid/base/error.hpp"
#include "subjects.hpp"

namespace fricid::friction::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string message_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(RobotFriction, StacksJointsThenLawsThenModifiers) {
  const RobotFriction model({
      {{{"lugre", 0, {{"load"}, {"backlash"}}}, {"viscous_power", 0, {}}}},
      {},
      {{{"gms", 2, {}}}},
  });
  EXPECT_EQ(model.joint_count(), 3);
  EXPECT_EQ(model.state_size(), 1 + 1 + 2);
  EXPECT_EQ(model.parameter_count(), 6 + 1 + 1 + 3 + 9);
  EXPECT_EQ(model.parameter_begin(1), 11);
  EXPECT_EQ(model.parameter_begin(2), 11);
  EXPECT_EQ(model.parameter_begin(3), 20);
  EXPECT_EQ(model.state_begin(1), 2);
  EXPECT_EQ(model.state_begin(3), 4);

  std::vector<std::string> names;
  for (const ParameterRef& p : model.parameters())
    names.push_back(std::to_string(p.joint) + "." + std::to_string(p.law) + "." + p.owner + "." +
                    p.symbol);
  EXPECT_EQ(names, (std::vector<std::string>{
                       "0.0.lugre.Fc",        "0.0.lugre.Fs",         "0.0.lugre.vs",
                       "0.0.lugre.sigma0",    "0.0.lugre.sigma1",     "0.0.lugre.sigma2",
                       "0.0.load.mu",         "0.0.backlash.b",       "0.1.viscous_power.c",
                       "0.1.viscous_power.p", "0.1.viscous_power.v0", "2.0.gms.Fc",
                       "2.0.gms.Fs",          "2.0.gms.vs",           "2.0.gms.C",
                       "2.0.gms.Fv",          "2.0.gms.k1",           "2.0.gms.alpha1",
                       "2.0.gms.k2",          "2.0.gms.alpha2"}));
}

TEST(RobotFriction, JointsAreIndependentAndLawsAdd) {
  const RobotFriction model({{{{"coulomb_viscous", 0, {}}, {"maxwell_slip", 1, {}}}},
                             {},
                             {{{"dahl", 0, {}}, {"viscous_power", 0, {}}}}});
  const std::vector<double> theta = {
      4,    2,    0.01,   // coulomb_viscous Fc Fv v0
      1000, 3,            // maxwell_slip K1 W1
      5,    2000, 1,      // dahl Fc sigma0 Fv
      3,    0.8,  0.001,  // viscous_power c p v0
  };
  std::vector<double> z = {1e-3, -2e-3}, tau(3);
  const std::vector<Input<double>> in = {{0, 0.5, 0, 300}, {0, 1, 0, 300}, {0, -2, 0, 300}};
  model.torque<double>(theta, in, z, tau);
  EXPECT_DOUBLE_EQ(tau[0], 4 * std::tanh(50) + 2 * 0.5 + 1000 * 1e-3);
  EXPECT_EQ(tau[1], 0);
  EXPECT_NEAR(tau[2], 2000 * -2e-3 - 1 * 2 - 3 * std::pow(2, 0.8), 1e-6);
  model.step<double>(theta, in, 4e-3, z);
  EXPECT_DOUBLE_EQ(z[0], 3e-3);
  const double zc = 5.0 / 2000;
  EXPECT_NEAR(z[1], -zc + (-2e-3 + zc) * std::exp(-2 * 4e-3 / zc), 1e-15);
}

// Claim: the step that shares its work with the torque is step, then torque, to the last bit.
TEST(RobotFriction, StepTorqueIsStepThenTorque) {
  const RobotFriction model({{{{"lugre", 0, {}}, {"viscous_power", 0, {}}}},
                             {{{"lugre", 0, {{"load", 0}, {"backlash", 0}}}}},
                             {{{"lugre_classic", 0, {{"load", 0}}}}},
                             {{{"dahl", 0, {}}}}});
  const std::vector<double> theta = default_theta(model);
  std::vector<double> z(static_cast<std::size_t>(model.state_size()), 1e-4);
  for (const double v : {-0.3, -1e-3, 0.0, 2e-2, 1.0}) {
    const std::vector<Input<double>> in(4, {0.1, v, 3, 300});
    std::vector<double> shared_z = z, tau(4), shared_tau(4);
    model.step<double>(theta, in, 1e-3, z);
    model.torque<double>(theta, in, z, tau);
    model.step_torque<double>(theta, in, 1e-3, shared_z, shared_tau);
    EXPECT_EQ(z, shared_z);
    EXPECT_EQ(tau, shared_tau);
  }
}

// Claim: in lanes a law may take six or two joints at a time, to the last bit what each joint does
// alone.
template <class S>
void expect_joints_as_alone() {
  constexpr std::size_t kJoints = 6 + 2 + 1;
  const JointSpec spec{{{"lugre", 0, {}}}};
  const RobotFriction robot(std::vector<JointSpec>(kJoints, spec)), alone({spec});
  const std::vector<double> typical = default_theta(alone);
  std::vector<S> theta, z, tau(kJoints);
  std::vector<Input<S>> in;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const auto x = static_cast<double>(j + 1);
    for (std::size_t i = 0; i < typical.size(); ++i)
      theta.push_back(S(typical[i] * (1 + 0.1 * x * static_cast<double>(i + 1))));
    z.push_back(S(1e-4 * x));
    S v(0);
    for (int k = 0; k < S::kLanes; ++k)
      v.set(k, static_cast<typename S::Scalar>(0.02 * (x - 3) * (k + 1)));
    in.push_back({S(0), v, S(0), S(300)});
  }
  const std::size_t n_theta = typical.size();
  for (int step = 0; step < 3; ++step) {
    std::vector<S> z_alone = z;
    std::vector<S> tau_alone(kJoints);
    const auto each = [&](auto&& act) {
      for (std::size_t j = 0; j < kJoints; ++j)
        act(std::span<const S>(theta).subspan(j * n_theta, n_theta),
            std::span<const Input<S>>(&in[j], 1), std::span<S>(&z_alone[j], 1),
            std::span<S>(&tau_alone[j], 1));
    };
    if (step == 0) {
      robot.torque<S>(theta, in, z, tau);
      each([&](auto t, auto i, auto s, auto f) { alone.torque<S>(t, i, s, f); });
    } else if (step == 1) {
      robot.step<S>(theta, in, 1e-3, z);
      each([&](auto t, auto i, auto s, auto) { alone.step<S>(t, i, 1e-3, s); });
      tau_alone = tau;
    } else {
      robot.step_torque<S>(theta, in, 1e-3, z, tau);
      each([&](auto t, auto i, auto s, auto f) { alone.step_torque<S>(t, i, 1e-3, s, f); });
    }
    for (std::size_t j = 0; j < kJoints; ++j)
      for (int k = 0; k < S::kLanes; ++k) {
        EXPECT_EQ(z[j][k], z_alone[j][k]) << j;
        EXPECT_EQ(tau[j][k], tau_alone[j][k]) << j;
      }
  }
}
TEST(RobotFriction, JointsAtATimeAreAsAlone) {
  expect_joints_as_alone<PackD>();
  expect_joints_as_alone<PackF>();
}

TEST(RobotFriction, ModifiersApplyInTheirOrder) {
  const Input<double> in{0.3, 1, 20, 303.15};
  const std::vector<double> law = {4, 0, 0.01};  // Fc Fv v0
  const double tau = 4 * std::tanh(100);
  const auto torque = [&](std::vector<ModifierSpec> modifiers, std::vector<double> tail) {
    const RobotFriction model({{{{"coulomb_viscous", 0, std::move(modifiers)}}}});
    std::vector<double> theta = law, out(1);
    theta.insert(theta.end(), tail.begin(), tail.end());
    model.torque<double>(theta, {&in, 1}, std::span<const double>{}, out);
    return out[0];
  };
  EXPECT_DOUBLE_EQ(torque({{"load"}}, {0.01}), 1.2 * tau);
  EXPECT_DOUBLE_EQ(torque({{"ripple", 2}}, {10, 0.1, 0.5, 3, 0.2, -1}),
                   (1 + 0.1 * std::sin(3.5) + 0.2 * std::sin(-0.1)) * tau);
  EXPECT_DOUBLE_EQ(torque({{"temperature"}}, {0.02, 293.15}), std::exp(-0.2) * tau);
  EXPECT_DOUBLE_EQ(torque({{"asymmetry"}}, {0.1}), 1.1 * tau);
  EXPECT_DOUBLE_EQ(torque({{"load"}, {"asymmetry"}}, {0.01, 0.1}), 1.1 * (1.2 * tau));
  EXPECT_DOUBLE_EQ(torque({{"asymmetry"}, {"load"}}, {0.1, 0.01}), 1.2 * (1.1 * tau));
}

TEST(RobotFriction, SaysWhichInputsItReads) {
  const RobotFriction plain({{{{"lugre", 0, {{"ripple"}}}}}});
  EXPECT_FALSE(plain.reads_load());
  EXPECT_FALSE(plain.reads_temperature());
  EXPECT_TRUE(RobotFriction({{{{"load_dependent", 0, {}}}}}).reads_load());
  EXPECT_TRUE(RobotFriction({{}, {{{"gms", 2, {{"load"}}}}}}).reads_load());
  EXPECT_TRUE(RobotFriction({{{{"gms", 2, {{"temperature"}}}}}}).reads_temperature());
}

TEST(RobotFriction, NamesWhatIsWrongInASpecification) {
  EXPECT_THAT(message_of([] {
                RobotFriction({{{{"lugree", 0, {}}}}});
              }),
              StartsWith("unknown friction law 'lugree'; known: none, coulomb_viscous, "));
  EXPECT_THAT(message_of([] {
                RobotFriction({{{{"dahl", 0, {{"loud"}}}}}});
              }),
              StartsWith("unknown friction modifier 'loud'; known: load, "));
  EXPECT_EQ(message_of([] {
              RobotFriction({{{{"gms", 0, {}}}}});
            }),
            "gms: elements = 0, allowed 1 .. 16");
  EXPECT_EQ(message_of([] {
              RobotFriction({{{{"dahl", 0, {{"ripple", 5}}}}}});
            }),
            "ripple: order = 5, allowed 1 .. 4");
  EXPECT_EQ(message_of([] {
              RobotFriction({{{{"dahl", 0, {{"load"}, {"load"}}}}}});
            }),
            "dahl: modifier 'load' is given more than once");
}

TEST(RobotFriction, NamesAParameterOutsideItsBounds) {
  const std::vector<std::string> joints = {"A1"};
  Friction friction{RobotFriction({{{{"lugre", 0, {{"load"}}}}}}), {}};
  friction.theta = default_theta(friction.model);
  EXPECT_EQ(message_of([&] { check_bounds(friction, joints, "x.toml"); }), "");
  friction.theta[3] = -5;
  EXPECT_EQ(message_of([&] { check_bounds(friction, joints, "x.toml:7"); }),
            "x.toml:7: joint A1: lugre.sigma0 = -5 N m/rad, allowed 0.01 .. 1000000000");
  friction.theta[3] = std::nan("");
  EXPECT_THAT(message_of([&] { check_bounds(friction, joints, "x.toml:7"); }), HasSubstr("nan"));
  friction.theta.pop_back();
  EXPECT_EQ(message_of([&] { check_bounds(friction, joints, "x.toml"); }),
            "x.toml: friction has 6 parameters, expected 7");
}

TEST(RobotFriction, EveryTypicalValueIsWithinItsBoundsAndScale) {
  const auto check = [](const std::string& owner, const std::vector<ParameterInfo>& parameters) {
    std::vector<std::string_view> seen;
    for (const ParameterInfo& p : parameters) {
      SCOPED_TRACE(owner + "." + std::string(p.symbol));
      EXPECT_LE(p.lower, p.typical);
      EXPECT_LE(p.typical, p.upper);
      EXPECT_TRUE(p.lower < p.upper || p.scale == Scale::kFixed);
      EXPECT_TRUE(p.scale != Scale::kLog || p.lower > 0);
      EXPECT_FALSE(p.unit.empty() || p.meaning.empty());
      EXPECT_EQ(std::ranges::count(seen, p.symbol), 0) << "twice";
      seen.push_back(p.symbol);
    }
  };
  for (const LawInfo& law : law_table()) {
    for (const int n : {1, 2, kMaxElements})
      check(std::string(law.name),
            parameters_of_law(law.name, law.has_elements ? std::min(n, law.most_elements) : n));
    const RobotFriction alone({{{{std::string(law.name), 1, {}}}}});
    EXPECT_EQ(alone.state_size() > 0, !law.state_unit.empty()) << law.name;
  }
  for (const LawInfo& modifier : modifier_table())
    for (int n = 1; n <= Ripple::kMostElements; ++n)
      check(std::string(modifier.name), parameters_of_modifier(modifier.name, n));
  EXPECT_EQ(parameters_of_law("gms", 12).back().symbol, "alpha12");
  // x: 6, hidden: 16 and 16, outputs: 2; two rates with 5 inputs, 8 units, 1 output
  const int weights = 7 * 16 + 17 * 16 + 17 * 2 + 2 * (6 * 8 + 9);
  EXPECT_EQ(parameters_of_law("lvm_bristles", 16).back().symbol.substr(1), std::to_string(weights));
  EXPECT_EQ(parameters_of_law("lvm_bristles", 16).size(), 12 + static_cast<std::size_t>(weights));
}

TEST(RobotFriction, AJointAloneIsWhatItWasInTheRobot) {
  const RobotFriction robot(std::vector<JointSpec>{{{{"coulomb_viscous", 0, {}}}},
                                                   {{{"gms", 2, {}}, {"viscous_power", 0, {}}}}});
  std::vector<double> theta = default_theta(robot);
  for (std::size_t i = 0; i < theta.size(); ++i) theta[i] *= 1 + 0.01 * static_cast<double>(i);
  const std::vector<Input<double>> in{{0, 0.1, 0, 293}, {0.2, -0.3, 4, 293}};
  const std::vector<double> z{1.5, -2};
  std::vector<double> both(2), alone(1);
  robot.torque<double>(theta, in, z, both);
  const Friction second = friction_of_joint({robot, theta}, 1);
  second.model.torque<double>(second.theta, std::span(in).subspan(1), z, alone);
  EXPECT_EQ(alone[0], both[1]);
}

TEST(RobotFriction, DoesNotAllocate) {
  const RobotFriction model(compositions());
  const std::vector<double> typical = default_theta(model);
  const auto n = static_cast<std::size_t>(model.joint_count());
  const auto n_z = static_cast<std::size_t>(model.state_size());
  const std::vector<PackD> theta(typical.begin(), typical.end());
  const std::vector<Input<PackD>> in(n, Input<PackD>{0.1, 0.2, 3, 300});
  std::vector<PackD> z(n_z, PackD(0)), z_bar = z, z_next_bar(n_z, PackD(1)), tau(n, PackD(0));
  std::vector<PackD> theta_bar(theta.size(), PackD(0));
  std::vector<Input<PackD>> in_bar(n, Input<PackD>{0, 0, 0, 0});

  const long before = fricid::test::allocation_count();
  for (int k = 0; k < 10; ++k) {
    model.torque<PackD>(theta, in, z, tau);
    model.step<PackD>(theta, in, 1e-3, z);
    model.torque_pullback<PackD>(theta, in, z, tau, theta_bar, in_bar, z_bar);
    model.step_pullback<PackD>(theta, in, 1e-3, z, z_next_bar, theta_bar, in_bar, z_bar);
  }
  EXPECT_EQ(fricid::test::allocation_count() - before, 0);
  ::operator delete(::operator new(8));
  EXPECT_EQ(fricid::test::allocation_count() - before, 1) << "the counter counts";
}

}  // namespace
}  // namespace fricid::friction::test
