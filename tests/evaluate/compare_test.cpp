#include "fricid/evaluate/compare.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fricid/base/error.hpp"
#include "fricid/base/not_finite.hpp"

namespace fricid::evaluate {
namespace {

Summary summary(const char* who, bool is_oracle, bool conventional, double error) {
  Summary row;
  row.name = row.label = who;
  row.is_oracle = is_oracle;
  row.is_conventional = conventional;
  row.q_mse_geometric_mean = {error};
  row.diverged = 1;
  row.rollouts = 4;
  return row;
}

/// A run with an oracle, a convention and one other model.
ComparedRun run(const std::string& scene, double oracle, double convention, double model,
                double horizon = 1) {
  ComparedRun made{scene, {}, {{"lugre", 2}, {"lvm", 6 * model / convention}}};
  made.evaluation.scene = scene;
  made.evaluation.horizons_s = {horizon};
  made.evaluation.best_conventional = {convention};
  made.evaluation.oracle = made.evaluation.floor = {oracle};
  made.evaluation.summary = {summary("oracle", true, false, oracle),
                             summary("lugre", false, true, convention),
                             summary("lvm", false, false, model)};
  return made;
}

TEST(Compare, JoinsTheSeedsOfAScene) {
  const std::vector<ComparedRun> runs{run("s", 1e-6, 1e-3, 1e-5), run("s", 4e-6, 4e-3, 4e-5),
                                      run("t", 1, 2, 1.5)};
  const std::vector<ComparedScene> scenes = compare_runs(runs).scenes;
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scenes[0].scene, "s");
  EXPECT_EQ(scenes[0].runs, 2);
  ASSERT_EQ(scenes[0].models.size(), 3u);
  const ComparedModel& lvm = scenes[0].models[2];
  EXPECT_EQ(lvm.name, "lvm");
  EXPECT_NEAR(lvm.q_mse[0], 2e-5, 1e-18);
  // two runs differ by a factor of 4, but not in their ratio to the convention
  EXPECT_NEAR(lvm.against_convention[0], 0.01, 1e-15);
  EXPECT_NEAR(lvm.against_convention_90[0].low, 0.01, 1e-12);
  EXPECT_NEAR(lvm.against_convention_90[0].high, 0.01, 1e-12);
  // t_{0.95, 1} = 6.314 standard errors of log 2 each
  EXPECT_NEAR(std::log(lvm.interval_90[0].high / 2e-5), 6.3138 * std::log(2.0), 1e-3);
  EXPECT_NEAR(lvm.headroom_closed[0], 2.0 / 3, 1e-12);
  EXPECT_NEAR(scenes[0].headroom[0], 1000, 1e-9);
  EXPECT_EQ(lvm.diverged, 2);
  EXPECT_EQ(lvm.rollouts, 8);
  EXPECT_NEAR(lvm.fit_seconds, 0.06, 1e-12);
  EXPECT_EQ(scenes[1].models[1].fit_seconds, 2);
  EXPECT_TRUE(std::isnan(scenes[0].models[0].fit_seconds));
  EXPECT_TRUE(std::isnan(scenes[1].models[2].interval_90[0].low));
}

// A log has no oracle: its headroom is over the floor, as in the table of the run itself.
TEST(Compare, WithoutAnOracleTheFloorStandsInItsPlace) {
  ComparedRun log = run("log", kNan, 1e-3, 1e-4);
  log.evaluation.floor = {1e-5};
  log.evaluation.summary.erase(log.evaluation.summary.begin());
  const ComparedScene scene = compare_runs(std::vector{log}).scenes.front();
  EXPECT_NEAR(scene.headroom[0], 100, 1e-9);
  EXPECT_NEAR(scene.models[1].headroom_closed[0], 0.5, 1e-12);
}

// Bands count where a run has them; a model without any has no row.
TEST(Compare, AveragesTheCoverageOfBandsAndTheFrictionAlongRollouts) {
  std::vector<ComparedRun> runs{run("s", 1e-6, 1e-3, 1e-5), run("s", 4e-6, 4e-3, 4e-5),
                                run("s", 1e-6, 1e-3, 1e-5)};
  runs[0].evaluation.summary[2].band_coverage = {0.8};
  runs[2].evaluation.summary[2].band_coverage = {0.9};
  for (const std::size_t i : {0u, 1u, 2u})
    runs[i].evaluation.summary[2].friction_rollout = 0.01 * static_cast<double>(i);
  const Comparison comparison = compare_runs(runs);
  const std::vector<ComparedModel>& models = comparison.scenes.front().models;
  ASSERT_EQ(models[2].band_coverage.size(), 1u);
  EXPECT_NEAR(models[2].band_coverage[0], 0.85, 1e-12);
  EXPECT_NEAR(models[2].friction_rollout, 0.01, 1e-12);
  EXPECT_TRUE(models[1].band_coverage.empty());
  const std::string text = to_markdown(comparison);
  const std::size_t bands = text.find("| % inside the 90 % bands");
  ASSERT_NE(bands, std::string::npos);
  EXPECT_NE(text.find("| lvm", bands), std::string::npos);
  EXPECT_EQ(text.find("| lugre", bands), std::string::npos);
  EXPECT_EQ(to_markdown(compare_runs(std::vector{run("t", 1, 2, 1.5)})).find("bands"),
            std::string::npos);
}

TEST(Compare, AddsTheIntervalsOfParameters) {
  std::vector<ComparedRun> runs{run("s", 1e-6, 1e-3, 1e-5), run("s", 4e-6, 4e-3, 4e-5)};
  EXPECT_EQ(to_markdown(compare_runs(runs)).find("hold the truth"), std::string::npos);
  runs[0].evaluation.summary[2].intervals = {{.stated = 40, .hold = 36}, {}};
  runs[1].evaluation.summary[2].intervals = {{.stated = 40, .hold = 34}, {}};
  const std::string table = to_markdown(compare_runs(runs));
  EXPECT_NE(table.find("70 of 80 (88 %)"), std::string::npos) << table;
}

TEST(Compare, TableNamesEveryScene) {
  const std::vector<ComparedRun> runs{run("s", 1e-6, 1e-3, 1e-5), run("t", 1, 2, 1.5)};
  const std::string text = to_markdown(compare_runs(runs));
  EXPECT_NE(text.find("## s: 1 run\n"), std::string::npos);
  EXPECT_NE(text.find("## t: 1 run\n"), std::string::npos);
  EXPECT_NE(text.find("| lvm "), std::string::npos);
}

// Errors over those of a named model of the same run; scenes without it have no such table.
TEST(Compare, AgainstAModel) {
  const std::vector<ComparedRun> runs{run("s", 1e-6, 1e-3, 1e-5), run("s", 4e-6, 4e-3, 8e-5),
                                      run("t", 1, 2, 1.5)};
  std::vector<ComparedRun> some = runs;
  some[2].evaluation.summary.pop_back();
  const Comparison comparison = compare_runs(some, "lvm");
  EXPECT_EQ(comparison.scenes[0].against, "lvm");
  EXPECT_EQ(comparison.scenes[1].against, "");
  EXPECT_NEAR(comparison.scenes[0].models[1].against_named[0], std::sqrt(100.0 * 50), 1e-9);
  EXPECT_EQ(comparison.scenes[0].models[2].against_named[0], 1);
  EXPECT_TRUE(std::isnan(comparison.scenes[1].models[1].against_named[0]));
  const std::string text = to_markdown(comparison);
  EXPECT_NE(text.find("| against lvm "), std::string::npos);
  EXPECT_EQ(text.find("| against lvm ", text.find("## t")), std::string::npos);
  EXPECT_EQ(to_markdown(compare_runs(some)).find("against lvm"), std::string::npos);
  EXPECT_THROW(compare_runs(runs, "lmv"), UserError);
}

// One name is not yet one problem: other robots or data are no repetition.
TEST(Compare, ListsRunsOfOtherProblemsApart) {
  std::vector<ComparedRun> runs{run("s", 1e-6, 1e-3, 1e-5), run("s", 4e-6, 4e-3, 4e-5),
                                run("s", 1, 2, 1.5), run("t", 1, 2, 1.5)};
  runs[0].place = "run/a", runs[1].place = "run/b", runs[2].place = "run/c";
  runs[0].problem = runs[1].problem = "arm";
  runs[2].problem = "other arm";
  const auto scenes_of = [&] {
    std::vector<std::pair<std::string, int>> found;
    for (const ComparedScene& scene : compare_runs(runs).scenes)
      found.emplace_back(scene.scene, scene.runs);
    return found;
  };
  using Scenes = std::vector<std::pair<std::string, int>>;
  EXPECT_EQ(scenes_of(), (Scenes{{"s (run/a, run/b)", 2}, {"s (run/c)", 1}, {"t", 1}}));
  // nor are fits of one name with other settings
  runs[2].problem = "arm";
  EXPECT_EQ(scenes_of(), (Scenes{{"s", 3}, {"t", 1}}));
  runs[0].fits = {{"lvm_s1", "x"}};
  runs[1].fits = {{"lvm_s2", "y"}};
  runs[2].fits = {{"lvm_s1", "z"}};
  EXPECT_EQ(scenes_of(), (Scenes{{"s (run/a, run/b)", 2}, {"s (run/c)", 1}, {"t", 1}}));
}

TEST(Compare, RefusesOtherHorizons) {
  const std::vector<ComparedRun> mixed{run("s", 1e-6, 1e-3, 1e-5, 1),
                                       run("s", 1e-6, 1e-3, 1e-5, 10)};
  EXPECT_THROW(compare_runs(mixed), UserError);
}

}  // namespace
}  // namespace fricid::evaluate
