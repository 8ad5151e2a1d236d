#include "fricid/film/frame_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/film/image.hpp"
#include "output_of.hpp"
#include "temporary_folder.hpp"

namespace fricid::film {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int kWidth = 64, kHeight = 48, kRate = 30;

std::vector<std::uint8_t> grey(int level) {
  Image image(kWidth, kHeight);
  std::fill(image.rgb.begin(), image.rgb.end(), static_cast<std::uint8_t>(level));
  return yuv420_of(image);
}

int files_in(const std::filesystem::path& folder) {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

class FrameWriterTest : public TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    if (!ffmpeg_found()) GTEST_SKIP() << "needs ffmpeg";
  }
};

TEST_F(FrameWriterTest, WritesWhatPlayersAndBrowsersRead) {
  const auto file = folder / "it's.mp4";
  FrameWriter writer(file, kWidth, kHeight, kRate, true);
  for (int k = 0; k < 45; ++k) writer.write(grey(4 * k));
  writer.finish();
  EXPECT_EQ(output_of("ffprobe -v error -select_streams v -show_entries stream=codec_name,width,"
                      "height,pix_fmt,color_space,r_frame_rate,nb_frames -of csv=p=0 \"" +
                      file.string() + "\""),
            "h264,64,48,yuv420p,bt709,30/1,45\n");
  const std::string bytes = read_file(file);
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));  // faststart
  EXPECT_EQ(files_in(folder), 1);
}

TEST_F(FrameWriterTest, FoldersOfAnyNameAreFolders) {
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  for (const char* name : {"-x", "tcp:x", "|touch marker", "100 %d", "a\nb", "'`touch marker`'"}) {
    FrameWriter writer(std::filesystem::path(name) / "a.mp4", kWidth, kHeight, kRate, true);
    writer.write(grey(0));
    writer.finish();
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(name) / "a.mp4")) << name;
  }
  EXPECT_FALSE(std::filesystem::exists("marker"));
  std::filesystem::current_path(before);
}

TEST_F(FrameWriterTest, WithoutFinishNothingStays) {
  {
    FrameWriter writer(folder / "a.mp4", kWidth, kHeight, kRate, true);
    writer.write(grey(1));
  }
  EXPECT_EQ(files_in(folder), 0);
}

TEST_F(FrameWriterTest, AFullDiskIsSaid) {
  // the encoder inherits the limit on the size of a file, and that no signal comes of it
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1000, before.rlim_max};
  std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  std::string said;
  try {
    FrameWriter writer(folder / "a.mp4", kWidth, kHeight, kRate, true);
    for (int k = 0; k < 300; ++k) {
      Image noise(kWidth, kHeight);
      for (std::size_t i = 0; i < noise.rgb.size(); ++i)
        noise.rgb[i] =
            static_cast<std::uint8_t>((i + static_cast<std::size_t>(k)) * 2654435761u >> 24);
      writer.write(yuv420_of(noise));
    }
    writer.finish();
  } catch (const UserError& error) {
    said = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(said, StartsWith((folder / "a.mp4").string() + ": ffmpeg gave up: "));
  EXPECT_EQ(files_in(folder), 0);
}

TEST_F(FrameWriterTest, AKilledEncoderIsSaid) {
  std::string said;
  try {
    FrameWriter writer(folder / "a.mp4", kWidth, kHeight, kRate, true);
    writer.write(grey(0));
    // the only ffmpeg that is a child of ours
    const std::string id = output_of("pgrep -n -P " + std::to_string(getpid()) + " ffmpeg");
    ASSERT_FALSE(id.empty());
    kill(std::stoi(id), SIGKILL);
    for (int k = 0; k < 1000; ++k) writer.write(grey(k % 256));
    writer.finish();
  } catch (const UserError& error) {
    said = error.what();
  }
  EXPECT_THAT(said, HasSubstr("killed by signal 9"));
  EXPECT_EQ(files_in(folder), 0);
}

using FrameWriterWithoutFfmpeg = TemporaryFolder;

TEST_F(FrameWriterWithoutFfmpeg, SaysWhatToInstall) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.c_str(), 1);
  std::string said;
  try {
    const FrameWriter writer(folder / "a.mp4", kWidth, kHeight, kRate, true);
  } catch (const UserError& error) {
    said = error.what();
  }
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(said, "ffmpeg is missing; install ffmpeg");
}

}  // namespace
}  // namespace fricid::film
