#include "fricid/evaluate/ensemble.hpp"

#include <gtest/gtest.h>

#include "contest.hpp"

namespace fricid::test {
namespace {

using evaluate::ensemble_score;
using evaluate::EnsembleScore;
using evaluate::Rollout;

/// k members of one joint that differ from `truth` by independent noise, and by `bias` together.
struct Drawn {
  evaluate::Trajectory trajectory;
  std::vector<Rollout> rollouts;
  std::vector<const Rollout*> members;
  Drawn(int k, double sd, double bias, int T = 4000) {
    Rng rng(4, 2);
    trajectory.data.q = RowMatrix::Zero(T, 1);
    for (Eigen::Index i = 0; i < T; ++i) trajectory.data.q(i, 0) = sd * rng.normal() + bias;
    for (int m = 0; m < k; ++m) {
      Rollout& rollout = rollouts.emplace_back();
      rollout.start = {0, 0, T - 1};
      rollout.q = RowMatrix::Zero(T, 1);
      for (Eigen::Index i = 0; i < T; ++i) rollout.q(i, 0) = sd * rng.normal();
    }
    for (const Rollout& rollout : rollouts) members.push_back(&rollout);
  }
};

// Oracle: a truth drawn as the members are lies in the 90 % band 90 % of the time, and the mean of
// k members errs by sd^2 (1 + 1/k).
TEST(Ensemble, CoversATruthThatIsDrawnLikeItsMembers) {
  for (const int k : {3, 5, 10}) {
    const Drawn drawn(k, 0.1, 0);
    const EnsembleScore score = ensemble_score(drawn.members, drawn.trajectory, 3999);
    EXPECT_NEAR(score.coverage, 0.9, 0.02) << k;
    EXPECT_NEAR(score.q_mse, 0.01 * (1 + 1.0 / k), 1e-3) << k;
  }
}

TEST(Ensemble, MissesWhatAllMembersGetWrong) {
  const Drawn drawn(5, 0.1, 1);
  EXPECT_LT(ensemble_score(drawn.members, drawn.trajectory, 3999).coverage, 0.1);
}

TEST(Ensemble, KnowsNoHorizonBeyondItsMembers) {
  const Drawn drawn(3, 0.1, 0, 10);
  EXPECT_TRUE(std::isnan(ensemble_score(drawn.members, drawn.trajectory, 10).q_mse));
  EXPECT_FALSE(std::isnan(ensemble_score(drawn.members, drawn.trajectory, 9).q_mse));
}

// Three seeds of a model are an ensemble in the report; two are not.
TEST(Ensemble, StandsInTheSummary) {
  evaluate::Contest contest = small_contest(200);
  data::ModelFile other = contest.models.back();
  for (int seed : {2, 3}) {
    other.seed = seed;
    other.arm.friction.theta.front() *= 1.01;
    contest.models.push_back(other);
  }
  const auto report = evaluate::evaluate(contest, small_options(), 2);
  const evaluate::Summary& lugre = report.summary.back();
  ASSERT_EQ(lugre.ensemble_q_mse.size(), 3u);
  EXPECT_GT(lugre.ensemble_q_mse[0], 0);
  EXPECT_TRUE(std::isnan(lugre.ensemble_q_mse[1]));  // one second is longer than the recording
  EXPECT_GE(lugre.ensemble_coverage[2], 0);
  EXPECT_LE(lugre.ensemble_coverage[2], 1);
  EXPECT_TRUE(report.summary[1].ensemble_q_mse.empty());
  EXPECT_NE(to_markdown(report).find("seeds together"), std::string::npos);
}

}  // namespace
}  // namespace fricid::test
