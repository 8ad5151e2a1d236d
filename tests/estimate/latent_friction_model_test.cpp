// The arm as a state-space model: its Jacobian, and the filters of smc on it where it is the truth.
#include "fricid/estimate/em/latent_friction_model.hpp"

#include <gtest/gtest.h>

#include "drawn_recording.hpp"
#include "fricid/estimate/em/e_step.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/statistical_twist.hpp"

namespace fricid::estimate {
namespace {

using fricid::test::draw;
using fricid::test::Drawn;

class LatentModel : public ::testing::Test {
 protected:
  Arm arm{fricid::test::hanging_kr6(), fricid::test::kr6_friction("lugre")};
  StepOptions step{8, 4};
  Drawn drawn = draw(arm, 1000, 5, step);
  LatentFrictionModel model{arm, drawn.recording, drawn.noise, drawn.initial, step};
  const int nx = model.state_size();
};

TEST_F(LatentModel, TransitionIsTheArmsStep) {
  ArmStepper<double> stepper(arm, step);
  std::vector<double> x(drawn.x.row(300).begin(), drawn.x.row(300).end()), y = x;
  model.transition<double>(300, x);
  const std::vector<double> tau(drawn.recording.held_tau.row(300).begin(),
                                drawn.recording.held_tau.row(300).end());
  const std::vector<double> temperature(6, kRoomTemperature);
  stepper.step(tau, temperature, fricid::test::kSamplePeriod, std::span(y).subspan(0, 6),
               std::span(y).subspan(6, 6), std::span(y).subspan(12));
  EXPECT_EQ(x, y);
}

// A torque moves q and v of an arm without friction together as its noise is said to.
TEST(LatentNoise, MovesPositionAndVelocityAsATorqueDoes) {
  const Arm arm{fricid::test::hanging_kr6(),
                {friction::RobotFriction(std::vector<friction::JointSpec>(6)), {}}};
  const std::vector<double> temperature(6, kRoomTemperature);
  for (const StepOptions step : {StepOptions{1, 1}, {8, 1}, {8, 2}, {8, 4}, {8, 8}}) {
    ArmStepper<double> stepper(arm, step);
    const auto after = [&](double torque) {
      std::vector<double> x{0.4, -1.1, 1, -0.4, -0.9, 0, 0, 0, 0, 0, 0, 0};
      const std::vector<double> tau{torque, -torque, torque, -torque, torque, -torque};
      stepper.step(tau, temperature, fricid::test::kSamplePeriod, std::span(x).first(6),
                   std::span(x).last(6), {});
      return x;
    };
    const std::vector<double> more = after(1e-3), less = after(-1e-3);
    const double c = position_per_velocity(fricid::test::kSamplePeriod, step.substeps);
    LatentNoise noise{.dt = fricid::test::kSamplePeriod,
                      .q = Eigen::VectorXd::Constant(6, 1e-12),
                      .v = Eigen::VectorXd::Constant(6, 1e-2),
                      .z = {},
                      .R = {}};
    const Eigen::MatrixXd Q = noise.Q(step.substeps);
    for (std::size_t j = 0; j < 6; ++j) {
      const auto i = static_cast<Eigen::Index>(j);
      EXPECT_NEAR((more[j] - less[j]) / (more[6 + j] - less[6 + j]) / c, 1, 1e-3);
      EXPECT_DOUBLE_EQ(Q(i, 6 + i), c * 1e-2);
      EXPECT_NEAR(Q(i, i) - 1e-12, c * c * 1e-2, 1e-18);
    }
  }
}

TEST_F(LatentModel, JacobianEqualsCentralDifferencesInEveryLane) {
  Eigen::VectorXd f;
  Eigen::MatrixXd A;
  std::vector<PackD> x(static_cast<std::size_t>(nx)), wide(static_cast<std::size_t>(nx * nx));
  const int t = 400;
  for (int k = 0; k < PackD::kLanes; ++k)
    for (int i = 0; i < nx; ++i) x[static_cast<std::size_t>(i)].set(k, drawn.x(t - 40 * k, i));
  model.jacobian<PackD>(t, x, wide);
  for (int k = 0; k < PackD::kLanes; ++k) {
    const Eigen::VectorXd at = drawn.x.row(t - 40 * k);
    model.linearise(t, at, f, A);
    for (int column = 0; column < nx; ++column) {
      const double h = 1e-6 * std::max(1e-3, std::abs(at[column]));
      std::vector<double> up(at.begin(), at.end()), down = up;
      up[static_cast<std::size_t>(column)] += h;
      down[static_cast<std::size_t>(column)] -= h;
      model.transition<double>(t, up);
      model.transition<double>(t, down);
      for (int row = 0; row < nx; ++row) {
        const auto r = static_cast<std::size_t>(row);
        const double slope = (up[r] - down[r]) / (2 * h);
        EXPECT_NEAR(A(row, column), slope, 1e-5 * std::max(1.0, std::abs(slope)));
        EXPECT_DOUBLE_EQ(
            A(row, column),
            wide[r * static_cast<std::size_t>(nx) + static_cast<std::size_t>(column)][k]);
      }
    }
  }
}

// At the truth the linearised likelihood is close, the twisted filter's steady, and the innovations
// are as large as the model says. What weight is lost, is lost where a joint sticks: |v| has a kink
// there, which psi follows in one joint at a time.
TEST_F(LatentModel, TwistedFilterIsSteadyAtTheTruth) {
  constexpr int kMotions = 12, kRuns = 5;
  std::vector<double> sds, roots;
  for (std::uint64_t seed = 1; seed <= kMotions; ++seed) {
    const Drawn motion = draw(arm, 1000, seed, step);
    LatentFrictionModel at_truth(arm, motion.recording, motion.noise, motion.initial, step);
    const smc::RowMatrix y = motion.recording.log.q;
    smc::GaussianPath path;
    smc::gaussian_smoother(at_truth, y, path, 2);
    ASSERT_FALSE(path.failed);
    double nis = 0, channels = 0;
    for (std::size_t t = 0; t < path.nis.size(); ++t) {
      nis += path.nis[t];
      channels += path.present[t];
    }
    EXPECT_NEAR(nis / channels, 1, 3 * std::sqrt(2 / channels)) << "motion " << seed;

    smc::Twist twist;
    ASSERT_TRUE(smc::make_bent_twist(at_truth, y, at_truth.parts(), path.smoothed, twist));
    smc::TwistedGuide<PackD> guide(at_truth, twist);
    double sum = 0, squares = 0, least_roots = 1;
    for (int run = 0; run < kRuns; ++run) {
      smc::FilterOptions options;
      options.ess_threshold = 0.25;  // as in the E-step
      options.renewed = 0.05;
      options.seed = static_cast<std::uint64_t>(run + 1);
      smc::ParticleFilter<LatentFrictionModel, smc::TwistedGuide<PackD>> filter(at_truth, guide,
                                                                                options);
      smc::Report report;
      filter.run(report);
      ASSERT_FALSE(report.failed);
      const double log_likelihood = report.log_likelihood - path.log_likelihood;
      EXPECT_NEAR(log_likelihood, 0, 5) << "motion " << seed;
      sum += log_likelihood;
      squares += log_likelihood * log_likelihood;
      least_roots =
          std::min(least_roots, static_cast<double>(report.distinct_roots) / options.particles);
    }
    sds.push_back(std::sqrt((squares - sum * sum / kRuns) / (kRuns - 1)));
    roots.push_back(least_roots);
    EXPECT_LE(sds.back(), 0.3) << "motion " << seed;
    EXPECT_GE(roots.back(), 0.9) << "motion " << seed;
  }
  std::sort(sds.begin(), sds.end());
  std::sort(roots.begin(), roots.end());
  EXPECT_LE(sds[kMotions / 2], 0.1);
  RecordProperty("median_sd_nat", std::to_string(sds[kMotions / 2]));
  RecordProperty("median_roots", std::to_string(roots[kMotions / 2]));
}

TEST_F(LatentModel, SmoothedFrictionBandsCoverTheTruth) {
  for (const EStep method : {EStep::kEkf, EStep::kPsi}) {
    constexpr int kPaths = 100;
    const EStepResult smoothed = smooth(model, drawn.recording, 1000, {method, 200, kPaths, 1, 0});
    ASSERT_FALSE(smoothed.failed);
    int covered = 0, samples = 0;
    std::vector<double> tau_f(6);
    std::vector<std::vector<double>> values(6, std::vector<double>(kPaths));
    for (int t = 20; t < 1000; t += 5) {
      for (std::size_t p = 0; p < kPaths; ++p) {
        const smc::RowMatrix& x = smoothed.paths[p];
        model.friction_torque<double>(
            t, std::span<const double>(x.row(t).data(), static_cast<std::size_t>(nx)), tau_f);
        for (std::size_t j = 0; j < 6; ++j) values[j][p] = tau_f[j];
      }
      for (std::size_t j = 0; j < 6; ++j) {
        std::sort(values[j].begin(), values[j].end());
        const double truth = drawn.tau_f(t, static_cast<Eigen::Index>(j));
        covered += truth > values[j][4] && truth < values[j][95] ? 1 : 0;
        ++samples;
      }
    }
    const double share = static_cast<double>(covered) / samples;
    EXPECT_GE(share, 0.85) << name_of(method);
    EXPECT_LE(share, 0.95) << name_of(method);
  }
}

}  // namespace
}  // namespace fricid::estimate
