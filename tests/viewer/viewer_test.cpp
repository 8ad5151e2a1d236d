#include "fricid/viewer/viewer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "film_fixture.hpp"
#include "fricid/base/error.hpp"
#include "fricid/film/image.hpp"
#include "fricid/workflow/manifest.hpp"

namespace fricid::viewer {
namespace {

using film::Image;
using film::load_png;
using film::share_differing;
using ::testing::MatchesRegex;

class ViewerTest : public film::FilmFolder {
 protected:
  void SetUp() override {
    FilmFolder::SetUp();
    data::save(workflow::Manifest(), run.manifest());
    write_file_atomically(run.scene(), scene::to_toml(problem().scene));
  }
  std::string png(const std::string& name) const { return (folder / (name + ".png")).string(); }

  ViewerOptions script(const std::string& commands) const {
    write_file_atomically(folder / "script.txt", commands);
    ViewerOptions options;
    options.renderer = "osmesa";
    options.script = folder / "script.txt";
    options.width = 960;
    options.height = 640;
    return options;
  }
};

TEST_F(ViewerTest, AScreenshotNeedsNoDisplay) {
  ViewerOptions options;
  options.renderer = "osmesa";
  options.screenshot = png("shot");
  options.at = 1.5;
  view(folder, options);
  const Image shot = load_png(png("shot"));
  EXPECT_EQ(shot.width, options.width);
  EXPECT_EQ(shot.height, options.height);
  EXPECT_GT(share_differing(shot, Image(shot.width, shot.height), 20), 0.5);  // not black
}

// An arm of half the size under the ceiling, of a URDF alone, stands in the middle of the picture.
TEST_F(ViewerTest, AnArmWithoutMjcfIsInSight) {
  const std::filesystem::path urdf = folder / "pendulum.urdf", hung = folder / "pendulum.toml";
  write_file_atomically(urdf,
                        R"(<robot name="pendulum"><link name="base"/><link name="l1"><inertial>
               <origin xyz="0 0 .3"/><mass value="4"/>
               <inertia ixx=".05" iyy=".05" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
               <joint name="j" type="revolute"><parent link="base"/><child link="l1"/>
               <origin xyz="0 0 .5"/><axis xyz="0 1 0"/>
               <limit lower="-3" upper="3" velocity="6" effort="60"/></joint></robot>)");
  write_file_atomically(hung,
                        "[robot]\nurdf = \"pendulum.urdf\"\nmount = \"ceiling\"\nguess_armature = "
                        "true\n[friction]\n");
  ViewerOptions options;
  options.renderer = "osmesa";
  options.screenshot = png("ceiling");
  view(hung, options);
  const Image shot = load_png(png("ceiling"));
  const auto blue_less = [&](int x, int y) {  // the sky is bluish, the arm grey or orange
    const std::uint8_t* pixel = shot.row(y) + 3 * x;
    return pixel[2] <= pixel[0] + 2;
  };
  int arm = 0;
  for (int y = shot.height / 8; y < shot.height / 2; ++y)
    for (int x = shot.width / 6; x < shot.width / 2; ++x) arm += blue_less(x, y);
  EXPECT_GT(arm, 2000);
}

TEST_F(ViewerTest, WhatIsDoneIsSeen) {
  ViewerOptions options =
      script("seek 1.9\nshot " + png("all") + "\nshot " + png("again") + "\ntoggle gms\nshot " +
             png("without") + "\nlive\njoint joint_a1\npush 0 15 1\nrun 1\nshot " + png("live") +
             "\nscene " + (folder / "edited.toml").string() + "\n");
  options.offscreen = true;
  view(folder, options);
  EXPECT_EQ(share_differing(load_png(png("all")), load_png(png("again")), 0), 0);
  EXPECT_GT(share_differing(load_png(png("all")), load_png(png("without")), 20), 0.002);
  EXPECT_GT(share_differing(load_png(png("without")), load_png(png("live")), 20), 0.02);
  EXPECT_TRUE(std::filesystem::exists(folder / "edited.toml"));
}

TEST_F(ViewerTest, SaysHowFastItDraws) {
  ViewerOptions options = script("toggle gms\nfps 0.2\n");
  options.offscreen = true;
  testing::internal::CaptureStdout();
  view(folder, options);
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              MatchesRegex("[0-9.]+ frames/s, 960 x 640, 2 ghosts\n"));
}

TEST_F(ViewerTest, WorksInAWindow) {
  if (!std::getenv("DISPLAY")) GTEST_SKIP() << "needs a display, e.g. xvfb-run";
  view(folder, script("seek 1\nshot " + png("window") + "\ntoggle gms\nshot " + png("without") +
                      "\nlive\nrun 0.2\nset W1 1\nshot " + png("live") + "\nscene " +
                      (folder / "edited.toml").string() + "\n"));
  const Image shot = load_png(png("window"));
  EXPECT_EQ(shot.width, 960);
  EXPECT_GT(share_differing(shot, load_png(png("without")), 20), 0.002);
  EXPECT_NE(scene::load_scene(folder / "edited.toml").friction->theta, scene.friction->theta);
  EXPECT_GT(share_differing(shot, load_png(png("live")), 20), 0.02);
}

TEST_F(ViewerTest, WithoutADisplayItSaysSo) {
  const char* display = std::getenv("DISPLAY");
  const std::string before = display ? display : "";
  unsetenv("DISPLAY");
  EXPECT_THROW(view(folder, {}), UserError);
  if (display) setenv("DISPLAY", before.c_str(), 1);
}

}  // namespace
}  // namespace fricid::viewer
