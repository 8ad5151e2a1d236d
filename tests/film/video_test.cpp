#include "fricid/film/video.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "film_fixture.hpp"
#include "fricid/base/error.hpp"
#include "fricid/film/frame_writer.hpp"
#include "fricid/film/image.hpp"
#include "output_of.hpp"

namespace fricid::film {
namespace {

std::string probed(const std::filesystem::path& file) {
  return output_of(
      "ffprobe -v error -select_streams v -show_entries "
      "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_frames -of csv=p=0 " +
      file.string());
}

class RenderVideo : public FilmFolder {
 protected:
  void SetUp() override {
    FilmFolder::SetUp();
    scene.render.card_s = 0.2;
    scene.render.quality = Quality::kDraft;
  }
  const DrawingOptions options{"osmesa", 0.2};
};

TEST_F(RenderVideo, MakesBothVideos) {
  if (!ffmpeg_found()) GTEST_SKIP() << "needs ffmpeg";
  const auto files = render_video(run, run, problem(), options);
  EXPECT_EQ(files, (std::vector{run.video("comparison"), run.video("orbit")}));
  // two seconds and two cards of six frames
  EXPECT_EQ(probed(run.video("comparison")), "h264,1280,720,yuv420p,30/1,72\n");
  EXPECT_EQ(probed(run.video("orbit")), "h264,1280,720,yuv420p,30/1,6\n");
}

TEST_F(RenderVideo, WithoutFfmpegThereArePictures) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.c_str(), 1);
  scene.render.card_s = 0;
  const auto files = render_video(run, run, problem(), options);
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(files.size(), 60u + 6u);
  EXPECT_EQ(files[0], run.videos() / "comparison" / "00001.png");
  const Image last = load_png(files.back());
  EXPECT_EQ(last.width, 1280);
  EXPECT_EQ(last.height, 720);
}

TEST_F(RenderVideo, AKilledEncoderCostsItsOwnVideo) {
  if (!ffmpeg_found()) GTEST_SKIP() << "needs ffmpeg";
  const std::filesystem::path fake = folder / "bin" / "ffmpeg";
  write_file_atomically(fake, "#!/bin/sh\ncase \"$*\" in *comparison*) kill -9 $$ ;; esac\nexec " +
                                  output_of("command -v ffmpeg | tr -d '\\n'") + " \"$@\"\n");
  std::filesystem::permissions(fake, std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (fake.parent_path().string() + ":" + path).c_str(), 1);
  std::string said;
  try {
    render_video(run, run, problem(), options);
  } catch (const UserError& error) {
    said = error.what();
  }
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(said, run.video("comparison").string() + ": ffmpeg gave up: it was killed by signal 9");
  EXPECT_EQ(probed(run.video("orbit")), "h264,1280,720,yuv420p,30/1,6\n");
  EXPECT_EQ(output_of("ls -A " + run.videos().string()), "orbit.mp4\n");
}

TEST_F(RenderVideo, OfLogsWithoutAnMjcfThereIsNone) {
  scene.friction.reset();
  EXPECT_THROW(render_video(run, run, problem(), options), UserError);
}

TEST_F(RenderVideo, AStillIsFinal) {
  render_still(run, problem(), 1.0, folder / "still.png", options);
  EXPECT_THROW(render_still(run, problem(), 1e3, folder / "late.png", options), UserError);
  EXPECT_EQ(load_png(folder / "still.png").width, 1280);
}

}  // namespace
}  // namespace fricid::film
