#include "fricid/workflow/manifest.hpp"

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "temporary_folder.hpp"

namespace fricid::workflow {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

std::string said_of(const Manifest& manifest) {
  try {
    manifest.check("m.json");
  } catch (const UserError& error) {
    return error.what();
  }
  return "no error";
}

Manifest with_output(const std::string& name) {
  Manifest manifest;
  manifest.at("data").outputs = {{name, "hash"}};
  return manifest;
}

TEST(ManifestTest, OutputsLieBelowTheRunFolder) {
  for (const char* inside : {"evaluation.json", "data/train_0.h5", "a/b/c", "..a", "a..b/c"})
    EXPECT_EQ(said_of(with_output(inside)), "no error") << inside;
  for (const char* outside : {"", "/etc/passwd", "..", "../other", "a/../../b", "a/..", "./a",
                              "data//train_0.h5", "data/./a", ".", "data/"})
    EXPECT_THAT(said_of(with_output(outside)), HasSubstr("m.json: output " + std::string(outside) +
                                                         "; allowed: a file below the run folder"))
        << outside;
}

TEST(ManifestTest, MessagesAndTextsShow) {
  EXPECT_THAT(said_of(with_output("../\x1b[31m\n")), HasSubstr("../\\x1b[31m\\n"));
  for (std::string Manifest::*text : {&Manifest::version, &Manifest::commit, &Manifest::scene}) {
    Manifest manifest;
    manifest.*text = "a\nb";
    EXPECT_NE(said_of(manifest), "no error");
  }
  Manifest manifest;
  manifest.machine.cpu = "\x1b[31m";
  EXPECT_NE(said_of(manifest), "no error");
  manifest = {};
  manifest.fitted_by_name = {"a\tb"};
  EXPECT_NE(said_of(manifest), "no error");
  manifest = {};
  manifest.at("a\nb");
  EXPECT_NE(said_of(manifest), "no error");
}

TEST(ManifestTest, StagesAreFoundOrMade) {
  Manifest manifest;
  EXPECT_EQ(manifest.find("data"), nullptr);
  manifest.at("data").seconds = 3;
  manifest.at("evaluate");
  EXPECT_EQ(manifest.at("data").seconds, 3);
  EXPECT_EQ(manifest.stages.size(), 2u);
  ASSERT_NE(manifest.find("data"), nullptr);
  EXPECT_EQ(manifest.find("data")->seconds, 3);
}

TEST(ManifestTest, StagesOfFitsAreToldByTheirName) {
  EXPECT_EQ(stage_of({"lugre", 2}), "identify lugre_s2");
  EXPECT_EQ(fit_of("identify lugre_s2"), (FitId{"lugre", 2}));
  for (const char* other : {"data", "identify", "identify lugre", "lugre_s2"})
    EXPECT_FALSE(fit_of(other)) << other;
}

TEST(ManifestTest, SecondsOfAModelAreTheMeanOverItsFits) {
  Manifest manifest;
  manifest.at("data").seconds = 100;
  manifest.at(stage_of({"lugre", 1})).seconds = 2;
  manifest.at(stage_of({"lugre", 2})).seconds = 3;
  manifest.at(stage_of({"dahl", 1})).seconds = 7;
  EXPECT_THAT(fit_seconds(manifest), ElementsAre(Pair("dahl", 7), Pair("lugre", 2.5)));
}

// Runs that differ in their seeds alone are comparable.
TEST(ManifestTest, TheKeyOfAProblemIsThatOfItsData) {
  const auto key = [](const std::string& seed, const std::string& urdf, const std::string& identify,
                      const std::string& model) {
    Manifest manifest;
    manifest.at("data").inputs = {
        {"URDF", urdf}, {"scene [robot]", "r"}, {"scene name", seed + "n"}, {"scene seed", seed}};
    manifest.at("data").outputs = {{"data/train_0.h5", seed + urdf}};
    manifest.at("evaluate").inputs = {{"data/train_0.h5", seed + urdf},
                                      {"scene [evaluate]", seed},
                                      {"scene [identify]", identify}};
    manifest.at(stage_of({"lvm", 1})).inputs = {{"scene [[model]]", model}};
    EXPECT_THAT(fit_keys(manifest), ElementsAre(Pair("lvm_s1", model)));
    return problem_key(manifest);
  };
  EXPECT_EQ(key("1", "u", "i", "m"), key("2", "u", "i", "n"));
  EXPECT_NE(key("1", "u", "i", "m"), key("1", "v", "i", "m"));
  EXPECT_NE(key("1", "u", "i", "m"), key("1", "u", "j", "m"));
  EXPECT_EQ(problem_key({}), "");
}

using ManifestFile = TemporaryFolder;

TEST_F(ManifestFile, ComesBackAsItWas) {
  Manifest manifest = with_output("data/train_0.h5");
  manifest.version = "1";
  manifest.machine = {"a cpu", 4};
  manifest.scene = "demo";
  manifest.seed = 9'000'000'000'000'000;
  manifest.sources = {{"robot.urdf", "absent"}};
  manifest.fitted_by_name = {"lugre_s1"};
  manifest.at("data").inputs = {{"scene", "hash"}};
  manifest.at("data").seconds = 0.1;
  data::save(manifest, folder / "manifest.json");
  const auto read = data::load<Manifest>(folder / "manifest.json");
  EXPECT_EQ(data::to_json(read), data::to_json(manifest));
  EXPECT_EQ(read.find("data")->outputs, manifest.stages[0].outputs);
  EXPECT_EQ(read.seed, manifest.seed);
}

TEST_F(ManifestFile, OneThatLeadsOutOfTheFolderIsNotRead) {
  data::save(with_output("../evil"), folder / "manifest.json");
  EXPECT_THROW(data::load<Manifest>(folder / "manifest.json"), UserError);
}

}  // namespace
}  // namespace fricid::workflow
