// A table of injected faults: what is done to a clean log is found, by name and place, and nothing
// else is; clean logs of many scenes raise no alarm.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <numbers>

#include "doctor/clean_logs.hpp"
#include "doctor/injected.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/dynamics/algorithms.hpp"

namespace fricid::doctor {
namespace {

using data::Dataset;
using data::RowMatrix;

struct Damage {
  std::string what;
  std::string name;    ///< of the finding that it must raise
  std::string signal;  ///< where
  int joint, other;
  std::function<void(Dataset&)> apply;
};

void keep_rows(Dataset& d, const std::function<int(int)>& copies) {
  std::vector<int> rows;
  for (int k = 0; k < d.length(); ++k)
    for (int i = 0; i < copies(k); ++i) rows.push_back(k);
  const auto length = static_cast<Eigen::Index>(rows.size());
  Eigen::VectorXd t(length);
  for (Eigen::Index i = 0; i < length; ++i) t[i] = d.t[rows[static_cast<std::size_t>(i)]];
  d.t = t;
  for (RowMatrix* table : {&d.q, &d.tau, &d.v, &d.temperature}) {
    if (table->size() == 0) continue;
    RowMatrix chosen(length, table->cols());
    for (Eigen::Index i = 0; i < length; ++i)
      chosen.row(i) = table->row(rows[static_cast<std::size_t>(i)]);
    *table = chosen;
  }
}

void round_to(RowMatrix& x, int j, double step) {
  x.col(j) = (x.col(j).array() / step).round() * step;
}

void exchange_rows(Dataset& d, int i, int k) {
  std::swap(d.t[i], d.t[k]);
  for (RowMatrix* table : {&d.q, &d.tau, &d.v, &d.temperature})
    if (table->size() > 0) table->row(i).swap(table->row(k));
}

void swap_columns(RowMatrix& x, int i, int j) { x.col(i).swap(x.col(j)); }

std::vector<Damage> damages() {
  constexpr double kDegree = std::numbers::pi / 180;
  return {
      {"40 samples lost", "gap", "t", -1, -1,
       [](Dataset& d) { keep_rows(d, [](int k) { return k >= 700 && k < 740 ? 0 : 1; }); }},
      {"3 single samples lost", "gap", "t", -1, -1,
       [](Dataset& d) {
         keep_rows(d, [](int k) { return k == 300 || k == 800 || k == 1500 ? 0 : 1; });
       }},
      {"5 rows twice", "duplicate", "t", -1, -1,
       [](Dataset& d) { keep_rows(d, [](int k) { return k % 400 == 100 ? 2 : 1; }); }},
      {"2 % of the rows behind the next", "out_of_order", "t", -1, -1,
       [](Dataset& d) {
         Rng rng(3, 0);
         for (int k = 0; k + 1 < d.length(); ++k)
           if (rng.uniform() < 0.02) exchange_rows(d, k, k + 1);
       }},
      {"rows shuffled within ten", "out_of_order", "t", -1, -1,
       [](Dataset& d) {
         Rng rng(4, 0);
         for (int k = 0; k + 10 < d.length(); ++k)
           if (rng.uniform() < 0.3) exchange_rows(d, k, k + static_cast<int>(10 * rng.uniform()));
       }},
      {"blocks of 40 rows exchanged", "out_of_order", "t", -1, -1,
       [](Dataset& d) {
         for (int k = 0; k < 40; ++k) exchange_rows(d, 700 + k, 740 + k);
       }},
      {"times off by 5 % of the period", "jitter", "t", -1, -1,
       [](Dataset& d) {
         Rng rng(1, 0);
         for (int k = 0; k < d.length(); ++k) d.t[k] += 0.05 * d.dt() * rng.normal();
       }},
      {"times late by up to the period", "jitter", "t", -1, -1,
       [](Dataset& d) {
         Rng rng(2, 0);
         for (int k = 0; k < d.length(); ++k)
           d.t[k] += d.dt() * std::min(1.0, std::abs(0.25 * rng.normal()));
       }},
      {"counter of 32 bits in us", "wrap", "t", -1, -1,
       [](Dataset& d) { d.t.tail(d.length() - 1200).array() -= 0x1p32 / 1e6; }},
      {"counter of 31 bits in ns", "wrap", "t", -1, -1,
       [](Dataset& d) {
         constexpr double kRange = 0x1p31 / 1e9;
         for (double& t : d.t) t -= kRange * std::floor((t + 1) / kRange);
       }},
      {"clock that slows by 1 %", "clock_drift", "t", -1, -1,
       [](Dataset& d) {
         const double T = d.t[d.length() - 1];
         d.t = d.t.array() * (1 + 0.005 * d.t.array() / T);
       }},
      {"rows of a source of a quarter of the rate", "held", "q tau", -1, -1,
       [](Dataset& d) {
         for (int k = 0; k < d.length(); ++k)
           for (RowMatrix* x : {&d.q, &d.v, &d.tau}) x->row(k) = x->row(k - k % 4).eval();
       }},
      {"torque of a source of a fifth of the rate", "held", "tau", -1, -1,
       [](Dataset& d) {
         for (int k = 0; k < d.length(); ++k) d.tau.row(k) = d.tau.row(k - k % 5).eval();
       }},
      {"stale packets", "repeated", "q tau", -1, -1,
       [](Dataset& d) {
         for (int k = 1; k < d.length(); ++k)
           if (k % 25 == 3)
             for (RowMatrix* x : {&d.q, &d.tau, &d.v, &d.temperature})
               x->row(k) = x->row(k - 1).eval();
       }},
      {"torque 3 samples late", "delay", "tau", -1, -1, [](Dataset& d) { delay_torque(d, 3); }},
      {"torque 2.5 samples late", "delay", "tau", -1, -1, [](Dataset& d) { delay_torque(d, 2.5); }},
      {"position of joint 2 of the other sign", "sign", "q v", 1, -1,
       [](Dataset& d) {
         d.q.col(1) *= -1;
         d.v.col(1) *= -1;
       }},
      {"torque of joint 3 of the other sign", "sign", "tau", 2, -1,
       [](Dataset& d) { d.tau.col(2) *= -1; }},
      {"joint 5 of the other sign", "sign", "q v tau", 4, -1,
       [](Dataset& d) {
         for (RowMatrix* x : {&d.q, &d.v, &d.tau}) x->col(4) *= -1;
       }},
      {"degrees", "angle_unit", "q v", 0, -1,
       [=](Dataset& d) {
         d.q /= kDegree;
         d.v /= kDegree;
       }},
      {"joint 3 in degrees", "angle_unit", "q", 2, -1, [=](Dataset& d) { d.q.col(2) /= kDegree; }},
      {"joints 4 and 5 swapped", "swapped", "q v tau", 3, 4,
       [](Dataset& d) {
         for (RowMatrix* x : {&d.q, &d.v, &d.tau}) swap_columns(*x, 3, 4);
       }},
      {"torques 2 and 3 swapped", "swapped", "tau", 1, 2,
       [](Dataset& d) { swap_columns(d.tau, 1, 2); }},
      {"position 4 in steps of 0.1 deg", "quantised", "q", 3, -1,
       [=](Dataset& d) { round_to(d.q, 3, 0.1 * kDegree); }},
      {"torque 1 in 20 steps", "quantised", "tau", 0, -1,
       [](Dataset& d) {
         round_to(d.tau, 0, (d.tau.col(0).maxCoeff() - d.tau.col(0).minCoeff()) / 20);
       }},
      {"torque 1 clipped at 70 %", "saturated", "tau", 0, -1,
       [](Dataset& d) {
         const double limit = 0.7 * d.tau.col(0).cwiseAbs().maxCoeff();
         d.tau.col(0) = d.tau.col(0).cwiseMax(-limit).cwiseMin(limit);
       }},
      {"position 6 stuck for 2 s", "stuck", "q", 5, -1,
       [](Dataset& d) { d.q.col(5).segment(900, 500).setConstant(d.q(900, 5)); }},
      {"torque 2 stuck for 1 s", "stuck", "tau", 1, -1,
       [](Dataset& d) { d.tau.col(1).segment(900, 250).setConstant(d.tau(900, 1)); }},
      {"position 2 in the column of 3", "same", "q", 1, 2,
       [](Dataset& d) { d.q.col(2) = d.q.col(1); }},
      {"position 5 in the column of 1, of the other sign", "same", "q", 0, 4,
       [](Dataset& d) { d.q.col(0) = -d.q.col(4); }},
      {"torque 2 in the column of 3", "same", "tau", 1, 2,
       [](Dataset& d) { d.tau.col(2) = d.tau.col(1); }},
      {"torque 4 in the column of 6, of another gear", "same", "tau", 3, 5,
       [](Dataset& d) { d.tau.col(5) = 0.7 * d.tau.col(3); }},
      {"spike in position 1", "spike", "q", 0, -1, [](Dataset& d) { d.q(1000, 0) += 0.05; }},
      {"spikes in torque 5", "spike", "tau", 4, -1,
       [](Dataset& d) {
         for (const int k : {500, 1000, 1400})
           d.tau(k, 4) += d.tau.col(4).maxCoeff() - d.tau.col(4).minCoeff();
       }},
      {"position 6 loses a turn", "jump", "q", 5, -1,
       [](Dataset& d) { d.q.col(5).tail(1000).array() += 2 * std::numbers::pi; }},
      {"position 3 slips by 0.03 rad", "jump", "q", 2, -1,
       [](Dataset& d) { d.q.col(2).tail(1000).array() += 0.03; }},
      {"position 2 missing for 0.2 s", "missing", "q", 1, -1,
       [](Dataset& d) { d.q.col(1).segment(600, 50).setConstant(std::nan("")); }},
      {"velocity 3 of the motor", "velocity", "v", 2, -1, [](Dataset& d) { d.v.col(2) *= 100; }},
      {"velocity 2 of the other sign", "velocity", "v", 1, -1,
       [](Dataset& d) { d.v.col(1) *= -1; }},
      {"torque 2 of the motor", "torque_unit", "tau", 1, -1,
       [](Dataset& d) { d.tau.col(1) /= 120; }},
      {"temperature 4 in degrees Celsius", "temperature_unit", "temperature", 3, -1,
       [](Dataset& d) { d.temperature.col(3).array() -= 273.15; }},
  };
}

TEST(Doctor, NoFalseAlarmOnCleanLogs) {
  ASSERT_EQ(clean_logs().size(), 20u);
  for (std::size_t i = 0; i < clean_logs().size(); ++i) {
    const auto& [log, robot] = clean_logs()[i];
    EXPECT_EQ(text_of(diagnose(log, &robot), log), "") << "log " << i << ", " << log.source;
    EXPECT_EQ(text_of(diagnose(log), log), "") << "without a robot, log " << i;
  }
}

TEST(Doctor, FindsInjectedDamageByNameAndPlaceAndNothingElse) {
  for (const Damage& damage : damages())
    for (const std::size_t i : {0u, 5u, 13u}) {
      SCOPED_TRACE(fmt::format("{}; log {}: {}", damage.what, i, clean_logs()[i].data.source));
      Dataset log = clean_logs()[i].data;
      damage.apply(log);
      const std::vector<Finding> findings = diagnose(log, &clean_logs()[i].robot);
      bool found = false;
      for (const Finding& f : findings) {
        if (!is_told(f)) continue;
        EXPECT_EQ(name_of(f.kind), damage.name) << to_text(f, log);
        found = found || (name_of(f.kind) == damage.name && f.signal == damage.signal &&
                          f.joint == damage.joint && f.other == damage.other);
      }
      EXPECT_TRUE(found) << text_of(findings, log);
    }
}

/// A log of the arm with friction on every joint, joint `turning` fast enough to turn many times.
Dataset log_with_turns(const dynamics::RobotModel& robot, int turning) {
  Rng rng(5, 0);
  Dataset d;
  d.name = "turns";
  d.rate_hz = 250;
  const int n = robot.n(), T = 5000;
  d.t = Eigen::VectorXd::LinSpaced(T, 0, (T - 1) / d.rate_hz);
  d.q.resize(T, n);
  d.tau.resize(T, n);
  dynamics::Workspace<double> ws(robot);
  std::vector<double> q(6), v(6), a(6), tau(6);
  for (const auto& joint : robot.joints) d.joint_names.push_back(joint.name);
  for (int k = 0; k < T; ++k) {
    for (int j = 0; j < n; ++j) {
      const auto i = static_cast<std::size_t>(j);
      q[i] = v[i] = a[i] = 0;
      for (const double w : {0.6 + 0.07 * j, 1.9 - 0.11 * j}) {
        const double size = (j == turning ? 40 : 0.4) * 0.6 / w;
        q[i] += size * std::sin(w * d.t[k] + j);
        v[i] += size * w * std::cos(w * d.t[k] + j);
        a[i] -= size * w * w * std::sin(w * d.t[k] + j);
      }
    }
    dynamics::rnea<double>(robot, ws, {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())},
                           q, v, a, tau);
    for (int j = 0; j < n; ++j) {
      const auto i = static_cast<std::size_t>(j);
      const double effort = robot.joints[i].effort;
      d.q(k, j) = q[i];
      d.tau(k, j) = tau[i] + 0.05 * effort * (v[i] > 0 ? 1 : -1) + 0.02 * effort * v[i] +
                    1e-3 * effort * rng.normal();
    }
  }
  return d;
}

TEST(Doctor, FindsDegreesOfAContinuousJoint) {
  for (const int j : {0, 1, 2, 3, 4}) {
    dynamics::RobotModel robot = clean_logs()[0].robot;
    robot.joints[static_cast<std::size_t>(j)].continuous = true;
    Dataset d = clean_logs()[0].data;
    d.v.resize(0, 0);
    d.q.col(j) *= 180 / std::numbers::pi;
    ASSERT_GT(d.q.col(j).cwiseAbs().maxCoeff(), 4 * std::numbers::pi);
    const auto found = of_kind(diagnose(d, &robot), "angle_unit");
    ASSERT_EQ(found.size(), 1u) << "joint " << j << text_of(diagnose(d, &robot), d);
    EXPECT_EQ(found[0].joint, j);
  }
}

// Where the torque does not tell.
TEST(Doctor, FindsDegreesOfAContinuousJointByItsVelocity) {
  dynamics::RobotModel robot = clean_logs()[0].robot;
  robot.joints[5].continuous = true;
  Dataset d = clean_logs()[0].data;
  d.q.col(5) *= 180 / std::numbers::pi;
  const auto found = of_kind(diagnose(d, &robot), "angle_unit");
  ASSERT_EQ(found.size(), 1u) << text_of(diagnose(d, &robot), d);
  EXPECT_EQ(found[0].joint, 5);
  EXPECT_EQ(found[0].signal, "q");
}

TEST(Doctor, AContinuousJointMayTurn) {
  for (int j = 0; j < 6; ++j) {
    dynamics::RobotModel robot = clean_logs()[0].robot;
    robot.joints[static_cast<std::size_t>(j)].continuous = true;
    const Dataset d = log_with_turns(robot, j);
    ASSERT_GT(d.q.col(j).cwiseAbs().maxCoeff(), 4 * std::numbers::pi);
    const auto findings = diagnose(d, &robot);
    EXPECT_TRUE(of_kind(findings, "angle_unit").empty()) << "joint " << j << text_of(findings, d);
  }
}

/// One log behind the other, each with its own clock.
Dataset joined(const Dataset& first, const Dataset& second) {
  Dataset d = first;
  d.t.resize(first.length() + second.length());
  d.t << first.t, second.t;
  for (RowMatrix Dataset::*table :
       {&Dataset::q, &Dataset::tau, &Dataset::v, &Dataset::temperature}) {
    (d.*table).resize(d.t.size(), d.n());
    d.*table << first.*table, second.*table;
  }
  return d;
}

TEST(Doctor, TwoRecordingsInOneFileAreToldApart) {
  const Dataset& first = clean_logs()[0].data;
  const Dataset d = joined(first, clean_logs()[5].data);
  const std::vector<Finding> findings = diagnose(d, &clean_logs()[0].robot);
  const auto restarts = of_kind(findings, "restart");
  ASSERT_EQ(restarts.size(), 1u) << text_of(findings, d);
  EXPECT_NE(to_text(restarts[0], d).find(fmt::format("after row {}", first.length())),
            std::string::npos)
      << to_text(restarts[0], d);
  EXPECT_TRUE(info_of(restarts[0].kind).misleads);
  EXPECT_THROW(repair(d, findings, {}), UserError);
  EXPECT_EQ(std::ranges::count_if(findings, is_damage), 1) << text_of(findings, d);
}

// Gravity of the file turned by 14 degrees against that of the log.
TEST(Doctor, ABaseOnASlopeIsFound) {
  const auto& clean = clean_logs()[0];
  EXPECT_TRUE(of_kind(diagnose(clean.data, &clean.robot), "mount").empty());
  // the same motion and torque of a robot whose file has its base turned the other way
  dynamics::RobotModel leaning = clean.robot;
  leaning.gravity = Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitX()) * clean.robot.gravity;
  const std::vector<Finding> findings = diagnose(clean.data, &leaning);
  const auto mount = of_kind(findings, "mount");
  ASSERT_EQ(mount.size(), 1u) << text_of(findings, clean.data);
  EXPECT_NE(mount[0].unit.find("mount_rpy"), std::string::npos) << mount[0].unit;
}

/// A log of a pendulum on a bench whose file makes its link too light by a tenth, its rotor by a
/// seventh. @param zero  what its angle is logged too large by [rad]
Log pendulum(double zero) {
  Log out;
  out.robot = dynamics::parse_urdf(
      R"(<robot name="bench"><link name="base"/><link name="l1"><inertial><origin xyz="0 0 -0.3"/>
         <mass value="4"/><inertia ixx=".05" iyy=".05" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
         </link><joint name="j" type="revolute"><parent link="base"/><child link="l1"/>
         <axis xyz="0 1 0"/><limit lower="-3" upper="3" velocity="6" effort="60"/>
         <fricid armature="0.3"/></joint></robot>)",
      "bench");
  Eigen::VectorXd truth = out.robot.pi;
  truth.head<10>() *= 1.1;
  truth[out.robot.armature_begin()] *= 1.15;
  constexpr int T = 10000;
  constexpr double dt = 0.004;
  Dataset& d = out.data;
  d.name = "pendulum";
  d.joint_names = {"j"};
  d.rate_hz = 1 / dt;
  d.t = Eigen::VectorXd::LinSpaced(T, 0, (T - 1) * dt);
  d.q.resize(T, 1);
  d.tau.resize(T, 1);
  dynamics::Workspace<double> ws(out.robot);
  Rng rng(5, 0);
  for (int k = 0; k < T; ++k) {
    double q = 0, v = 0, a = 0, tau = 0;
    for (int h = 1; h < 6; ++h) {
      const double w = 2 * std::numbers::pi * 0.08 * h, x = w * d.t[k] + h * h;
      q += 0.4 * std::sin(x), v += 0.4 * w * std::cos(x), a -= 0.4 * w * w * std::sin(x);
    }
    dynamics::rnea<double>(out.robot, ws, {truth.data(), static_cast<std::size_t>(truth.size())},
                           {&q, 1}, {&v, 1}, {&a, 1}, {&tau, 1});
    d.q(k, 0) = q + zero + 1e-5 * rng.normal();
    d.tau(k, 0) = tau + 3 * std::tanh(v / 0.01) + 1.2 * v + 0.05 * rng.normal();
  }
  return out;
}

// A tilt across the only axis makes the arm lighter and is no finding; one about it is a wrong
// zero.
TEST(Doctor, APendulumOfAnotherWeightStandsUpright) {
  const Log upright = pendulum(0), off = pendulum(0.2);
  const std::vector<Finding> none = diagnose(upright.data, &upright.robot);
  EXPECT_TRUE(of_kind(none, "mount").empty()) << text_of(none, upright.data);
  const std::vector<Finding> findings = diagnose(off.data, &off.robot);
  const auto mount = of_kind(findings, "mount");
  ASSERT_EQ(mount.size(), 1u) << text_of(findings, off.data);
  EXPECT_NE(mount[0].unit.find("offset_rad of j is -0.2"), std::string::npos) << mount[0].unit;
}

// What the scene declares is part of what the robot explains.
TEST(Doctor, ADeclaredSpringIsNoSlope) {
  Log log = pendulum(0);
  for (int k = 0; k < log.data.length(); ++k) {
    const double q = log.data.q(k, 0);
    log.data.tau(k, 0) += 6 * std::cos(q);
  }
  EXPECT_FALSE(of_kind(diagnose(log.data, &log.robot), "mount").empty());
  using Shape = dynamics::LinearTorque::Shape;
  log.robot.linear_torques = {
      {"1", 0, Shape::kConstant, 1}, {"q", 0, Shape::kLinear, 1}, {"cos(q)", 0, Shape::kCos, 1}};
  log.robot.pi.conservativeResize(log.robot.parameter_count());
  log.robot.pi.tail(3).setZero();
  const std::vector<Finding> findings = diagnose(log.data, &log.robot);
  EXPECT_TRUE(of_kind(findings, "mount").empty()) << text_of(findings, log.data);
}

// One log per joint is a usual test.
TEST(Doctor, AJointThatMovesInAnotherLogIsNotStill) {
  const auto& [log, robot] = clean_logs()[0];
  Dataset resting = log;
  resting.q.col(4).setConstant(0.3);
  resting.v.col(4).setZero();
  const auto still = [&](const std::vector<Dataset>& logs) {
    std::size_t count = 0;
    for (const auto& findings : diagnose(logs, &robot)) count += of_kind(findings, "still").size();
    return count;
  };
  EXPECT_EQ(still({resting, resting}), 2u);
  EXPECT_EQ(still({resting, log}), 0u);
}

TEST(Doctor, AStampThatIsBackAloneIsNoSecondRecording) {
  Dataset d = clean_logs()[0].data;
  d.t[900] = d.t[100];
  const std::vector<Finding> findings = diagnose(d, &clean_logs()[0].robot);
  EXPECT_EQ(of_kind(findings, "duplicate").size(), 1u) << text_of(findings, d);
  EXPECT_TRUE(of_kind(findings, "restart").empty()) << text_of(findings, d);
}

TEST(Doctor, AStampThatIsAheadAloneIsNoSecondRecording) {
  const Dataset& whole = clean_logs()[0].data;
  Dataset d = whole;
  d.t[900] = 1e3;
  const std::vector<Finding> findings = diagnose(d, &clean_logs()[0].robot);
  EXPECT_TRUE(of_kind(findings, "restart").empty()) << text_of(findings, d);
  ASSERT_EQ(of_kind(findings, "duplicate").size(), 1u) << text_of(findings, d);
  EXPECT_EQ(of_kind(findings, "duplicate")[0].rows, std::vector<int>{900});
  ASSERT_EQ(of_kind(findings, "gap").size(), 1u) << text_of(findings, d);
  EXPECT_EQ(of_kind(findings, "gap")[0].size, 1);
  const Dataset mended =
      repair(d, findings, std::array{FindingKind::kDuplicate, FindingKind::kGap});
  EXPECT_LT((mended.t - whole.t).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(mended.q.row(901), whole.q.row(901));
}

// A URDF as published states no armature; nominal torques of light wrists are then far too small.
TEST(Doctor, MissingArmatureIsNoTorqueUnit) {
  for (const std::size_t i : {0u, 5u, 13u}) {
    Log log = clean_logs()[i];
    log.robot.pi.segment(log.robot.armature_begin(), log.robot.n()).setZero();
    const auto findings = diagnose(log.data, &log.robot);
    EXPECT_EQ(text_of(findings, log.data), "");
  }
}

// A wrist whose torque is friction: physics does not tell its unit, its drive does.
TEST(Doctor, ATorqueFarBeyondTheDriveIsInAnotherUnit) {
  Log log = clean_logs()[0];
  const int n = log.robot.n(), wrist = n - 1;
  for (int k = 1; k < log.data.length(); ++k)
    log.data.tau(k, wrist) = log.data.q(k, wrist) > log.data.q(k - 1, wrist) ? 2 : -2;
  for (int j = 0; j < n; ++j)
    log.robot.joints[static_cast<std::size_t>(j)].effort =
        1.2 * log.data.tau.col(j).cwiseAbs().maxCoeff();
  EXPECT_TRUE(of_kind(diagnose(log.data, &log.robot), "torque_unit").empty());
  log.data.tau.col(wrist) *= 1000;
  const auto found = of_kind(diagnose(log.data, &log.robot), "torque_unit");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].joint, wrist);
  // limits that are all the same are nobody's
  for (dynamics::Joint& joint : log.robot.joints) joint.effort = 10;
  EXPECT_TRUE(of_kind(diagnose(log.data, &log.robot), "torque_unit").empty());
}

// The mass of a light link lies elsewhere than its file says: gravity has the other sign, as if the
// joint turned the other way round.
TEST(Doctor, AWrongCentreOfMassIsNoSign) {
  for (std::size_t i = 0; i < clean_logs().size(); ++i) {
    Log log = clean_logs()[i];
    for (int link = log.robot.n() - 2; link < log.robot.n(); ++link) {
      dynamics::RobotModel file = log.robot;
      auto moment = file.pi.segment<3>(10 * link + 1);
      moment = -0.8 * (Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) * Eigen::Vector3d(moment));
      EXPECT_TRUE(of_kind(diagnose(log.data, &file), "sign").empty()) << "log " << i << " " << link;
    }
  }
}

// A load that the file has on the axis of the last joint, and that lies beside it.
TEST(Doctor, ALoadBesideTheAxisIsNoTorqueUnit) {
  const Log log = pendulum(0);
  dynamics::RobotModel file = log.robot;
  file.pi.segment<9>(1) /= 40;
  file.pi[file.armature_begin()] = 0;
  EXPECT_EQ(of_kind(diagnose(log.data, &file), "torque_unit").size(), 1u) << "4 kg, 0.3 m away";
  file.pi[0] = 20;
  EXPECT_TRUE(of_kind(diagnose(log.data, &file), "torque_unit").empty()) << "20 kg, 0.07 m away";
}

}  // namespace
}  // namespace fricid::doctor
