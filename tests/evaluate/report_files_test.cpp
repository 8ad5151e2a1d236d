#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "contest.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/hdf5.hpp"
#include "hostile_text.hpp"
#include "temporary_folder.hpp"

namespace fricid::test {
namespace {

using evaluate::Evaluation;
using nlohmann::json;
using ::testing::HasSubstr;

const Evaluation& report() {
  static const Evaluation made = evaluate::evaluate(small_contest(), small_options(), 1);
  return made;
}

TEST(EvaluationJson, HoldsTheFieldsOfTheContract) {
  const json file = json::parse(data::to_json(report()));
  EXPECT_EQ(file.at("format"), "fricid.evaluation/2");
  EXPECT_EQ(file.at("scene"), "small");
  EXPECT_EQ(file.at("trajectories"), (json{"validation_0", "validation_1"}));
  const std::size_t horizons = file.at("horizons_s").size();
  EXPECT_EQ(horizons, 3u);
  EXPECT_EQ(file.at("headroom").size(), horizons);
  EXPECT_TRUE(file.at("meaningful").is_boolean());

  ASSERT_EQ(file.at("models").size(), 3u);
  for (const json& model : file.at("models")) {
    for (const char* key : {"name", "label", "seed", "parameters", "is_oracle"})
      EXPECT_TRUE(model.contains(key)) << key;
    ASSERT_EQ(model.at("trajectories").size(), 8u);
    for (const json& rollout : model.at("trajectories")) {
      EXPECT_TRUE(rollout.at("name").is_string());
      EXPECT_TRUE(rollout.at("start_s").is_number());
      EXPECT_TRUE(rollout.at("diverged").is_boolean());
      for (const char* key : {"q_mse", "q_mae", "v_mse", "v_mae"})
        EXPECT_EQ(rollout.at(key).size(), horizons) << key;
      EXPECT_EQ(rollout.at("q_mse_joint").size(), horizons);
      EXPECT_EQ(rollout.at("q_mse_joint")[0].size(), 6u);
      for (const char* key : {"friction_rmse", "friction_rmse_presliding", "friction_rmse_reversal",
                              "friction_rmse_sliding"})
        EXPECT_EQ(rollout.at(key).size(), 6u) << key;
    }
  }
  EXPECT_TRUE(file.at("models")[0].at("is_oracle"));

  ASSERT_EQ(file.at("summary").size(), 3u);
  for (const json& summary : file.at("summary")) {
    for (const char* key : {"q_mse_geometric_mean", "q_mse_median", "q_mse_mean", "interval_90",
                            "ratio_to_oracle", "headroom_closed"})
      EXPECT_EQ(summary.at(key).size(), horizons) << key;
    EXPECT_EQ(summary.at("interval_90")[0].size(), 2u);
    EXPECT_EQ(summary.at("seeds"), 1);
    EXPECT_EQ(summary.at("diverged"), 0);
  }
}

TEST(EvaluationJson, FullLengthIsNullForLaterStarts) {
  const json file = json::parse(data::to_json(report()));
  const json& rollouts = file.at("models")[0].at("trajectories");
  EXPECT_TRUE(rollouts[0].at("q_mse")[2].is_number());
  EXPECT_GT(rollouts[1].at("start_s"), 0);
  EXPECT_TRUE(rollouts[1].at("q_mse")[2].is_null());
  EXPECT_TRUE(rollouts[1].at("q_mse_joint")[2][5].is_null());
}

TEST(EvaluationJson, NumbersSurviveTheRoundTrip) {
  const json file = json::parse(data::to_json(report()));
  EXPECT_EQ(file.at("summary")[1].at("q_mse_mean")[1].get<double>(),
            report().summary[1].q_mse_mean[1]);
}

TEST(Table, ShowsOracleFirstAndWhatTheBenchmarkIsWorth) {
  const std::string text = to_markdown(report());
  EXPECT_LT(text.find("| oracle"), text.find("| simple"));
  for (const char* part : {"0.1 s", "1 s", "2.8 s", "floor", "headroom", "headroom closed",
                           "diverged", "parameters", "budget", "presliding", "0/8", "1.00"})
    EXPECT_THAT(text, HasSubstr(part));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("nan")));
}

// The floor stands between oracle and models, the headroom below them.
TEST(Table, FloorAndHeadroomStandWithTheErrors) {
  Evaluation full = report();
  full.floor = {1.5e-7, 0.0123, 4666.6};
  full.headroom = {3.71, 0.5, std::numeric_limits<double>::quiet_NaN()};
  full.summary[1].friction = 0.1234;
  const std::string text = to_markdown(full);
  const std::size_t oracle = text.find("| oracle "), floor = text.find("| *floor*"),
                    simple = text.find("| simple "), headroom = text.find("| *headroom*");
  EXPECT_LT(oracle, floor);
  EXPECT_LT(floor, simple);
  EXPECT_LT(simple, headroom);
  const auto line = [&](std::size_t begin) {
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  EXPECT_THAT(line(floor), ::testing::MatchesRegex(R"(.* 1\.5e-7 \|  *0\.012 \|  *4667 \|.*)"));
  EXPECT_THAT(line(headroom), ::testing::MatchesRegex(R"(.* 3\.7 \|  *0\.50 \|  *– \|.*)"));
  EXPECT_THAT(line(simple), HasSubstr(" 12 |"));

  full.floor.assign(3, std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(to_markdown(full), ::testing::Not(HasSubstr("*floor*")));
}

// Every table has as many cells in each row as in its header.
TEST(Table, IsRectangular) {
  std::istringstream text(to_markdown(report()));
  std::string line;
  long columns = 0;
  int rows = 0;
  while (std::getline(text, line)) {
    if (!line.starts_with("|")) {
      columns = 0;
      continue;
    }
    const long cells = std::count(line.begin(), line.end(), '|');
    if (columns == 0) columns = cells;
    EXPECT_EQ(cells, columns) << line;
    ++rows;
  }
  EXPECT_GT(rows, 20);
}

/// Signs of a line that Markdown would take for its own, without those that \\ makes letters.
std::string bare(const std::string& line) {
  std::string left;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (line[i] == '\\')
      ++i;
    else
      left += line[i];
  return left;
}

// Whatever a label says, the tables have the same rows and cells, and no markup of its own.
TEST(Table, LabelsAreText) {
  const auto shape_of = [](const std::string& text) {
    std::istringstream lines(text);
    std::string line, shape;
    while (std::getline(lines, line)) {
      line = bare(line);
      for (const char sign : {'|', '<', '`', '[', '&', '\x1b'})
        shape += fmt::format("{} ", std::count(line.begin(), line.end(), sign));
      shape += '\n';
    }
    return shape;
  };
  const auto contest = small_contest();
  const std::string usual = shape_of(to_markdown(report())),
                    torque = shape_of(to_torque_markdown(report(), contest.robot.joints));
  for (const std::string& text : hostile_texts()) {
    SCOPED_TRACE(text);
    Evaluation hostile = report();
    hostile.scene = text;
    for (evaluate::Summary& summary : hostile.summary) summary.label = summary.budget = text;
    for (evaluate::ModelResult& model : hostile.models) model.label = text;
    EXPECT_EQ(shape_of(to_markdown(hostile)), usual);
    EXPECT_EQ(shape_of(to_torque_markdown(hostile, contest.robot.joints)), torque);
  }
}

TEST(Csv, LabelsAreCells) {
  const auto rows = [](const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  };
  for (const std::string& text : hostile_texts()) {
    Evaluation hostile = report();
    for (evaluate::ModelResult& model : hostile.models) model.label = text;
    const std::string csv = to_csv(hostile);
    EXPECT_EQ(rows(csv), rows(to_csv(report())));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '"') % 2, 0);
  }
}

TEST(Table, SaysWhenAHorizonIsMeaningless) {
  Evaluation doubtful = report();
  doubtful.meaningless[1] = "1 s: too close to the floor";
  EXPECT_THAT(to_markdown(doubtful), HasSubstr("Meaningless: 1 s: too close to the floor."));
}

TEST(Table, NamesARecordingThatDoesNotBelong) {
  EXPECT_THAT(to_markdown(report()), ::testing::Not(HasSubstr("do not belong")));
  Evaluation strange = report();
  strange.unexplained = {{"validation_1", "joint_2", "", true, 0, 9, 0.3, 20, 0.5}};
  const std::string text = to_markdown(strange);
  EXPECT_THAT(text, HasSubstr("Recordings that do not belong"));
  EXPECT_THAT(text, HasSubstr("- validation_1, joint_2: 20 N m of its torque are unexplained"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("Not to be trusted")));
}

TEST(Csv, OneRowPerRolloutAndHorizonThatExists) {
  std::istringstream text(to_csv(report()));
  std::string line;
  std::getline(text, line);
  const long columns = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  for (; std::getline(text, line); ++rows)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns) << line;
  EXPECT_EQ(rows, 3 * (2 * 3 + 6 * 2));  // models x (full rollouts x horizons + starts x horizons)
}

using Signals = TemporaryFolder;

TEST_F(Signals, OfARolloutAreWrittenAsTheyAre) {
  const evaluate::Contest contest = small_contest();
  const auto& rollout = report().models[1].rollouts[1];
  save_rollout(rollout, contest.trajectories[1], "simple", 1, folder / "rollout.h5");
  const data::H5Reader file(folder / "rollout.h5", "fricid.rollout/1");
  EXPECT_EQ(file.matrix("q"), rollout.q);
  EXPECT_EQ(file.matrix("v"), rollout.v);
  EXPECT_EQ(file.matrix("tau_f"), rollout.tau_f);
  EXPECT_EQ(file.vector("t"), contest.trajectories[1].data.t);
  EXPECT_EQ(file.unit("tau_f"), "N m");
  EXPECT_EQ(file.texts_attribute("joint_names"), contest.trajectories[1].data.joint_names);
}

TEST_F(Signals, OfABandAreWrittenAsTheyAre) {
  evaluate::Contest contest = small_contest(100);
  contest.training = contest.trajectories;
  const Evaluation with_bands = evaluate::evaluate(contest, small_options(), 1);
  EXPECT_TRUE(with_bands.summary.front().bands.empty());  // the oracle
  const evaluate::Band& band = with_bands.summary.back().bands.at(1);
  save_band(band, contest.trajectories[1].data, "lugre", folder / "band.h5");
  const data::H5Reader file(folder / "band.h5", "fricid.band/1");
  EXPECT_EQ(file.matrix("q_low"), band.low);
  EXPECT_EQ(file.matrix("q_high"), band.high);
  EXPECT_EQ(file.vector("t"), contest.trajectories[1].data.t);
}

// The artefact: read back it is what was written, to the last bit.
TEST_F(Signals, TheEvaluationSurvivesTheRoundTrip) {
  data::save(report(), folder / "evaluation.json");
  const auto read = data::load<Evaluation>(folder / "evaluation.json");
  EXPECT_EQ(data::to_json(read), data::to_json(report()));
  EXPECT_EQ(read.meaningful(), report().meaningful());
}

}  // namespace
}  // namespace fricid::test
