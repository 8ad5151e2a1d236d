#include "fricid/sim/simulate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "arms.hpp"
#include "fricid/base/error.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/sim/sensors.hpp"

namespace fricid::sim::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

bool same_bytes(const RowMatrix& x, const RowMatrix& y) {
  return x.rows() == y.rows() && x.cols() == y.cols() &&
         (x.size() == 0 || std::memcmp(x.data(), y.data(),
                                       static_cast<std::size_t>(x.size()) * sizeof(double)) == 0);
}

// Independent check: the ENGINE's inverse dynamics on what MuJoCo did, at every logged sample.
TEST(Simulate, TruthObeysTheEquationOfMotion) {
  for (const char* name : {"kr6_full", "kr6_thermal", "kr6_load"}) {
    SCOPED_TRACE(name);
    const scene::Problem problem = resolve(small_scene(name));
    const Simulation simulation = simulate(problem, 2);
    const dynamics::RobotModel& robot = problem.robot;
    dynamics::Workspace<double> ws(robot);
    std::vector<double> tau(static_cast<std::size_t>(robot.n()));
    const Trace& trace = simulation.validation_truth[0].trace;
    const Eigen::RowVectorXd range =
        trace.tau.colwise().maxCoeff() - trace.tau.colwise().minCoeff();
    for (int k = 0; k < trace.length(); ++k) {
      const State state = trace.state(k);
      dynamics::rnea<double>(robot, ws,
                             {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())}, state.q,
                             state.v, {trace.a.row(k).data(), tau.size()}, tau);
      for (Eigen::Index j = 0; j < robot.n(); ++j)
        ASSERT_NEAR(tau[static_cast<std::size_t>(j)] + trace.tau_f(k, j), trace.tau(k, j),
                    1e-9 * range[j])
            << "sample " << k << " joint " << j;
    }
  }
}

// Claim: the truth at t_k and t_{k+1} are joined by one hold of tau_k, so with perfect sensors the
// open loop of the truth is the truth, to the last bit.
TEST(Simulate, OracleWithPerfectSensorsIsTheTruth) {
  scene::Scene small = small_scene("kr6_thermal");
  SensorOptions& sensors = small.sensors;
  sensors.encoder_noise_rad.clear();
  sensors.encoder_step_rad.clear();
  sensors.torque_noise = sensors.torque_step = 0;
  const scene::Problem problem = resolve(std::move(small));
  const Simulation simulation = simulate(problem, 2);
  const Truth& truth = simulation.validation_truth[0];
  const MujocoArm arm = make_arm(problem);
  constexpr int kStart = 100, kLength = 1000;
  const Trace trace =
      oracle_rollout(problem, arm, truth, simulation.validation[0], kStart, kLength);
  EXPECT_TRUE(same_bytes(trace.q, truth.trace.q.middleRows(kStart, kLength)));
  EXPECT_TRUE(same_bytes(trace.v, truth.trace.v.middleRows(kStart, kLength)));
  EXPECT_TRUE(same_bytes(trace.z, truth.trace.z.middleRows(kStart, kLength)));
}

TEST(Simulate, EqualBytesForAnyNumberOfJobs) {
  scene::Scene small = small_scene("kr6_full");
  small.excitation.repeats = 2;
  const scene::Problem problem = resolve(std::move(small));
  const Simulation one = simulate(problem, 1);
  ASSERT_EQ(one.train.size(), 2u);
  ASSERT_EQ(one.validation.size(), 1u);
  for (const int jobs : {2, 3}) {
    const Simulation many = simulate(problem, jobs);
    for (std::size_t i = 0; i < one.train.size(); ++i) {
      EXPECT_TRUE(same_bytes(one.train[i].q, many.train[i].q));
      EXPECT_TRUE(same_bytes(one.train[i].tau, many.train[i].tau));
      EXPECT_TRUE(same_bytes(one.train_truth[i].trace.z, many.train_truth[i].trace.z));
      EXPECT_TRUE(same_bytes(one.train_truth[i].trace.a, many.train_truth[i].trace.a));
    }
    EXPECT_TRUE(same_bytes(one.validation[0].q, many.validation[0].q));
  }
}

TEST(Simulate, RepeatsAPeriodWithOtherNoiseAndWarmer) {
  scene::Scene small = small_scene("kr6_thermal");
  small.excitation.repeats = 2;
  const scene::Problem problem = resolve(std::move(small));
  const Simulation simulation = simulate(problem, 2);
  const RowMatrix& first = simulation.train[0].q;
  const RowMatrix& second = simulation.train[1].q;
  EXPECT_FALSE(same_bytes(first, second));
  EXPECT_LT((first - second).cwiseAbs().maxCoeff(), 0.02) << "the same motion, but for the grease";
  EXPECT_THAT(simulation.train[0].name, "train_0");
  EXPECT_THAT(simulation.train[1].name, "train_1");
  EXPECT_THAT(simulation.validation[0].name, "validation_0");
  // the second sequence starts when the first has ended
  const double period = simulation.excitation.train[0].period();
  EXPECT_DOUBLE_EQ(simulation.train[0].temperature(0, 0),
                   problem.scene.sensors.temperature_start_K);
  EXPECT_DOUBLE_EQ(simulation.train[1].temperature(0, 0),
                   temperature_at(problem.scene.sensors, period));
}

// Claim: friction is already deflected when the log begins, as in a real log.
TEST(Simulate, LogStartsInANaturalState) {
  const Simulation simulation = simulate(resolve(small_scene("kr6_full")), 2);
  const Trace& trace = simulation.train_truth[0].trace;
  const RowMatrix tau_f = trace.tau_f.topRows(1);
  for (int j = 0; j < 6; ++j) EXPECT_GT(std::abs(tau_f(0, j)), 1e-3) << "joint " << j;
  EXPECT_LT(trace.v.topRows(1).cwiseAbs().maxCoeff(), 0.2) << "near rest";
}

TEST(Simulate, RefusesASceneWithoutFriction) {
  scene::Scene small = small_scene("kr6_gms");
  const dynamics::RobotModel robot = resolve(small).robot;
  small.friction.reset();
  const scene::Problem problem{.scene = small, .robot = robot};
  EXPECT_THROW(simulate(problem, 1), UserError);
}

TEST(Truth, FileGivesBackEveryBit) {
  const Simulation simulation = simulate(resolve(small_scene("kr6_full")), 2);
  const Truth& truth = simulation.validation_truth[0];
  const TempFile file("truth.h5", "");
  save_truth(truth, file.path());
  const Truth back = load_truth(file.path());
  for (RowMatrix Trace::*table : {&Trace::q, &Trace::v, &Trace::a, &Trace::tau, &Trace::tau_f,
                                  &Trace::z, &Trace::temperature})
    EXPECT_TRUE(same_bytes(back.trace.*table, truth.trace.*table));
  EXPECT_EQ(back.trace.t, truth.trace.t);
  EXPECT_EQ(back.joint_names, truth.joint_names);
  EXPECT_EQ(back.rate_hz, truth.rate_hz);
  EXPECT_EQ(back.friction.theta, truth.friction.theta);
  ASSERT_EQ(back.friction.model.parameter_count(), truth.friction.model.parameter_count());
  for (std::size_t i = 0; i < back.friction.theta.size(); ++i) {
    EXPECT_EQ(back.friction.model.parameters()[i].symbol,
              truth.friction.model.parameters()[i].symbol);
    EXPECT_EQ(back.friction.model.parameters()[i].owner,
              truth.friction.model.parameters()[i].owner);
  }
}

TEST(Truth, NamesAFileThatIsNoTruth) {
  const TempFile file("truth.h5", "not hdf5");
  EXPECT_THROW(load_truth(file.path()), UserError);
  EXPECT_THROW(load_truth(file.path().parent_path()), UserError);
  // a data set is not a truth
  const Simulation simulation = simulate(resolve(small_scene("kr6_gms")), 2);
  data::save_dataset(simulation.train[0], file.path());
  EXPECT_THROW(load_truth(file.path()), UserError);
}

// The text is an attribute of files from others.
TEST(Truth, FrictionIsTextAndBack) {
  const friction::Friction before{
      friction::RobotFriction({{{{"coulomb_viscous", 0, {{"ripple", 2}}}}}, {}}),
      std::vector<double>(9, 0.5)};
  const std::string text = friction_text(before);
  EXPECT_THAT(text, StartsWith(R"({"joints":[{"laws":[{"elements":0,"law":"coulomb_viscous",)"
                               R"("modifiers":[{"name":"ripple","order":2}],"parameters":[)"
                               R"({"owner":"coulomb_viscous","symbol":"Fc","unit":"N m","value":)"
                               R"(0.5},)"));
  EXPECT_EQ(friction_text(friction_of(text, "a.h5")), text);

  const auto said = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    changed.replace(at, from.size(), to);
    try {
      friction_of(changed, "a.h5");
    } catch (const UserError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_EQ(said("\"elements\":0", "\"elements\":1e300"),
            "a.h5: joints[0].laws[0].elements: found 1e+300; allowed: a whole number");
  EXPECT_EQ(said("\"order\":2", "\"order\":2147483647"),
            "a.h5: ripple: order = 2147483647, allowed 1 .. 4");
  EXPECT_THAT(said("\"law\":\"coulomb_viscous\"", "\"law\":\"none of ours\""),
              StartsWith("a.h5: unknown friction law 'none of ours'"));
  EXPECT_THAT(said("{", std::string(100'000, '[')), StartsWith("a.h5: 33 levels of lists"));
  EXPECT_THAT(said("}", "]"), StartsWith("a.h5:1: not JSON, or torn"));
  EXPECT_THAT(said("[{", "[3,{"),
              StartsWith("a.h5: joints: found a list; allowed: a list of objects"));
}

std::string refusal_of(const scene::Problem& problem) {
  try {
    simulate(problem, 2);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

/// The KR 6 without rotors or with, in short.
std::string refusal_of(double step_s, double rate_hz, double bandwidth_hz, ControlLaw kind,
                       bool rotors) {
  scene::Scene scene = small_scene("kr6_full");
  scene.robot.mjcf.clear();
  scene.excitation.validation = 0;
  scene.plant.step_s = step_s;
  scene.sensors.rate_hz = rate_hz;
  scene.controller.bandwidth_hz = bandwidth_hz;
  scene.controller.kind = kind;
  scene::Problem problem = scene::resolve(std::move(scene));
  if (!rotors)
    problem.robot.pi.segment(problem.robot.armature_begin(), problem.robot.n()).setZero();
  return refusal_of(problem);
}

// Without armature links are turned around by their friction within a step of 4 ms.
TEST(Simulate, ATruthThatChattersIsRefusedWithItsRemedy) {
  const auto refusal = [](double step_s) {
    return refusal_of(step_s, 250, 8, ControlLaw::kComputedTorque, false);
  };
  const std::string message = refusal(0.004);
  EXPECT_THAT(message, HasSubstr("chatters: it reverses"));
  EXPECT_THAT(message, HasSubstr("joint_a"));
  EXPECT_THAT(message, HasSubstr("plant.step_s = 0.004 s"));
  EXPECT_EQ(refusal(0.002), "");
}

// One joint's gain moves the others too, the more the less of their inertia is rotors: a controller
// overshoots at more samples than those of one joint alone. Below the bandwidth that is named it
// does not.
TEST(Simulate, AControllerTooFastForItsSamplesIsNamed) {
  struct Case {
    double rate_hz;
    bool rotors;
  };
  for (const auto& [rate_hz, rotors] : {Case{50, true}, {125, true}, {250, false}}) {
    const std::string message = refusal_of(0.0005, rate_hz, 8, ControlLaw::kPdGravity, rotors);
    EXPECT_THAT(message, HasSubstr(fmt::format("of 8 Hz that acts {} times a second", rate_hz)));
    EXPECT_EQ(message.find("guess_armature") == std::string::npos, rotors) << message;
    const std::string before = "lower controller.bandwidth_hz below ";
    const std::size_t at = message.find(before);
    ASSERT_NE(at, std::string::npos) << message;
    const double lower = 0.9 * std::stod(message.substr(at + before.size()));
    EXPECT_EQ(refusal_of(0.0005, rate_hz, lower, ControlLaw::kPdGravity, rotors), "");
  }
}

}  // namespace
}  // namespace fricid::sim::test
