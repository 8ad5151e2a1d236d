#include "fricid/evaluate/evaluate.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "contest.hpp"
#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "temporary_folder.hpp"

namespace fricid::test {
namespace {

using evaluate::Evaluation;
using evaluate::ModelResult;

const ModelResult& result_of(const Evaluation& report, const std::string& name) {
  for (const ModelResult& model : report.models)
    if (model.name == name) return model;
  throw std::runtime_error("no model " + name);
}

const evaluate::Summary& summary_of(const Evaluation& report, const std::string& name) {
  for (const auto& summary : report.summary)
    if (summary.name == name) return summary;
  throw std::runtime_error("no summary " + name);
}

TEST(Evaluate, TrueModelWithoutNoiseHasNoError) {
  const Evaluation report = evaluate::evaluate(small_contest(400, 0), small_options(), 1);
  for (const auto& score : result_of(report, "oracle").scores)
    for (const double q_mse : score.error.q_mse)
      EXPECT_TRUE(q_mse == 0 || std::isnan(q_mse)) << q_mse;
  EXPECT_EQ(report.oracle[0], 0);
  EXPECT_GT(summary_of(report, "simple").q_mse_geometric_mean[0], 0);
}

// The same parameters, but the state washed out rather than known.
TEST(Evaluate, OnlyTheOracleStartsFromTheTrueFrictionState) {
  evaluate::Contest contest = small_contest(400, 0);
  contest.models.push_back(model_file("twin", contest.models[0].arm));
  const Evaluation report = evaluate::evaluate(contest, small_options(), 1);
  const ModelResult& twin = result_of(report, "twin");
  for (const auto& score : twin.scores)
    EXPECT_GT(score.error.q_mse[0], 0) << "start " << score.start_s;
  // washed out, not wrong: far closer than a model with wrong bristles
  EXPECT_LT(summary_of(report, "twin").q_mse_median[0],
            0.1 * summary_of(report, "lugre").q_mse_median[0]);
}

TEST(Evaluate, EveryModelStartsFromTheTrueMotion) {
  const evaluate::Contest contest = small_contest();
  const Evaluation report = evaluate::evaluate(contest, small_options(), 1);
  for (const ModelResult& model : report.models)
    for (const auto& rollout : model.rollouts) {
      const auto& truth =
          *contest.trajectories[static_cast<std::size_t>(rollout.start.trajectory)].truth;
      EXPECT_EQ(rollout.q.row(0), truth.q.row(0));
      EXPECT_EQ(rollout.v.row(0), truth.v.row(0));
    }
}

TEST(Evaluate, RanksTheModels) {
  const Evaluation report = evaluate::evaluate(small_contest(), small_options(), 1);
  ASSERT_EQ(report.summary.size(), 3u);
  EXPECT_TRUE(report.summary[0].is_oracle);
  const std::size_t h = 1;
  EXPECT_LT(report.oracle[h], summary_of(report, "lugre").q_mse_geometric_mean[h]);
  EXPECT_LT(summary_of(report, "lugre").q_mse_geometric_mean[h],
            summary_of(report, "simple").q_mse_geometric_mean[h]);
  EXPECT_EQ(report.best_conventional[h], summary_of(report, "lugre").q_mse_geometric_mean[h]);
  EXPECT_DOUBLE_EQ(report.headroom[h], report.best_conventional[h] / report.oracle[h]);
  EXPECT_EQ(summary_of(report, "simple").rollouts, 8);
  EXPECT_EQ(summary_of(report, "simple").diverged, 0);
  EXPECT_DOUBLE_EQ(report.horizons_s[2], 699 * kSamplePeriod);
}

// All torques of LuGre scaled by 1.05, the bristle length kept: friction is 5 % off everywhere.
TEST(Evaluate, DrivenFrictionOfTheTruthIsRight) {
  evaluate::Contest contest = small_contest();
  Arm strong = contest.models[0].arm;
  for (std::size_t i = 0; i < strong.friction.theta.size(); ++i)
    if (strong.friction.model.parameters()[i].symbol != "vs") strong.friction.theta[i] *= 1.05;
  contest.models.push_back(model_file("strong", strong));
  const Evaluation report = evaluate::evaluate(contest, small_options(), 1);
  // one step of washout per 4 ms against four of the truth
  EXPECT_LT(summary_of(report, "oracle").friction, 0.01);
  EXPECT_NEAR(summary_of(report, "strong").friction, 0.05, 0.005);
  EXPECT_GT(summary_of(report, "simple").friction_presliding, 0.1);
  EXPECT_GT(summary_of(report, "simple").friction_rollout,
            summary_of(report, "oracle").friction_rollout);
}

TEST(Evaluate, DrivenFrictionIsJudgedOnWholeRecordingsWhateverTheHorizons) {
  const evaluate::Contest contest = small_contest();
  evaluate::EvaluateOptions brief = small_options();
  brief.horizons_s = {0.1};
  EXPECT_EQ(summary_of(evaluate::evaluate(contest, brief, 1), "simple").friction,
            summary_of(evaluate::evaluate(contest, small_options(), 1), "simple").friction);
}

// The mean over joints of RMSE_j / RMS_j, first-sample rollouts only, by hand from the scores.
TEST(Evaluate, FrictionShareByHand) {
  const evaluate::Contest contest = small_contest();
  const Evaluation report = evaluate::evaluate(contest, small_options(), 1);
  double sum = 0;
  for (const auto& score : result_of(report, "simple").scores) {
    if (score.start_s > 0) continue;
    const auto& truth = contest.trajectories[static_cast<std::size_t>(score.trajectory)].truth;
    for (Eigen::Index j = 0; j < 6; ++j)
      sum += score.friction.all[static_cast<std::size_t>(j)] /
             std::sqrt(truth->tau_f.col(j).squaredNorm() / 700) / 12;
  }
  EXPECT_NEAR(summary_of(report, "simple").friction, sum, 1e-12);
}

// Friction 0.7 N m stronger in one direction than in the other, under the torque that balances it:
// a model that carries this as a constant torque of the joint is right, one without is 0.7 off.
TEST(Evaluate, ConstantTorqueOfAModelCountsAsFriction) {
  constexpr double kConstant = 0.7;
  evaluate::Contest contest = small_contest(400, 0);
  for (auto& trajectory : contest.trajectories) {
    trajectory.truth->tau_f.col(2).array() += kConstant;
    trajectory.data.tau.col(2).array() += kConstant;
  }
  Arm offset = contest.models[0].arm;
  dynamics::add_linear_torque(offset.robot, {"offset", 2}, kConstant);
  contest.models.push_back(model_file("offset", offset));

  const Evaluation report = evaluate::evaluate(contest, small_options(), 1);
  const auto& right = result_of(report, "offset").scores[0];
  EXPECT_LT(right.error.q_mse[2], 1e-10);  // it began with an estimated friction state
  EXPECT_LT(right.friction_rollout.all[2], 1e-2 * kConstant);
  EXPECT_LT(right.friction.all[2], 0.1 * kConstant);
  EXPECT_NEAR(result_of(report, "oracle").scores[0].friction.all[2], kConstant, 0.1 * kConstant);

  // what the robot had before identification is no friction
  contest.robot = offset.robot;
  const Evaluation known = evaluate::evaluate(contest, small_options(), 1);
  EXPECT_NEAR(result_of(known, "offset").scores[0].friction_rollout.all[2], kConstant,
              1e-2 * kConstant);
}

TEST(Evaluate, SimulatorIsTheFirstOracleAndTheReference) {
  evaluate::Contest contest = small_contest();
  const auto options = small_options();
  const auto plan = evaluate::plan_starts(contest.trajectories, options.horizons_s, options.starts);
  // a stand-in for the simulator: the truth plus a constant
  const auto displaced = [&](double by) {
    std::vector<evaluate::Rollout> rollouts;
    for (const auto& start : plan) {
      const auto& truth = *contest.trajectories[static_cast<std::size_t>(start.trajectory)].truth;
      const auto rows = start.steps + 1;
      rollouts.push_back({start,
                          false,
                          truth.q.middleRows(start.begin, rows) + RowMatrix::Constant(rows, 6, by),
                          truth.v.middleRows(start.begin, rows),
                          {}});
    }
    return rollouts;
  };
  contest.simulator_oracle = displaced(1e-3);
  contest.simulator_halved = displaced(4e-3);
  std::erase_if(contest.simulator_halved, [](const auto& r) { return r.start.trajectory > 0; });
  const Evaluation report = evaluate::evaluate(contest, options, 1);
  EXPECT_EQ(report.summary[0].name, "simulator");
  for (std::size_t h = 0; h < 3; ++h) {
    EXPECT_NEAR(report.oracle[h], 1e-6, 1e-15);
    EXPECT_NEAR(report.halving[h], 9e-6, 1e-15);
    EXPECT_EQ(report.floor[h], report.halving[h]);
    EXPECT_DOUBLE_EQ(report.summary[0].ratio_to_oracle[h], 1);
  }
  // at 0.1 s the engine's oracle has hardly moved: the difference is the displacement
  EXPECT_NEAR(report.integration[0], 1e-6, 2e-7);

  contest.simulator_halved.pop_back();
  EXPECT_THROW(evaluate::evaluate(contest, options, 1), UserError);
}

TEST(Evaluate, SimulatorRolloutsThatDivergeAreSettled) {
  evaluate::Contest contest = small_contest(300);
  const auto options = small_options();
  for (const auto& start :
       evaluate::plan_starts(contest.trajectories, options.horizons_s, options.starts)) {
    evaluate::Rollout rollout{start,
                              false,
                              RowMatrix::Constant(start.steps + 1, 6, NAN),
                              RowMatrix::Constant(start.steps + 1, 6, NAN),
                              {}};
    rollout.q.row(0).setZero();
    contest.simulator_oracle.push_back(rollout);
  }
  const Evaluation report = evaluate::evaluate(contest, options, 1);
  EXPECT_EQ(report.summary[0].diverged, report.summary[0].rollouts);
  EXPECT_TRUE(std::isfinite(report.oracle[2]));
}

// A model whose wrist is driven away by its own friction: kept, counted, finite.
TEST(Evaluate, DivergedRolloutsCountAndStayFinite) {
  evaluate::Contest contest = small_contest();
  Arm wild = contest.models[1].arm;
  for (std::size_t i = 0; i < wild.friction.theta.size(); ++i)
    if (wild.friction.model.parameters()[i].symbol == "Fv") wild.friction.theta[i] = -30;
  contest.models.push_back(model_file("wild", wild));
  const Evaluation report = evaluate::evaluate(contest, small_options(), 1);
  const auto& summary = summary_of(report, "wild");
  ASSERT_EQ(summary.diverged, summary.rollouts);
  EXPECT_THAT(summary.doubts, testing::Contains(fmt::format(
                                  "all of its {} held-out rollouts diverged", summary.rollouts)));
  for (std::size_t h = 0; h < 3; ++h) {
    EXPECT_TRUE(std::isfinite(summary.q_mse_geometric_mean[h]));
    EXPECT_LE(summary.q_mse_mean[h], 100);  // clamped to 10 rad
  }
  for (const auto& score : result_of(report, "wild").scores)
    EXPECT_TRUE(std::isfinite(score.error.v_mse[1]));
}

TEST(Evaluate, LogsWithoutTruthStartFromTheFilteredMotion) {
  evaluate::Contest contest = small_contest();
  contest.models.erase(contest.models.begin());
  for (auto& trajectory : contest.trajectories) {
    trajectory.truth.reset();
    trajectory.q.array() += 1e-3;
  }
  const Evaluation report = evaluate::evaluate(contest, small_options(), 1);
  EXPECT_TRUE(std::isnan(report.oracle[0]));
  EXPECT_TRUE(std::isnan(report.headroom[0]));
  EXPECT_TRUE(std::isnan(summary_of(report, "simple").friction));
  EXPECT_TRUE(report.meaningful());
  EXPECT_TRUE(report.models[0].scores[0].friction.all.empty());
  EXPECT_EQ(report.models[0].rollouts[0].q.row(0), contest.trajectories[0].q.row(0));
  EXPECT_GE(report.models[0].scores[0].error.q_mse[0], 1e-7);
}

TEST(Evaluate, SameBytesForAnyNumberOfJobs) {
  const evaluate::Contest contest = small_contest();
  const std::string one = data::to_json(evaluate::evaluate(contest, small_options(), 1));
  EXPECT_GT(one.size(), 1000u);
  EXPECT_EQ(one, data::to_json(evaluate::evaluate(contest, small_options(), 2)));
  EXPECT_EQ(one, data::to_json(evaluate::evaluate(contest, small_options(), 3)));
}

TEST(Evaluate, ModelFileOfTheTruthRepeatsTheOracleToTheLastBit) {
  evaluate::Contest contest = small_contest();
  const OwnFolder folder;
  data::save_model(contest.models[0], folder.path() / "true_lugre.json");
  data::ModelFile loaded = data::load_model(folder.path() / "true_lugre.json");
  loaded.name = "loaded";
  contest.models.push_back(loaded);
  const Evaluation report = evaluate::evaluate(contest, small_options(), 2);
  const ModelResult& a = result_of(report, "oracle");
  const ModelResult& b = result_of(report, "loaded");
  ASSERT_EQ(a.rollouts.size(), b.rollouts.size());
  for (std::size_t i = 0; i < a.rollouts.size(); ++i) {
    EXPECT_EQ(a.rollouts[i].q, b.rollouts[i].q);
    EXPECT_EQ(a.rollouts[i].v, b.rollouts[i].v);
    EXPECT_EQ(a.rollouts[i].tau_f, b.rollouts[i].tau_f);
  }
}

TEST(Evaluate, RefusesWhatDoesNotFit) {
  const auto message = [](const evaluate::Contest& contest) -> std::string {
    try {
      evaluate::evaluate(contest, small_options(), 1);
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  evaluate::Contest contest = small_contest(200);
  contest.models[0].arm.friction = kr6_friction("gms");
  EXPECT_THAT(message(contest), ::testing::HasSubstr("true friction state has 6 values"));
  contest = small_contest(200);
  contest.models[1].arm = flywheel(1, 0);
  EXPECT_THAT(message(contest), ::testing::HasSubstr("expected"));
  contest.trajectories.clear();
  EXPECT_THAT(message(contest), ::testing::HasSubstr("no held-out data"));
}

}  // namespace
}  // namespace fricid::test
