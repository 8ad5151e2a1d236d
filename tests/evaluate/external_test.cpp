#include "fricid/evaluate/external.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "contest.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/hdf5.hpp"
#include "temporary_folder.hpp"

namespace fricid::test {
namespace {

namespace fs = std::filesystem;
using evaluate::Contest;
using evaluate::Evaluation;
using evaluate::ExternalModel;
using evaluate::Rollout;
using evaluate::Start;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

/// A folder for a model of another program over the small contest, its files to be spoilt.
class External : public TemporaryFolder {
 protected:
  const fs::path twin = folder / "twin";
  Contest contest = small_contest(400);
  evaluate::EvaluateOptions options = small_options();
  std::vector<Start> starts =
      evaluate::plan_starts(contest.trajectories, options.horizons_s, options.starts);

  void SetUp() override {
    describe(
        R"({"format": "fricid.external/1", "label": "Twin", "parameters": 5, "fit_seconds": 2})");
  }

  void describe(const std::string& text) const { write_file_atomically(twin / "model.json", text); }
  ExternalModel load() const {
    return evaluate::load_external_model(twin, contest.trajectories, starts);
  }
  const evaluate::Trajectory& trajectory_of(const Start& start) const {
    return contest.trajectories[static_cast<std::size_t>(start.trajectory)];
  }
  fs::path stem(const Start& start) const {
    return twin / fmt::format("{}_{}", trajectory_of(start).data.name, start.begin);
  }

  /// What really happened, from a planned start.
  Rollout truth(const Start& start) const {
    const evaluate::Reference& truth = *trajectory_of(start).truth;
    const auto cut = [&](const RowMatrix& all) -> RowMatrix {
      return all.middleRows(start.begin, start.steps + 1);
    };
    return {start, false, cut(truth.q), cut(truth.v), cut(truth.tau_f)};
  }
  void write_hdf5(const Rollout& rollout) const {
    save_rollout(rollout, trajectory_of(rollout.start), "twin", 1,
                 stem(rollout.start).string() + ".h5");
  }
  void write_csv(const Rollout& rollout, const std::function<void(RowMatrix&)>& spoil = {}) const {
    const Eigen::Index rows = rollout.q.rows();
    RowMatrix table(rows, 19);
    table << trajectory_of(rollout.start).data.t.segment(rollout.start.begin, rows), rollout.q,
        rollout.v, rollout.tau_f;
    if (spoil) spoil(table);
    std::string text = "t";
    for (const char* signal : {"q", "v", "tau_f"})
      for (int j = 1; j <= 6; ++j) text += fmt::format(",{}{}", signal, j);
    for (Eigen::Index k = 0; k < table.rows(); ++k)
      text += fmt::format("\n{}", fmt::join(table.row(k).begin(), table.row(k).end(), ","));
    write_file_atomically(stem(rollout.start).string() + ".csv", text + "\n");
  }
  void write_all() const {
    for (const Start& start : starts) write_hdf5(truth(start));
  }

  void refuse(const std::string& pattern) const {
    try {
      load();
      ADD_FAILURE() << "not refused: " << pattern;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), MatchesRegex(".*" + pattern));
    }
  }
};

// The oracle: the very rollouts of a model, written and read, score as the model itself does.
TEST_F(External, RolloutsOfAModelScoreAsTheModel) {
  options.starts = 0;  // rollouts from the first sample, which a report keeps
  starts = evaluate::plan_starts(contest.trajectories, options.horizons_s, options.starts);
  const Evaluation alone = evaluate::evaluate(contest, options, 1);
  const evaluate::ModelResult& lugre = alone.models.back();
  write_hdf5(lugre.rollouts[0]);
  write_csv(lugre.rollouts[1]);
  contest.externals = {load()};

  const Evaluation report = evaluate::evaluate(contest, options, 1);
  const json file = json::parse(data::to_json(report)), before = json::parse(data::to_json(alone));
  json own = before["models"].back(), answer = file["models"].back();
  for (json& score : own["trajectories"])
    for (const char* regime : {"", "_presliding", "_reversal", "_sliding"})
      score[fmt::format("friction_rmse{}", regime)] = json::array();  // driven: only a model can be
  EXPECT_EQ(answer["trajectories"], own["trajectories"]);
  EXPECT_EQ(answer["name"], "twin");
  EXPECT_EQ(answer["label"], "Twin");
  EXPECT_EQ(answer["parameters"], 5);
  EXPECT_EQ(answer["stated_fit_seconds"], 2.0);

  json own_row = before["summary"].back(), twin_row = file["summary"].back();
  for (const char* key : {"q_mse_geometric_mean", "v_mse_geometric_mean", "interval_90",
                          "ratio_to_oracle", "headroom_closed", "friction_rollout", "diverged"})
    EXPECT_EQ(twin_row[key], own_row[key]) << key;
  EXPECT_TRUE(twin_row["friction"].is_null());
  EXPECT_FALSE(twin_row["is_conventional"]);
}

TEST_F(External, ChangesNoOtherRow) {
  const json before = json::parse(data::to_json(evaluate::evaluate(contest, options, 1)));
  write_all();  // the truth itself, better than any model
  contest.externals = {load()};
  json after = json::parse(data::to_json(evaluate::evaluate(contest, options, 1)));
  EXPECT_EQ(after["summary"].back()["q_mse_mean"], (json{0.0, 0.0, 0.0}));
  after["models"].erase(after["models"].size() - 1);
  after["summary"].erase(after["summary"].size() - 1);
  EXPECT_EQ(after, before);
}

TEST_F(External, StartsSayWhatToWrite) {
  const std::string text = evaluate::starts_csv(contest.trajectories, starts);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), std::ssize(starts) + 1);
  EXPECT_THAT(text, ::testing::StartsWith(
                        "rollout,trajectory,begin,t,rows,q1,q2,q3,q4,q5,q6,v1,v2,v3,v4,v5,v6\n"));
  const Start& later = starts[1];
  ASSERT_GT(later.begin, 0);
  const evaluate::Trajectory& trajectory = trajectory_of(later);
  EXPECT_THAT(text, HasSubstr(fmt::format("\nvalidation_0_{},validation_0,{},{},{},{},",
                                          later.begin, later.begin, trajectory.data.t[later.begin],
                                          later.steps + 1, trajectory.truth->q(later.begin, 0))));
}

TEST_F(External, ADivergedRolloutIsCountedAndKept) {
  write_all();
  Rollout broken = truth(starts[1]);
  broken.q.bottomRows(50).setConstant(kNan);
  broken.v.bottomRows(50).setConstant(kNan);
  broken.tau_f.bottomRows(50).setConstant(kNan);
  write_hdf5(broken);
  contest.externals = {load()};
  const Evaluation report = evaluate::evaluate(contest, options, 1);
  EXPECT_EQ(report.summary.back().diverged, 1);
  EXPECT_EQ(report.summary.back().rollouts, std::ssize(starts));
  for (const double mse : report.models.back().scores[1].error.q_mse_joint[1])
    EXPECT_GT(mse, 0);  // it stands still where it was last
}

TEST_F(External, NaNInTextIsDivergenceToo) {
  write_all();
  fs::remove(stem(starts[0]).string() + ".h5");
  write_csv(truth(starts[0]),
            [](RowMatrix& table) { table.row(60).rightCols(18).setConstant(kNan); });
  contest.externals = {load()};
  EXPECT_EQ(evaluate::evaluate(contest, options, 1).summary.back().diverged, 1);
}

TEST_F(External, FrictionTorqueMayBeLeftOut) {
  options.starts = 0;
  starts = evaluate::plan_starts(contest.trajectories, options.horizons_s, options.starts);
  Rollout blind = truth(starts[0]);
  blind.tau_f.resize(0, 0);
  write_hdf5(blind);
  std::string text = "t,q1,q2,q3,q4,q5,q6,v1,v2,v3,v4,v5,v6\n";
  const Rollout seen = truth(starts[1]);
  for (Eigen::Index k = 0; k < seen.q.rows(); ++k)
    text += fmt::format("{},{},{}\n", trajectory_of(starts[1]).data.t[k],
                        fmt::join(seen.q.row(k).begin(), seen.q.row(k).end(), ","),
                        fmt::join(seen.v.row(k).begin(), seen.v.row(k).end(), ","));
  write_file_atomically(stem(starts[1]).string() + ".csv", text);

  contest.externals = {load()};
  const Evaluation report = evaluate::evaluate(contest, options, 1);
  EXPECT_EQ(report.summary.back().q_mse_mean, (std::vector<double>{0, 0, 0}));
  EXPECT_TRUE(std::isnan(report.summary.back().friction_rollout));
  save_rollout(report.models.back().rollouts[0], contest.trajectories[0], "twin", 1,
               folder / "rollout.h5");
  const data::H5Reader saved(folder / "rollout.h5", "fricid.rollout/1");
  EXPECT_EQ(saved.matrix("q"), truth(starts[0]).q);
  EXPECT_FALSE(saved.has("tau_f"));
}

TEST_F(External, OfALogStartAndScoreAreWhatWasMeasured) {
  contest.models.erase(contest.models.begin());  // the oracle
  for (evaluate::Trajectory& trajectory : contest.trajectories) trajectory.truth.reset();
  for (const Start& start : starts) {
    const evaluate::Trajectory& log = trajectory_of(start);
    write_hdf5({start,
                false,
                log.data.q.middleRows(start.begin, start.steps + 1),
                log.v.middleRows(start.begin, start.steps + 1),
                {}});
  }
  contest.externals = {load()};
  const evaluate::Summary row = evaluate::evaluate(contest, options, 1).summary.back();
  EXPECT_EQ(row.q_mse_mean, (std::vector<double>{0, 0, 0}));
  EXPECT_TRUE(std::isnan(row.friction_rollout));
}

TEST_F(External, MissingRolloutIsNamed) {
  write_all();
  fs::remove(stem(starts[2]).string() + ".h5");
  refuse(stem(starts[2]).filename().string() +
         R"(\.csv: no such file, nor .*\.h5; allowed: one rollout per line of starts\.csv)");
}

TEST_F(External, OneRolloutInTwoFilesIsRefused) {
  write_all();
  write_csv(truth(starts[0]));
  refuse(R"(validation_0_0\.csv: found beside validation_0_0\.h5; allowed: one of them)");
}

TEST_F(External, TornFileIsRefused) {
  write_all();
  const fs::path path = stem(starts[0]).string() + ".h5";
  fs::resize_file(path, fs::file_size(path) / 2);
  refuse(R"(validation_0_0\.h5: .*torn.*)");
}

class ExternalText : public External {
 protected:
  void refuse_first(const std::function<void(RowMatrix&)>& spoil, const std::string& pattern) {
    write_all();
    fs::remove(stem(starts[0]).string() + ".h5");
    write_csv(truth(starts[0]), spoil);
    refuse(R"(validation_0_0\.csv)" + pattern);
  }
};

TEST_F(ExternalText, TooShort) {
  refuse_first([](RowMatrix& table) { table.conservativeResize(300, Eigen::NoChange); },
               ":301: 300 rows; allowed: 400, as starts.csv says");
}

TEST_F(ExternalText, TooLong) {
  refuse_first(
      [](RowMatrix& table) {
        table.conservativeResize(401, Eigen::NoChange);
        table.row(400) = table.row(399);
      },
      ":402: 401 rows; allowed: 400, as starts.csv says");
}

TEST_F(ExternalText, Empty) {
  refuse_first([](RowMatrix& table) { table.conservativeResize(0, Eigen::NoChange); },
               ": 0 rows; allowed: 400, as starts.csv says");
}

TEST_F(ExternalText, WrongStart) {
  refuse_first([](RowMatrix& table) { table(0, 3) += 1e-4; },
               ":2: q3 = .*; allowed: .*, where starts.csv says to start");
  refuse_first([](RowMatrix& table) { table(0, 7) = kNan; },
               ":2: v1 = nan; allowed: .*, where starts.csv says to start");
}

TEST_F(ExternalText, StartAsRoundedByATextFileIsTaken) {
  write_all();
  fs::remove(stem(starts[0]).string() + ".h5");
  write_csv(truth(starts[0]), [](RowMatrix& table) { table(0, 3) += 4e-7; });
  EXPECT_EQ(load().rollouts.size(), starts.size());
}

TEST_F(ExternalText, WrongTime) {
  refuse_first([](RowMatrix& table) { table.col(0) *= 2; },
               ":3: t = 0.008 s; allowed: 0.004, as in validation_0");
  refuse_first([](RowMatrix& table) { table(9, 0) = kNan; },
               ":11: t = nan s; allowed: 0.036, as in validation_0");
}

TEST_F(ExternalText, FrictionTorqueIsMissing) {
  refuse_first([](RowMatrix& table) { table(6, 18) = kNan; },
               ":8: tau_f6 = nan; allowed: a number");
}

class ExternalDescription : public External {
 protected:
  void refuse_text(const std::string& text, const std::string& pattern) {
    write_all();
    describe(text);
    refuse(R"(twin/model\.json)" + pattern);
  }
};

TEST_F(ExternalDescription, Missing) {
  write_all();
  fs::remove(twin / "model.json");
  refuse(R"(twin/model\.json: .*)");
}

TEST_F(ExternalDescription, NotJson) {
  refuse_text("{\n\"format\": 1,\n oops}", ":3: not JSON, or torn: invalid literal oops");
  refuse_text("[]", ": found no object; allowed keys: format, label, parameters, fit_seconds");
}

TEST_F(ExternalDescription, UnknownKey) {
  refuse_text("{\"format\": \"fricid.external/1\",\n\"parameter\": 3}",
              R"(:2: unknown key "parameter"; allowed: format, label, parameters, fit_seconds)");
}

TEST_F(ExternalDescription, WrongValues) {
  const std::string head = "{\"format\": \"fricid.external/1\",\n";
  refuse_text("{}", R"(: format = nothing; allowed: "fricid\.external/1")");
  refuse_text("{\"format\": \"fricid.external/2\"}",
              R"(:1: format = "fricid\.external/2"; allowed: "fricid\.external/1")");
  refuse_text(head + "\"label\": \"\"}", R"(:2: label = ""; allowed: a line of text)");
  refuse_text(head + "\"label\": [\"a\"]}", ":2: label = a list; allowed: a line of text");
  refuse_text(head + "\"label\": " + std::string(100'000, '[') + std::string(100'000, ']') + "}",
              ": 33 levels of lists and objects in a JSON file; allowed: up to 32");
  refuse_text(head + "\"label\": \"a\", \"parameters\": -1}",
              ":2: parameters = -1; allowed: a whole number from 0 to 1e9");
  refuse_text(head + "\"label\": \"a\", \"parameters\": 1}",
              R"(: fit_seconds = nothing; allowed: 0 or more \[s\])");
  refuse_text(head + "\"label\": \"a\", \"parameters\": 1, \"fit_seconds\": \"3\"}",
              R"(:2: fit_seconds = "3"; allowed: 0 or more \[s\])");
}

}  // namespace
}  // namespace fricid::test
