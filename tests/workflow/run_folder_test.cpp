// Names of a run's files, and what a restricted folder shows of them.
#include "fricid/workflow/run_folder.hpp"

#include <gmock/gmock.h>

#include "fricid/base/files.hpp"
#include "fricid/workflow/recordings.hpp"
#include "temporary_folder.hpp"

namespace fricid::workflow {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(FitId, IsParsedAsItIsNamed) {
  for (const FitId& id : {FitId{"lugre", 1}, FitId{"a_s2", 30}, FitId{"x_", 0}, FitId{"_s1", 2}}) {
    EXPECT_EQ(FitId::parse(id.name()), id) << id.name();
  }
  EXPECT_EQ((FitId{"lugre", 12}.name()), "lugre_s12");
  EXPECT_EQ(FitId::parse("a_s2_s3"), (FitId{"a_s2", 3}));
}

TEST(FitId, OtherNamesAreNone) {
  for (const char* name :
       {"", "lugre", "lugre_s", "_s1", "lugre_s01", "lugre_s1x", "lugre_s 1", "lugre_s+1",
        "lugre_s-1", "lugre_s1.5", "lugre_s99999999999", "lugre_S1"})
    EXPECT_FALSE(FitId::parse(name)) << name;
}

class RunFolderTest : public TemporaryFolder {
 protected:
  const RunFolder run{folder};
  const FitId fit{"lugre", 1};

  void touch(const std::filesystem::path& file) const { write_file_atomically(file, "x"); }
};

TEST_F(RunFolderTest, NamesFilesRelativeToItself) {
  EXPECT_EQ(run.name_of(run.scene()), "scene.toml");
  EXPECT_EQ(run.name_of(run.recording(RunFolder::training(3))), "data/train_3.h5");
  EXPECT_EQ(run.name_of(run.rollout(fit, "validation_0")), "rollouts/lugre_s1_validation_0.h5");
  EXPECT_EQ(run.name_of(run.band(fit.model, "validation_0")), "bands/lugre_validation_0.h5");
  EXPECT_EQ(run.name_of(run.plot("tracking", "svg")), "plots/tracking.svg");
}

TEST_F(RunFolderTest, TwoThingsNeverShareAFile) {
  const std::string recording = "validation_0";
  std::set<std::filesystem::path> files;
  const std::vector<std::filesystem::path> named{run.scene(),
                                                 run.manifest(),
                                                 run.lock(),
                                                 run.recording(recording),
                                                 run.diagnosis(recording),
                                                 run.truth(recording),
                                                 run.excitation(),
                                                 run.model(fit),
                                                 run.fit(fit),
                                                 run.checkpoint(fit),
                                                 run.evaluation(),
                                                 run.table(),
                                                 run.table_csv(),
                                                 run.torque_table(),
                                                 run.starts(),
                                                 run.rollout(fit, recording),
                                                 run.prediction(fit, recording),
                                                 run.estimate(fit, recording),
                                                 run.band(fit.model, recording),
                                                 run.plot("a", "svg"),
                                                 run.video("a"),
                                                 run.report()};
  files.insert(named.begin(), named.end());
  EXPECT_EQ(files.size(), named.size());
}

TEST_F(RunFolderTest, RestrictedItShowsNothingElse) {
  const RunFolder restricted = run.restricted_to({"evaluation.json", "models/lugre_s1.json"});
  EXPECT_EQ(restricted.path(), run.path());
  EXPECT_EQ(restricted.evaluation(), run.evaluation());
  EXPECT_EQ(restricted.model(fit), run.model(fit));
  for (const auto& hidden :
       {restricted.scene(), restricted.model({"lugre", 2}), restricted.fit(fit),
        restricted.recording("train_0"), restricted.diagnosis("train_0"),
        restricted.truth("train_0"), restricted.excitation(), restricted.table(),
        restricted.table_csv(), restricted.torque_table(), restricted.starts(),
        restricted.rollout(fit, "validation_0"), restricted.prediction(fit, "validation_0"),
        restricted.estimate(fit, "validation_0"), restricted.band("lugre", "validation_0")})
    EXPECT_THAT(hidden.string(), testing::HasSubstr("(not in manifest.json)"));
  // what is hidden stays so
  const RunFolder further = restricted.restricted_to({"scene.toml", "evaluation.json"});
  EXPECT_EQ(further.scene(), run.path() / "(not in manifest.json)/scene.toml");
  EXPECT_FALSE(is_there(further.model(fit)));
  EXPECT_EQ(further.evaluation(), run.evaluation());
  EXPECT_EQ(run.scene(), folder / "scene.toml");  // the folder itself is unchanged
}

TEST_F(RunFolderTest, ListsTheFilesThatItShows) {
  for (const char* name : {"b", "a"}) touch(run.plot(name, "svg"));
  touch(run.plot("a", "gp"));
  EXPECT_THAT(run.files_in(run.plots(), ".svg"),
              ElementsAre(run.plot("a", "svg"), run.plot("b", "svg")));
  EXPECT_THAT(run.restricted_to({"plots/b.svg"}).files_in(run.plots(), ".svg"),
              ElementsAre(run.plot("b", "svg")));
  EXPECT_THAT(run.files_in(run.videos(), ".mp4"), IsEmpty());  // no such folder
}

TEST_F(RunFolderTest, WhatIsNotThereIsNotLoaded) {
  const auto load = [](const std::filesystem::path& file) { return read_file(file); };
  EXPECT_FALSE(if_there(run.table(), load));
  touch(run.table());
  EXPECT_EQ(if_there(run.table(), load), "x");
  EXPECT_FALSE(if_there(run.restricted_to({}).table(), load));
  EXPECT_FALSE(is_there({}));
}

TEST_F(RunFolderTest, RecordingsAreLoadedInTheirOrder) {
  data::Dataset set;
  set.joint_names = {"joint_a1"};
  set.rate_hz = 100;
  set.t = Eigen::VectorXd::LinSpaced(3, 0, 0.02);
  set.q = set.tau = data::RowMatrix::Constant(3, 1, 0.5);
  for (int i = 0; i < 11; ++i) data::save_dataset(set, run.recording(RunFolder::training(i)));
  data::save_dataset(set, run.recording(RunFolder::training(12)));  // behind a gap: another's
  const auto sets = load_recordings(run, RunFolder::training);
  ASSERT_EQ(sets.size(), 11u);
  EXPECT_EQ(sets[2].name, "train_2");
  EXPECT_EQ(sets[10].name, "train_10");
  EXPECT_THAT(load_recordings(run, RunFolder::validation), IsEmpty());
  EXPECT_EQ(load_recordings(run.restricted_to({"data/train_0.h5"}), RunFolder::training).size(),
            1u);
}

TEST(FirstSeconds, CutTheRecordingInWhichTheyEnd) {
  data::Dataset set;
  set.rate_hz = 100;
  set.t = Eigen::VectorXd::LinSpaced(100, 0, 0.99);
  set.q = set.tau = data::RowMatrix::Constant(100, 1, 0.5);
  const std::vector<data::Dataset> all(3, set);
  EXPECT_EQ(first_seconds(all, 0).size(), 3u);
  const auto some = first_seconds(all, 1.5);
  ASSERT_EQ(some.size(), 2u);
  EXPECT_EQ(some[0].length(), 100);
  EXPECT_EQ(some[1].length(), 50);
  EXPECT_EQ(some[1].q.rows(), 50);
  EXPECT_EQ(first_seconds(all, 1).size(), 1u);
  EXPECT_EQ(first_seconds(all, 10).size(), 3u);
}

}  // namespace
}  // namespace fricid::workflow
