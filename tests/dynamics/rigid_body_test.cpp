// Laws of rigid-body dynamics at random states of every robot.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "robots.hpp"
#include "source_dir.hpp"

namespace fricid::dynamics::test {
namespace {

/// Calls check(model, robot, state) at random states of every robot; stops at a robot's first
/// failure.
template <class Check>
void for_each_state(int count, Check check) {
  for (const RobotModel& model : all_robots()) {
    Robot robot(model);
    for (int k = 0; k < count && !::testing::Test::HasFailure(); ++k) {
      SCOPED_TRACE(testing::Message() << model.name << ", state " << k);
      check(model, robot, random_state(model, k));
    }
  }
}

TEST(RigidBody, InverseDynamicsUndoesForwardDynamics) {
  for_each_state(kStates, [](const RobotModel&, Robot& robot, const State& s) {
    const VectorXd a = robot.forward(s.q, s.v, s.tau);
    EXPECT_TRUE(close(robot.rnea(s.q, s.v, a), s.tau, 1e-11));
  });
}

TEST(RigidBody, RegressorTimesParametersIsInverseDynamics) {
  for_each_state(kStates, [](const RobotModel& model, Robot& robot, const State& s) {
    EXPECT_TRUE(close(robot.regressor(s.q, s.v, s.a) * model.pi, robot.rnea(s.q, s.v, s.a), 1e-12));
  });
}

TEST(RigidBody, MassMatrixIsSymmetricPositiveAndThatOfInverseDynamics) {
  for_each_state(kStates, [](const RobotModel& model, Robot& robot, const State& s) {
    const MatrixXd M = robot.mass(s.q);
    EXPECT_LE((M - M.transpose()).cwiseAbs().maxCoeff(), tolerance(1e-13));
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(M).eigenvalues()(0), 0);
    const VectorXd h = robot.rnea(s.q, s.v, VectorXd::Zero(model.n()));
    EXPECT_TRUE(close(M * s.a + h, robot.rnea(s.q, s.v, s.a), 1e-12));
  });
}

TEST(RigidBody, LastFactorSolvesWithTheMassMatrix) {
  for_each_state(kStates, [](const RobotModel&, Robot& robot, const State& s) {
    robot.forward(s.q, s.v, s.tau);
    EXPECT_TRUE(close(robot.mass(s.q) * robot.solve(s.a), s.a, 1e-11));
  });
}

TEST(RigidBody, KineticEnergyIsHalfOfVMassV) {
  for_each_state(kStates, [](const RobotModel&, Robot& robot, const State& s) {
    EXPECT_TRUE(close(robot.kinetic(s.q, s.v), 0.5 * s.v.dot(robot.mass(s.q) * s.v), 1e-12));
  });
}

MatrixXd mass_rate(Robot& robot, const VectorXd& q, const VectorXd& v) {
  constexpr double kStep = 1e-5;
  return (robot.mass(q + kStep * v) - robot.mass(q - kStep * v)) / (2 * kStep);
}

// d/dt kinetic energy = v' M a + v' M' v / 2 = v' (tau - g)
TEST(RigidBody, PowerBalances) {
  for_each_state(kStates, [](const RobotModel&, Robot& robot, const State& s) {
    const VectorXd a = robot.forward(s.q, s.v, s.tau);
    const double growth = s.v.dot(robot.mass(s.q) * a + 0.5 * mass_rate(robot, s.q, s.v) * s.v);
    const double power = s.v.dot(s.tau - robot.gravity(s.q));
    EXPECT_TRUE(close(growth, power, 1e-7, s.v.norm() * s.tau.norm() + 1e-3));
  });
}

// w' (dM/dt - 2 C(v)) w = 0 for any w, with C(v) w from the quadratic form of the velocity torques
TEST(RigidBody, MassRateLessTwiceCoriolisIsSkew) {
  for_each_state(kStates, [](const RobotModel& model, Robot& robot, const State& s) {
    const VectorXd w = 0.4 * s.a, zero = VectorXd::Zero(model.n());
    const VectorXd C_w = (robot.rnea(s.q, s.v + w, zero) - robot.rnea(s.q, s.v - w, zero)) / 4;
    const double rate = w.dot(mass_rate(robot, s.q, s.v) * w);
    EXPECT_TRUE(close(rate, 2 * w.dot(C_w), 1e-7, w.norm() * C_w.norm() + 1e-3));
  });
}

TEST(RigidBody, GravityIsTheGradientOfAPotential) {
  for_each_state(100, [](const RobotModel& model, Robot& robot, const State& s) {
    constexpr double kStep = 1e-5;
    const int n = model.n();
    MatrixXd slope(n, n);
    VectorXd gradient(n);
    for (int i = 0; i < n; ++i) {
      const VectorXd step = kStep * VectorXd::Unit(n, i);
      slope.col(i) = (robot.gravity(s.q + step) - robot.gravity(s.q - step)) / (2 * kStep);
      gradient(i) = (robot.potential(s.q + step) - robot.potential(s.q - step)) / (2 * kStep);
    }
    const double scale = std::max(1.0, slope.cwiseAbs().maxCoeff());
    EXPECT_LE((slope - slope.transpose()).cwiseAbs().maxCoeff(), tolerance(1e-7) * scale);
    if (!model.linear_torques.empty()) return;
    EXPECT_TRUE(close(gradient, robot.gravity(s.q), 1e-7));
  });
}

/// Classic Runge-Kutta of free motion for `duration`.
State swing(Robot& robot, State s, double duration, int steps) {
  const double dt = duration / steps;
  const VectorXd zero = VectorXd::Zero(s.q.size());
  for (int k = 0; k < steps; ++k) {
    const VectorXd a1 = robot.forward(s.q, s.v, zero);
    const VectorXd v2 = s.v + dt / 2 * a1, q2 = s.q + dt / 2 * s.v;
    const VectorXd a2 = robot.forward(q2, v2, zero);
    const VectorXd v3 = s.v + dt / 2 * a2, q3 = s.q + dt / 2 * v2;
    const VectorXd a3 = robot.forward(q3, v3, zero);
    const VectorXd v4 = s.v + dt * a3, q4 = s.q + dt * v3;
    const VectorXd a4 = robot.forward(q4, v4, zero);
    s.q += dt / 6 * (s.v + 2 * v2 + 2 * v3 + v4);
    s.v += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return s;
}

TEST(RigidBody, FreeMotionKeepsItsEnergyToTheOrderOfRungeKutta) {
  for (const RobotModel& model : all_robots()) {
    if (!model.linear_torques.empty()) continue;
    SCOPED_TRACE(model.name);
    Robot robot(model);
    State start = random_state(model, 3);
    start.v *= 0.3;
    const auto energy = [&robot](const State& s) {
      return robot.kinetic(s.q, s.v) + robot.potential(s.q);
    };
    // steps so small that the leading error term rules, yet not so small that rounding does
    int steps = 20;
    while ((swing(robot, start, 0.4, steps).q - swing(robot, start, 0.4, 2 * steps).q).norm() >
           1e-8)
      steps *= 2;
    const State coarse = swing(robot, start, 0.4, steps);
    const State middle = swing(robot, start, 0.4, 2 * steps);
    const State fine = swing(robot, start, 0.4, 4 * steps);
    EXPECT_NEAR((coarse.q - middle.q).norm() / (middle.q - fine.q).norm(), 16, 2);
    EXPECT_TRUE(close(energy(fine), energy(start), 1e-8));
  }
}

TEST(RigidBody, HoldsOnAnyTree) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const RobotModel model = random_tree(1 + static_cast<int>(seed % 9), seed, seed % 3 == 0);
    SCOPED_TRACE(model.name);
    Robot robot(model);
    for (int k = 0; k < 3; ++k) {
      const State s = random_state(model, k);
      const VectorXd tau = robot.rnea(s.q, s.v, s.a);
      EXPECT_TRUE(close(robot.regressor(s.q, s.v, s.a) * model.pi, tau, 1e-12));
      EXPECT_TRUE(close(robot.forward(s.q, s.v, tau), s.a, 1e-10));
    }
  }
}

// Links may be numbered in any order with parents first.
TEST(RigidBody, NumberingDoesNotMatter) {
  const RobotModel deep = load("test/branched.urdf");
  const int order[] = {0, 3, 1, 4, 2};  // by depth: new joint k is old joint order[k]
  RobotModel broad = deep;
  for (int k = 0; k < 5; ++k) {
    broad.joints[static_cast<size_t>(k)] = deep.joints[static_cast<size_t>(order[k])];
    int& parent = broad.joints[static_cast<size_t>(k)].parent;
    if (parent >= 0) parent = static_cast<int>(std::find(order, order + 5, parent) - order);
    broad.pi.segment<10>(10 * k) = deep.pi.segment<10>(10 * order[k]);
    broad.pi(50 + k) = deep.pi(50 + order[k]);
  }
  Robot robot(deep), renumbered(broad);
  for (int k = 0; k < 100; ++k) {
    const State s = random_state(deep, k);
    const VectorXd a = robot.forward(s.q, s.v, s.tau);
    const VectorXd b = renumbered.forward(s.q(order), s.v(order), s.tau(order));
    EXPECT_TRUE(close(b, a(order), 1e-12));
    EXPECT_TRUE(close(renumbered.rnea(s.q(order), s.v(order), s.a(order)),
                      robot.rnea(s.q, s.v, s.a)(order), 1e-12));
  }
}

TEST(RigidBody, MountTurnsGravity) {
  const std::filesystem::path path = source_dir() / "models/kr6_r700/kr6_r700.urdf";
  const RobotModel floor = load_urdf(path);
  const RobotModel ceiling = load_urdf(path, Vector3d(1, -1, -1).asDiagonal());
  const Eigen::Matrix3d wall_mount =
      Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()).toRotationMatrix();
  const RobotModel wall = load_urdf(path, wall_mount);
  EXPECT_LT((wall.gravity - Vector3d(9.81, 0, 0)).norm(), 1e-14);
  Robot standing(floor), hanging(ceiling);
  for (int k = 0; k < 100; ++k) {
    const State s = random_state(floor, k);
    EXPECT_TRUE(close(hanging.gravity(s.q), -standing.gravity(s.q), 1e-13));
    EXPECT_EQ(hanging.mass(s.q), standing.mass(s.q));
  }
}

// q = A m: the torques of the links at the motors, and each rotor at its own.
TEST(RigidBody, CoupledMotorsCarryTheLinksThroughTheirTransmission) {
  const RobotModel coupled = all_robots().back();
  ASSERT_TRUE(coupled.coupled());
  MatrixXd A = MatrixXd::Identity(6, 6);
  A(5, 4) = -1;
  A(4, 3) = 0.2;
  A(1, 0) = 0.5;
  A(2, 5) = -0.3;
  EXPECT_EQ(coupled.joints_of_motors(), A);
  EXPECT_LE((coupled.motors_of_joints() * A - MatrixXd::Identity(6, 6)).norm(), tolerance(1e-14));
  RobotModel links = coupled;
  links.couplings.clear();
  const VectorXd Ia = links.pi.segment<6>(links.armature_begin());
  links.pi.segment<6>(links.armature_begin()).setZero();
  Robot robot(coupled), at_joints(links);
  for (int k = 0; k < 100; ++k) {
    const State s = random_state(coupled, k);
    const VectorXd expected =
        A.transpose() * at_joints.rnea(A * s.q, A * s.v, A * s.a) + Ia.cwiseProduct(s.a);
    EXPECT_TRUE(close(robot.rnea(s.q, s.v, s.a), expected, 1e-13));
  }
}

TEST(RigidBody, ArmatureAddsToTheDiagonalAlone) {
  const RobotModel model = load("kr6_r700/kr6_r700.urdf");
  VectorXd without = model.pi;
  without.tail(6).setZero();
  Robot robot(model), light(model, without);
  for (int k = 0; k < 100; ++k) {
    const State s = random_state(model, k);
    const MatrixXd added = robot.mass(s.q) - light.mass(s.q);
    EXPECT_LE((added - MatrixXd(model.pi.tail(6).asDiagonal())).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_TRUE(close(robot.rnea(s.q, s.v, s.a),
                      light.rnea(s.q, s.v, s.a) + model.pi.tail(6).cwiseProduct(s.a), 1e-13));
  }
}

TEST(RigidBody, LinearTorqueAddsItsShape) {
  using Shape = LinearTorque::Shape;
  const RobotModel model = load("test/planar_2r.urdf");
  const struct {
    Shape shape;
    double k, at_0_3;
  } cases[] = {{Shape::kConstant, 1, 1},
               {Shape::kSin, 2, std::sin(0.6)},
               {Shape::kCos, 3, std::cos(0.9)},
               {Shape::kLinear, 1, 0.3}};
  for (const auto& c : cases) {
    RobotModel sprung = model;
    add_linear_torque(sprung, {.name = "extra", .joint = 1, .shape = c.shape, .k = c.k}, 7);
    const VectorXd q{{-0.5, 0.3}}, v{{1, 2}}, a{{-3, 1}};
    Robot plain(model), robot(sprung);
    const VectorXd extra = robot.rnea(q, v, a) - plain.rnea(q, v, a);
    EXPECT_NEAR(extra(0), 0, 1e-13);
    EXPECT_NEAR(extra(1), 7 * c.at_0_3, 1e-13);
    EXPECT_EQ(sprung.parameter_names().back(), "extra");
  }
}

}  // namespace
}  // namespace fricid::dynamics::test
