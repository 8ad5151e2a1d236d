#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace fricid::film {

/// Whether the ffmpeg program can be called.
bool ffmpeg_found();

/// Writes a video frame by frame: H.264, 8-bit 4:2:0, BT.709, index first (faststart), by the
/// ffmpeg program through a pipe. The file appears under its name when `finish` succeeds.
class FrameWriter {
 public:
  /// @param fast  quicker and larger, for drafts
  /// @throws UserError when ffmpeg cannot be started
  FrameWriter(std::filesystem::path path, int width, int height, int frames_per_second, bool fast);
  /// Without `finish` the file is removed.
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  /// @param yuv420  a frame as yuv420_of makes it
  /// @throws UserError with ffmpeg's message when it ended early (disk full, killed); Stopped on
  ///         Ctrl-C
  void write(std::span<const std::uint8_t> yuv420);
  /// @throws UserError as `write`
  void finish();

 private:
  [[noreturn]] void fail(int status) const;
  int close();

  std::filesystem::path path_, part_, log_;
  static constexpr int kNone = -1;
  int pipe_ = kNone;
  pid_t encoder_ = 0;
};

}  // namespace fricid::film
