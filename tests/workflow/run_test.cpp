// A run folder at work: what is done again, what is kept, what is refused.
#include "fricid/workflow/run.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "temporary_folder.hpp"

namespace fricid::workflow {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RunTest : public TemporaryFolder {
 protected:
  const fs::path place = folder / "run";
  int done = 0;

  /// A stage that reads a text and writes it into files.
  Stage copying(const workflow::Run& run, const std::string& text,
                std::vector<std::string> names = {"a.txt"}) {
    Stage stage{"copy", Inputs(run.folder()), {}};
    stage.inputs.text("text", text);
    stage.work = [=, this, out = run.folder().path()](const RunFolder&) {
      ++done;
      Done made;
      for (const std::string& name : names) {
        write_file_atomically(out / name, text);
        made.files.push_back(out / name);
      }
      return made;
    };
    return stage;
  }

  std::string refusal(const fs::path& path) const {
    try {
      workflow::Run::open(path, false);
    } catch (const UserError& error) {
      return error.what();
    }
    return "not refused";
  }
};

TEST_F(RunTest, AStageIsDoneOnceUntilItsInputsChange) {
  {
    workflow::Run run = workflow::Run::open(place, false);
    EXPECT_TRUE(run.perform(copying(run, "one")));
    EXPECT_FALSE(run.perform(copying(run, "one")));
  }
  workflow::Run again = workflow::Run::open(place, false);
  EXPECT_FALSE(again.perform(copying(again, "one")));
  EXPECT_TRUE(again.perform(copying(again, "two")));
  EXPECT_EQ(read_file(place / "a.txt"), "two");
  EXPECT_EQ(done, 2);
}

TEST_F(RunTest, AChangedOrLostOutputIsMadeAgain) {
  workflow::Run run = workflow::Run::open(place, false);
  run.perform(copying(run, "one"));
  std::ofstream(place / "a.txt") << "damaged";
  EXPECT_FALSE(run.intact("copy"));
  EXPECT_TRUE(run.perform(copying(run, "one")));
  EXPECT_EQ(read_file(place / "a.txt"), "one");
  fs::remove(place / "a.txt");
  EXPECT_TRUE(run.perform(copying(run, "one")));
  EXPECT_TRUE(run.intact("copy"));
}

TEST_F(RunTest, FreshDoesAllAnew) {
  {
    workflow::Run run = workflow::Run::open(place, false);
    run.perform(copying(run, "one"));
  }
  workflow::Run fresh = workflow::Run::open(place, true);
  EXPECT_TRUE(fresh.perform(copying(fresh, "one")));
}

TEST_F(RunTest, OutputsThatAreNoLongerWrittenGoUnlessSomebodyChangedThem) {
  workflow::Run run = workflow::Run::open(place, false);
  run.perform(copying(run, "one", {"a.txt", "b.txt", "c.txt"}));
  std::ofstream(place / "c.txt") << "mine now";
  run.perform(copying(run, "two", {"a.txt"}));
  EXPECT_TRUE(fs::exists(place / "a.txt"));
  EXPECT_FALSE(fs::exists(place / "b.txt"));
  EXPECT_EQ(read_file(place / "c.txt"), "mine now");
}

// A stage sees what it declared: for it, the other files of the run are not there.
TEST_F(RunTest, AStageSeesNoFileThatItDidNotDeclare) {
  workflow::Run run = workflow::Run::open(place, false);
  run.perform(copying(run, "one", {"data/train_0.h5", "data/validation_0.h5", "table.md"}));
  Stage reader{"read", Inputs(run.folder()), {}};
  reader.inputs.outputs_of(run.results_of("copy"), "data/train_");
  fs::path seen, hidden, table;
  reader.work = [&](const RunFolder& visible) {
    seen = visible.recording(RunFolder::training(0));
    hidden = visible.recording(RunFolder::validation(0));
    table = visible.table();
    return Done{};
  };
  run.perform(reader);
  EXPECT_EQ(seen, place / "data/train_0.h5");
  EXPECT_EQ(hidden, place / "(not in manifest.json)/data/validation_0.h5");
  EXPECT_EQ(table, place / "(not in manifest.json)/table.md");
}

TEST_F(RunTest, TheManifestSaysWhatAStageReadAndWrote) {
  workflow::Run run = workflow::Run::open(place, false);
  run.perform(copying(run, "one"));
  const StageRecord& record = run.results_of("copy");
  ASSERT_EQ(record.inputs.size(), 1u);
  EXPECT_EQ(record.inputs[0].name, "text");
  EXPECT_EQ(record.inputs[0].sha256, sha256_of_text("one"));
  ASSERT_EQ(record.outputs.size(), 1u);
  EXPECT_EQ(record.outputs[0].name, "a.txt");
  EXPECT_THAT(run.changed(copying(run, "one")), testing::IsEmpty());
  EXPECT_THAT(run.changed(copying(run, "two")), testing::ElementsAre("text"));
  EXPECT_THROW(run.results_of("other"), UserError);
}

// What others wrote is read only as they wrote it.
TEST_F(RunTest, RefusesResultsThatWereEdited) {
  {
    workflow::Run run = workflow::Run::open(place, false);
    run.perform(copying(run, "one"));
  }
  std::ofstream(place / "a.txt") << "edited";
  const workflow::Run run = workflow::Run::open(place, false);
  EXPECT_THROW(run.results_of("copy"), UserError);
}

TEST_F(RunTest, RefusesResultsThatWereMadeFromOtherFiles) {
  workflow::Run run = workflow::Run::open(place, false);
  run.perform(copying(run, "one", {"data/train_0.h5"}));
  Stage fit{"fit", Inputs(run.folder()), [](const RunFolder&) { return Done{}; }};
  fit.inputs.outputs_of(run.results_of("copy"));
  run.perform(fit);
  EXPECT_NO_THROW(run.results_of("fit"));
  const auto refused = [&](const std::string& changed) {
    try {
      run.results_of("fit");
      return std::string("not refused");
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), HasSubstr("fit was done with another " + changed));
      return std::string();
    }
  };
  run.perform(copying(run, "two", {"data/train_0.h5"}));
  EXPECT_EQ(refused("data/train_0.h5;"), "");
  run.perform(copying(run, "one", {"data/train_0.h5", "data/train_1.h5"}));
  EXPECT_EQ(refused("data/train_1.h5;"), "");
  run.perform(copying(run, "three", {"a.txt"}));
  EXPECT_EQ(refused("data/train_0.h5;"), "");
  run.perform(copying(run, "one", {"data/train_0.h5"}));
  EXPECT_NO_THROW(run.results_of("fit"));
}

TEST_F(RunTest, AFolderInWhichNothingWasDoneIsRemoved) {
  { const workflow::Run run = workflow::Run::open(place, false); }
  EXPECT_FALSE(fs::exists(place));
}

TEST_F(RunTest, AFolderInWhichAStageWasCutShortIsThatOfARun) {
  {
    workflow::Run run = workflow::Run::open(place, false);
    run.describe([](Manifest&) {});
    Stage stage = copying(run, "one");
    const auto copy = stage.work;
    stage.work = [copy](const RunFolder& visible) -> Done {
      copy(visible);
      throw UserError("the disk is full");
    };
    EXPECT_THROW(run.perform(stage), UserError);
  }
  workflow::Run again = workflow::Run::open(place, false);
  EXPECT_TRUE(again.perform(copying(again, "one")));
}

TEST_F(RunTest, TakesAnEmptyFolder) {
  fs::create_directories(place);
  workflow::Run run = workflow::Run::open(place, false);
  EXPECT_TRUE(run.perform(copying(run, "one")));
}

TEST_F(RunTest, RefusesAFolderThatNoRunMade) {
  fs::create_directories(place / "data");
  std::ofstream(place / "data/train_0.h5") << "somebody's";
  EXPECT_THAT(refusal(place), HasSubstr("found data and no manifest.json"));
  EXPECT_EQ(read_file(place / "data/train_0.h5"), "somebody's");
  std::ofstream(folder / "file") << "text";
  EXPECT_THAT(refusal(folder / "file"), HasSubstr("found a file"));
}

TEST_F(RunTest, RefusesALinkThatLeadsOut) {
  {
    workflow::Run run = workflow::Run::open(place, false);
    run.perform(copying(run, "one"));
  }
  std::ofstream(folder / "precious") << "precious";
  fs::create_symlink(folder / "precious", place / "table.md");
  EXPECT_THAT(refusal(place), HasSubstr("table.md: found a symbolic link"));
  fs::remove(place / "table.md");
  fs::create_directory_symlink(folder, place / "data");
  EXPECT_THAT(refusal(place), HasSubstr("data: found a symbolic link"));
}

TEST_F(RunTest, RefusesTheManifestOfAnEarlierVersionAndADamagedOne) {
  {
    workflow::Run run = workflow::Run::open(place, false);
    run.perform(copying(run, "one"));
  }
  std::ofstream(place / "manifest.json") << R"({"format": "fricid.manifest/1", "stages": {}})";
  EXPECT_THAT(refusal(place), HasSubstr("made by an earlier version of fricid"));
  std::ofstream(place / "manifest.json") << "{";
  EXPECT_THAT(refusal(place), HasSubstr("manifest.json:1: not JSON, or torn"));
}

// What it says it wrote, it might remove.
TEST_F(RunTest, RefusesAManifestWhoseOutputsLieOutside) {
  for (const char* outside : {"../x", "/etc/passwd", "a/../../x", "", "./a"}) {
    Manifest manifest;
    manifest.at("copy").outputs = {{outside, std::string(64, '0')}};
    EXPECT_THROW(manifest.check("manifest.json"), UserError) << outside;
  }
}

TEST_F(RunTest, DoesAgainWhatAnAlteredRecordSaysWasDone) {
  {
    workflow::Run run = workflow::Run::open(place, false);
    run.perform(copying(run, "one"));
  }
  const auto done_again_with = [&](auto change) {
    auto manifest = data::load<Manifest>(place / "manifest.json");
    change(manifest.stages.front());
    data::save(manifest, place / "manifest.json");
    workflow::Run run = workflow::Run::open(place, false);
    return run.perform(copying(run, "one"));
  };
  EXPECT_FALSE(done_again_with([](StageRecord&) {}));
  EXPECT_TRUE(done_again_with([](StageRecord& record) { record.outputs.clear(); }));
  EXPECT_TRUE(done_again_with([](StageRecord& record) { record.seal.reset(); }));
}

TEST_F(RunTest, RefusesAManifestThatNamesAStageOrAnOutputTwice) {
  const Content model{"models/a_s1.json", std::string(64, '0')};
  Manifest of_one, of_two, of_stages;
  of_one.at("identify a_s1").outputs = {model, model};
  for (const char* stage : {"identify a_s1", "identify a_s2"}) of_two.at(stage).outputs = {model};
  of_stages.at("data");
  of_stages.stages.push_back(of_stages.stages.front());
  for (const Manifest& manifest : {of_one, of_two, of_stages})
    EXPECT_THROW(manifest.check("manifest.json"), UserError);
}

TEST(Inputs, TwoOfOneNameAreAMistakeOfTheProgram) {
  Inputs inputs{RunFolder("run")};
  inputs.text("a", "1");
  inputs.text("a", "2");
  EXPECT_THROW(inputs.contents(), std::logic_error);
}

}  // namespace
}  // namespace fricid::workflow
