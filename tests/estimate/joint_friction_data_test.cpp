// Friction driven along recordings in pieces, against the same friction driven through each
// recording from its start, and filtered outside.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "arm_data.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/friction/sum.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::estimate {
namespace {

constexpr double kCutoffHz = 10;  // [Hz]

/// Recordings of the small arm, of unequal length.
std::vector<signals::Recording> recordings(int count, double seconds) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("dahl", {4, 200, 2}, arm.robot.n());
  std::vector<data::Dataset> logs;
  for (int i = 0; i < count; ++i) {
    LogOptions options;
    options.seed = static_cast<std::uint64_t>(i + 1);
    options.seconds = seconds + 0.2 * (i % 3);
    logs.push_back(make_log(arm, options));
  }
  return prepare(arm.robot, {}, logs, 2).recordings;
}

std::vector<RowMatrix> torques(const std::vector<signals::Recording>& recordings) {
  std::vector<RowMatrix> torque;
  for (const signals::Recording& r : recordings) torque.push_back(r.filtered_tau);
  return torque;
}

/// F[f] of one joint along a recording.
RowMatrix reference(const friction::RobotFriction& one, const std::vector<double>& theta,
                    const signals::Recording& r, int joint) {
  const RowMatrix q = r.wide.q.col(joint), v = r.wide.v.col(joint), load = r.load.col(joint),
                  temperature = r.temperature.col(joint);
  RowMatrix f = drive_friction({one, theta}, r.dt, q, v, load, temperature).tau_f;
  signals::ZeroPhaseButterworth(kCutoffHz, 1 / r.dt).apply(f);
  return f;
}

double largest_error(const std::vector<double>& found, const RowMatrix& wanted, int begin,
                     int end) {
  double error = 0;
  for (int k = begin; k < end; ++k)
    error = std::max(error, std::abs(found[static_cast<std::size_t>(k)] - wanted(k, 0)));
  return error / wanted.cwiseAbs().maxCoeff();
}

/// Of joint 0, all of every recording.
void expect_whole(const JointFrictionData& data, const friction::RobotFriction& one,
                  const std::vector<double>& theta, const std::vector<signals::Recording>& logs,
                  double tolerance) {
  const PerSample found = data.predict(one, theta);
  for (std::size_t s = 0; s < logs.size(); ++s)
    EXPECT_LT(largest_error(found[s], reference(one, theta, logs[s], 0), 0, logs[s].length()),
              tolerance);
}

TEST(JointFrictionData, PiecesAddUpToTheWholeMotion) {
  const auto logs = recordings(2, 12);
  const JointFrictionData data(logs, torques(logs), 0, kCutoffHz);
  const friction::LvmParts gap{.memory = friction::Memory::kBristle, .backlash = true};
  const std::vector<friction::JointSpec> joints{friction::lvm_sum({}),
                                                friction::lvm_sum({.network = 2}),
                                                friction::lvm_sum(gap),
                                                {{{"dahl", 0, {}}}},
                                                {{{"coulomb_viscous", 0, {}}}}};
  for (const friction::JointSpec& joint : joints) {
    SCOPED_TRACE(joint.laws[0].law);
    const friction::RobotFriction one({joint});
    std::vector<double> theta = default_theta(one);
    initialise_weights(one, 1, theta);
    expect_whole(data, one, theta, logs, 1e-7);
  }
}

// Reference: the same motion logged forty times as often.
TEST(JointFrictionData, StepsBetweenSamplesFollowTheMotion) {
  constexpr int kFiner = 40;
  const auto motion = [](double rate_hz) {
    signals::Recording r;
    r.dt = 1 / rate_hz;
    const auto T = static_cast<Eigen::Index>(4 * rate_hz);
    r.wide = {RowMatrix(T, 1), RowMatrix(T, 1), {}};
    for (Eigen::Index k = 0; k < T; ++k) {
      const double phase = 4 * std::numbers::pi * static_cast<double>(k) * r.dt;
      r.wide.q(k, 0) = 0.01 * std::sin(phase);
      r.wide.v(k, 0) = 0.04 * std::numbers::pi * std::cos(phase);
    }
    r.load = RowMatrix::Zero(T, 1);
    r.temperature = RowMatrix::Constant(T, 1, kRoomTemperature);
    r.use.setConstant(T, 1, true);
    r.held_tau = r.load;
    return r;
  };
  const friction::RobotFriction one({{{{"lugre", 0, {}}}}});
  const std::vector<double> stiff{10, 15, 0.05, 6e4, 100, 2};  // Fc, Fs, vs, sigma0, sigma1, sigma2
  const signals::Recording coarse = motion(200), fine = motion(200 * kFiner);
  const RowMatrix every =
      drive_friction({one, stiff}, fine.dt, fine.wide.q, fine.wide.v, fine.load, fine.temperature)
          .tau_f;
  RowMatrix exact(coarse.length(), 1);
  for (int k = 0; k < coarse.length(); ++k) exact(k, 0) = every(kFiner * k, 0);
  signals::ZeroPhaseButterworth(kCutoffHz, 1 / coarse.dt).apply(exact);
  const auto error = [&](int steps) {
    const FrictionDrive how{.steps = steps, .motion = {}};
    const JointFrictionData data({&coarse, 1}, {}, 0, kCutoffHz, {}, {}, how);
    return largest_error(data.predict(one, stiff)[0], exact, 0, coarse.length());
  };
  EXPECT_GT(error(1), 0.001);
  EXPECT_LT(error(4), error(1) / 5);
}

// A spring that slips after more travel than the joint has holds what it held at the start.
TEST(JointFrictionData, FrictionThatDoesNotForgetIsDrivenInOnePiece) {
  const auto logs = recordings(2, 12);
  const JointFrictionData data(logs, torques(logs), 0, kCutoffHz);
  const friction::RobotFriction one({{{{"gms", 1, {}}}}});
  std::vector<double> theta = default_theta(one);
  const auto k1 = static_cast<std::size_t>(find_parameter(one, 0, "gms", "k1"));
  theta[k1] = theta[static_cast<std::size_t>(find_parameter(one, 0, "gms", "Fs"))] / 5;  // 5 rad
  expect_whole(data, one, theta, logs, 1e-12);
}

TEST(JointFrictionData, OfARangeTheMiddleIsThatOfTheWhole) {
  const auto logs = recordings(3, 12);
  const std::vector<SampleRange> ranges{{1200, 2400}, {0, 0}, {0, 1700}};
  const JointFrictionData data(logs, torques(logs), 1, kCutoffHz, {}, ranges);
  const friction::RobotFriction one({friction::lvm_sum({})});
  const std::vector<double> theta = default_theta(one);
  const PerSample found = data.predict(one, theta);
  const int padding = signals::ZeroPhaseButterworth(kCutoffHz, 1 / logs[0].dt).padding();
  for (std::size_t s : {0u, 2u}) {
    const int begin = ranges[s].begin > 0 ? ranges[s].begin + padding : 0;
    EXPECT_LT(
        largest_error(found[s], reference(one, theta, logs[s], 1), begin, ranges[s].end - padding),
        1e-7);
  }
}

// (1 + mu |load|) tau grows by mu tau per unit of load.
TEST(JointFrictionData, GainOfTheLoadIsTheLargestAlongTheMotion) {
  const auto logs = recordings(2, 12);
  const JointFrictionData data(logs, torques(logs), 0, kCutoffHz);
  const friction::RobotFriction one({{{{"dahl", 0, {{"load", 1}}}}}});
  std::vector<double> theta{4, 200, 0, 0.05};  // Fc, sigma0, Fv, mu
  EXPECT_NEAR(data.load_gain(one, theta), 0.05 * 4, 0.01 * 0.05 * 4);
  theta[3] = 0;
  EXPECT_EQ(data.load_gain(one, theta), 0);
}

// Nine recordings take two packs; 35 columns take three blocks of the filter.
TEST(JointFrictionData, LinearisesWhatItPredicts) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("dahl", {4, 200, 2}, arm.robot.n());
  std::vector<data::Dataset> logs;
  for (std::uint64_t seed = 1; seed <= 9; ++seed) {
    LogOptions options;
    options.seed = seed;
    options.seconds = 3 + 0.2 * static_cast<double>(seed % 3);
    logs.push_back(make_log(arm, options));
  }
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  std::vector<RowMatrix> target;
  std::vector<std::vector<int>> row;
  for (const signals::Recording& r : prepared.recordings) {
    target.push_back(r.filtered_tau);
    row.push_back({50, 51, r.length() - 60});
  }
  const JointFrictionData data(prepared.recordings, target, 1, 10);
  const friction::RobotFriction one({{{{"gms", 14, {{"load", 1}, {"ripple", 1}}}}}});
  const std::vector<double> theta = default_theta(one);
  std::vector<std::size_t> wanted;
  for (std::size_t p = 0; p < theta.size(); ++p)
    if (p != 3) wanted.push_back(p);
  ASSERT_GE(wanted.size(), 33u);
  const JointFrictionData::Linear found = data.linearise(one, theta, wanted, row);

  const auto rows_at = [&](const std::vector<double>& at) {
    const PerSample all = data.predict(one, at);
    Eigen::VectorXd f(3 * std::ssize(row));
    Eigen::Index r = 0;
    for (std::size_t s = 0; s < row.size(); ++s)
      for (const int k : row[s]) f[r++] = all[s][static_cast<std::size_t>(k)];
    return f;
  };
  EXPECT_LT((found.f - rows_at(theta)).norm(), 1e-12 * found.f.norm());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const double h = 1e-6 * theta[wanted[i]];
    if (h == 0) continue;
    std::vector<double> up = theta, down = theta;
    up[wanted[i]] += h;
    down[wanted[i]] -= h;
    const Eigen::VectorXd slope = (rows_at(up) - rows_at(down)) / (2 * h);
    EXPECT_LT((found.J.col(static_cast<Eigen::Index>(i)) - slope).norm(),
              1e-4 * slope.norm() + 1e-9)
        << one.parameters()[wanted[i]].symbol;
  }
}

// Rows that two samples per period of the cut-off are enough for take sums over blocks.
TEST(JointFrictionData, LinearisesDecimatedRowsAsItDoesOthers) {
  const auto logs = recordings(3, 8);
  const std::vector<SampleRange> ranges{{0, 1500}, {355, 1781}, {600, 2000}};
  const JointFrictionData data(logs, torques(logs), 1, kCutoffHz, {}, ranges);
  const int every = signals::decimation(logs[0].dt, kCutoffHz);
  ASSERT_GT(every, 9);
  std::vector<std::vector<int>> decimated(ranges.size()), all(ranges.size());
  std::vector<Eigen::Index> same;  // rows of `all`
  for (std::size_t s = 0, r = 0; s < ranges.size(); ++s)
    for (int k = ranges[s].begin; k < ranges[s].end; ++k, ++r) {
      all[s].push_back(k);
      if (k % every != 0) continue;
      decimated[s].push_back(k);
      same.push_back(static_cast<Eigen::Index>(r));
    }
  const friction::RobotFriction one({{{{"gms", 4, {{"load", 1}}}, {"dahl", 0, {}}}}});
  const std::vector<double> theta = default_theta(one);
  std::vector<std::size_t> wanted(theta.size());
  std::iota(wanted.begin(), wanted.end(), 0u);
  const JointFrictionData::Linear found = data.linearise(one, theta, wanted, decimated),
                                  reference = data.linearise(one, theta, wanted, all);
  EXPECT_LT((found.f - reference.f(same)).norm(), 1e-11 * found.f.norm());
  for (Eigen::Index i = 0; i < std::ssize(wanted); ++i)
    EXPECT_LT((found.J.col(i) - reference.J(same, i)).norm(),
              1e-11 * reference.J.col(i).norm() + 1e-14)
        << one.parameters()[static_cast<std::size_t>(i)].symbol;
}

TEST(CutMotion, CoversEveryRangeOnceWithARunInThatMovesTheJoint) {
  const int T = 5000;
  std::vector<std::vector<double>> q(2, std::vector<double>(T));
  for (int k = 0; k < T; ++k) q[0][static_cast<std::size_t>(k)] = std::sin(0.004 * k);
  for (int k = 0; k < T; ++k) q[1][static_cast<std::size_t>(k)] = 0.1 * std::cos(0.01 * k);
  const std::vector<SampleRange> ranges{{0, T}, {1000, 4000}};
  const int grid = 12;
  const std::vector<MotionPiece> pieces = cut_motion(q, ranges, 0.004, 8, grid);
  EXPECT_GE(pieces.size(), 7u);
  EXPECT_LE(pieces.size(), 8u);
  std::vector<std::vector<int>> covered(2, std::vector<int>(T, 0));
  for (const MotionPiece& piece : pieces) {
    const auto s = static_cast<std::size_t>(piece.sequence);
    for (int k = piece.begin; k < piece.end; ++k) ++covered[s][static_cast<std::size_t>(k)];
    ASSERT_LE(piece.start, piece.begin);
    EXPECT_EQ(piece.start % grid, 0);
    EXPECT_TRUE(piece.begin % grid == 0 || piece.begin == ranges[s].begin);
    if (piece.start == 0) continue;
    const auto [low, high] =
        std::minmax_element(q[s].begin() + piece.start, q[s].begin() + piece.begin + 1);
    EXPECT_GE(*high - *low, 0.1);
    EXPECT_GE(piece.begin - piece.start, 0.75 / 0.004);
  }
  for (std::size_t s = 0; s < 2; ++s)
    for (int k = 0; k < T; ++k)
      EXPECT_EQ(covered[s][static_cast<std::size_t>(k)], k >= ranges[s].begin && k < ranges[s].end);
}

// A joint that stands still tells nothing apart: no piece can forget how it started.
TEST(CutMotion, StartsAtTheBeginningWhereNothingMoves) {
  const std::vector<std::vector<double>> q{std::vector<double>(3000, 0.5)};
  for (const MotionPiece& piece : cut_motion(q, std::vector<SampleRange>{{0, 3000}}, 0.004, 8))
    EXPECT_EQ(piece.start, 0);
}

}  // namespace
}  // namespace fricid::estimate
