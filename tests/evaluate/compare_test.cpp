#include "fricid/evaluate/compare.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "temporary_folder.hpp"

namespace fricid::evaluate {
namespace {

class Compare : public TemporaryFolder {
 protected:
  /// A run folder whose evaluation has an oracle, a convention and one other model.
  std::filesystem::path run(const std::string& name, const std::string& scene, double oracle,
                            double convention, double model, double horizon = 1) {
    const std::filesystem::path run_folder = folder / name;
    std::filesystem::create_directories(run_folder);
    const auto summary = [](const char* who, bool is_oracle, bool conventional, double error) {
      return fmt::format(
          R"({{"name": "{0}", "label": "{0}", "is_oracle": {1}, "is_conventional": {2},
              "parameters": 7, "fit_seconds": 2, "q_mse_geometric_mean": [{3}], "diverged": 1,
              "rollouts": 4, "friction": 0.1}})",
          who, is_oracle, conventional, error);
    };
    std::ofstream(run_folder / "evaluation.json") << fmt::format(
        R"({{"format": "fricid.evaluation/1", "scene": "{}", "horizons_s": [{}],
                          "best_conventional": [{}], "summary": [{}, {}, {}]}})",
        scene, horizon, convention, summary("oracle", true, false, oracle),
        summary("lugre", false, true, convention), summary("lvm", false, false, model));
    return run_folder;
  }
};

TEST_F(Compare, JoinsTheSeedsOfAScene) {
  const std::vector<std::filesystem::path> folders{
      run("a", "s", 1e-6, 1e-3, 1e-5), run("b", "s", 4e-6, 4e-3, 4e-5), run("c", "t", 1, 2, 1.5)};
  const std::vector<ComparedScene> scenes = compare_runs(folders);
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
  EXPECT_TRUE(std::isnan(scenes[1].models[2].interval_90[0].low));
}

TEST_F(Compare, TableNamesEveryScene) {
  const std::vector<std::filesystem::path> folders{run("a", "s", 1e-6, 1e-3, 1e-5),
                                                   run("c", "t", 1, 2, 1.5)};
  const std::string text = to_markdown(compare_runs(folders));
  EXPECT_NE(text.find("## s: 1 run\n"), std::string::npos);
  EXPECT_NE(text.find("## t: 1 run\n"), std::string::npos);
  EXPECT_NE(text.find("| lvm "), std::string::npos);
}

TEST_F(Compare, RefusesWhatIsNoRunAndOtherHorizons) {
  const std::vector<std::filesystem::path> nothing{folder / "nothing"};
  EXPECT_THROW(compare_runs(nothing), UserError);
  const std::vector<std::filesystem::path> mixed{run("a", "s", 1e-6, 1e-3, 1e-5, 1),
                                                 run("b", "s", 1e-6, 1e-3, 1e-5, 10)};
  EXPECT_THROW(compare_runs(mixed), UserError);
  std::filesystem::create_directories(folder / "bad");
  std::ofstream(folder / "bad" / "evaluation.json") << "{";
  const std::vector<std::filesystem::path> bad{folder / "bad"};
  EXPECT_THROW(compare_runs(bad), UserError);
}

}  // namespace
}  // namespace fricid::evaluate
