#include "fricid/film/frame_writer.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/processes.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/base/temporary_file.hpp"

namespace fricid::film {
namespace {

constexpr std::uintmax_t kNoRoom = 64 * 1024;  // [bytes]

/// A file as an argument of ffmpeg, so that it is not taken for an option ("-x") or protocol
/// ("tcp:x").
std::string argument_of(const std::filesystem::path& path) {
  return "file:" + std::filesystem::absolute(path).string();
}

/// Last line that ffmpeg wrote.
std::string last_line(const std::filesystem::path& log) {
  if (!std::filesystem::exists(log)) return {};
  std::string text = read_file(log);
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text.substr(text.find_last_of("\r\n") + 1);
}

}  // namespace

bool ffmpeg_found() { return std::system("command -v ffmpeg >/dev/null 2>&1") == 0; }

FrameWriter::FrameWriter(std::filesystem::path path, int width, int height, int frames_per_second,
                         bool fast)
    : path_(std::move(path)) {
  if (!ffmpeg_found()) throw UserError("ffmpeg is missing; install ffmpeg");
  std::filesystem::create_directories(path_.parent_path());
  part_ = temporary_beside(path_);
  log_ = temporary_beside(path_);
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe becomes a write error
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw UserError("{}: cannot make a pipe", path_.string());
  const int log = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  encoder_ = start_program({"ffmpeg",
                            "-nostdin",
                            "-y",
                            "-loglevel",
                            "error",
                            "-f",
                            "rawvideo",
                            "-pix_fmt",
                            "yuv420p",
                            "-s",
                            fmt::format("{}x{}", width, height),
                            "-r",
                            std::to_string(frames_per_second),
                            "-i",
                            "-",
                            "-c:v",
                            "libx264",
                            "-preset",
                            fast ? "ultrafast" : "veryfast",
                            "-crf",
                            fast ? "23" : "19",
                            "-pix_fmt",
                            "yuv420p",
                            "-colorspace",
                            "bt709",
                            "-color_primaries",
                            "bt709",
                            "-color_trc",
                            "bt709",
                            "-color_range",
                            "tv",
                            "-movflags",
                            "+faststart",
                            "-f",
                            "mp4",
                            argument_of(part_)},
                           {.input = ends[0], .errors = log});
  ::close(ends[0]);
  ::close(log);
  pipe_ = ends[1];
  ::fcntl(pipe_, F_SETFL, O_NONBLOCK);
  if (encoder_ == 0) {
    ::close(std::exchange(pipe_, kNone));
    std::filesystem::remove(log_);
    throw UserError("{}: cannot start ffmpeg", path_.string());
  }
}

FrameWriter::~FrameWriter() {
  close();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
  std::filesystem::remove(log_, ignored);
}

void FrameWriter::write(std::span<const std::uint8_t> yuv420) {
  while (!yuv420.empty()) {
    wait_until_writable(pipe_);
    const ssize_t written = ::write(pipe_, yuv420.data(), yuv420.size());
    if (written < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (written < 0) fail(close());
    yuv420 = yuv420.subspan(static_cast<std::size_t>(written));
  }
}

void FrameWriter::finish() {
  if (const int status = close(); status != 0) fail(status);
  std::error_code failure;
  std::filesystem::remove(log_, failure);
  std::filesystem::rename(part_, path_, failure);
  if (failure) throw UserError("{}: cannot write: {}", path_.string(), failure.message());
}

int FrameWriter::close() {
  if (pipe_ == kNone) return 0;
  ::close(std::exchange(pipe_, kNone));
  return wait_for_process(encoder_);
}

void FrameWriter::fail(int status) const {
  throw_if_stopped();  // ctrl-c ends the encoder too
  std::string reason = last_line(log_);
  if (reason.empty() && WIFSIGNALED(status))
    reason = fmt::format("it was killed by signal {}", WTERMSIG(status));
  std::error_code ignored;  // on a full disk ffmpeg's log is lost too
  if (reason.empty() && std::filesystem::space(path_.parent_path(), ignored).available < kNoRoom)
    reason = "no space left on the disk";
  throw UserError("{}: ffmpeg gave up{}{}", path_.string(), reason.empty() ? "" : ": ", reason);
}

}  // namespace fricid::film
