#include "stage.hpp"

#include <gtest/gtest.h>

#include "film_fixture.hpp"
#include "fricid/base/error.hpp"
#include "fricid/workflow/manifest.hpp"
#include "source_dir.hpp"

namespace fricid::viewer {
namespace {

/// A run folder as the viewer finds it.
class StageTest : public film::FilmFolder {
 protected:
  void SetUp() override {
    FilmFolder::SetUp();
    data::save(workflow::Manifest(), run.manifest());
    write_file_atomically(run.scene(), scene::to_toml(problem().scene));
  }
  Stage stage() const { return make_stage(folder); }
};

TEST_F(StageTest, ARunFolderIsReplayed) {
  Stage shown = stage();
  EXPECT_EQ(shown.mode, Mode::kReplay);
  EXPECT_EQ(shown.film->models.size(), 3u);
  shown.advance(0.5);
  EXPECT_NEAR(shown.t, 0.5, 1e-12);
  shown.speed = 2;
  shown.advance(0.5);
  EXPECT_NEAR(shown.t, 1.5, 1e-12);
  shown.playing = false;
  shown.advance(1);
  EXPECT_NEAR(shown.t, 1.5, 1e-12);
  shown.seek(99);
  EXPECT_EQ(shown.row(), kRows - 1);
}

TEST_F(StageTest, ASceneIsLive) {
  Stage shown = make_stage(source_dir() / "scenes/kr6_lugre.toml");
  EXPECT_EQ(shown.mode, Mode::kLive);
  EXPECT_FALSE(shown.film);
  shown.advance(0.05);
  EXPECT_NEAR(shown.live->time(), 0.048, 1e-9);
}

TEST_F(StageTest, ALiveArmSwingsUntilItIsPushed) {
  Stage shown = make_stage(source_dir() / "scenes/kr6_lugre.toml");
  obey(shown, "run 2");
  const auto speeds = [&] {
    return Eigen::Map<const Eigen::VectorXd>(
        shown.live->state().v.data(), static_cast<Eigen::Index>(shown.live->state().v.size()));
  };
  EXPECT_GT(speeds().cwiseAbs().maxCoeff(), 0.1);
  EXPECT_TRUE(shown.cloud());
  obey(shown, "push 0");
  obey(shown, "run 3");
  EXPECT_LT(speeds().cwiseAbs().maxCoeff(), 1e-2);
  obey(shown, "swing");
  obey(shown, "run 2");
  EXPECT_GT(speeds().cwiseAbs().maxCoeff(), 0.1);
}

TEST_F(StageTest, CommandsDoWhatTheySay) {
  Stage shown = stage();
  obey(shown, "seek 1.25");
  EXPECT_NEAR(shown.t, 1.25, 1e-12);
  obey(shown, "toggle gms");
  EXPECT_FALSE(shown.visible[2]);
  obey(shown, "joint joint_a5");
  EXPECT_EQ(shown.joint, 4);
  obey(shown, "age 0.25");
  EXPECT_EQ(shown.cloud_age, 0.25);
  obey(shown, "live");
  obey(shown, "push 2 3 0.5");
  EXPECT_EQ(shown.live->push.joint, 4);
  EXPECT_EQ(shown.live->push.amplitude, 3);
  obey(shown, "run 0.4");
  EXPECT_NEAR(shown.live->time(), 0.4, 1e-9);
  obey(shown, "pause");
  EXPECT_FALSE(shown.playing);
  EXPECT_EQ(obey(shown, "shot a.png").shot, "a.png");
  EXPECT_EQ(obey(shown, "fps 2.5").race, 2.5);
  EXPECT_TRUE(obey(shown, "# a remark").shot.empty());
}

TEST_F(StageTest, TheCloudIsOfTheFirstVisibleModelWithMemory) {
  Stage shown = stage();  // simple, lugre or dahl, gms
  obey(shown, "seek 1");
  ASSERT_TRUE(shown.cloud());
  EXPECT_NE(shown.cloud()->label, "simple");
  obey(shown, "toggle " + shown.cloud()->label);
  ASSERT_TRUE(shown.cloud());
  EXPECT_EQ(shown.cloud()->label, "gms");
  EXPECT_EQ(shown.cloud()->cloud.to.cols(), 2);
  obey(shown, "toggle gms");
  EXPECT_FALSE(shown.cloud());  // no visible model with memory
}

TEST_F(StageTest, AModelThatIsRolloutsAloneHasNoCloud) {
  std::filesystem::remove(run.model({"gms", 1}));
  Stage shown = stage();
  obey(shown, "seek 1");
  ASSERT_TRUE(shown.cloud());
  obey(shown, "toggle " + shown.cloud()->label);
  EXPECT_FALSE(shown.cloud());
}

TEST_F(StageTest, TheCloudIsNoOlderThanItsMotion) {
  Stage shown = stage();
  obey(shown, "age 0.5");
  obey(shown, "seek 0.2");
  EXPECT_NEAR(shown.cloud()->age, 0.2, 1e-12);
  obey(shown, "live");
  EXPECT_FALSE(shown.cloud());  // nothing has moved yet
  obey(shown, "run 0.1");
  ASSERT_TRUE(shown.cloud());
  EXPECT_LT(shown.cloud()->age, 0.11);
}

TEST_F(StageTest, TheLiveCloudSurroundsTheLiveState) {
  Stage shown = make_stage(source_dir() / "scenes/kr6_lugre.toml");
  obey(shown, "joint joint_a2");
  obey(shown, "push 0 40 1");
  obey(shown, "run 1.3");
  const LatentCloud cloud = shown.cloud()->cloud;
  const auto begin = shown.live->friction().model.state_begin(1);
  EXPECT_EQ(cloud.state[0], shown.live->history().back().z[static_cast<std::size_t>(begin)]);
  const double rounding = 1e-12 * std::abs(cloud.state[0]);
  EXPECT_LE(cloud.to.minCoeff(), cloud.state[0] + rounding);
  EXPECT_GE(cloud.to.maxCoeff(), cloud.state[0] - rounding);
}

TEST_F(StageTest, WrongCommandsAreNamed) {
  Stage shown = stage();
  for (const char* wrong :
       {"jump", "seek", "seek now", "toggle nobody", "joint a9", "set Fq 3", "shot"})
    EXPECT_THROW(obey(shown, wrong), UserError) << wrong;
}

TEST_F(StageTest, ASavedSceneHasTheFrictionOfTheSliders) {
  Stage shown = make_stage(source_dir() / "scenes/kr6_lugre.toml");
  obey(shown, "joint joint_a2");
  obey(shown, "set Fc 7.5");
  obey(shown, "scene " + (folder / "edited.toml").string());
  const scene::Scene saved = scene::load_scene(folder / "edited.toml");
  EXPECT_EQ(saved.friction->theta, shown.live->friction().theta);
  EXPECT_NE(saved.friction->theta, shown.problem.scene.friction->theta);
}

TEST_F(StageTest, WhatCannotBeShownIsRefused) {
  EXPECT_THROW(make_stage(folder / "nothing.toml"), UserError);
}

}  // namespace
}  // namespace fricid::viewer
