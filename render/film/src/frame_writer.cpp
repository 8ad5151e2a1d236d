#include "fricid/film/frame_writer.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/progress.hpp"

namespace fricid::film {
namespace {

constexpr std::uintmax_t kNoRoom = 64 * 1024;  // [bytes]

std::string quoted(const std::filesystem::path& path) {
  std::string text = "'";
  for (const char c : path.string()) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
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
  const std::string stem = fmt::format(".{}.{}", path_.filename().string(), getpid());
  part_ = path_.parent_path() / (stem + ".mp4");
  log_ = path_.parent_path() / (stem + ".log");
  const std::string command = fmt::format(
      "exec ffmpeg -nostdin -y -loglevel error -f rawvideo -pix_fmt yuv420p -s {}x{} -r {} -i - "
      "-c:v libx264 -preset {} -crf {} -pix_fmt yuv420p -colorspace bt709 -color_primaries bt709 "
      "-color_trc bt709 -color_range tv -movflags +faststart {} 2>{}",
      width, height, frames_per_second, fast ? "ultrafast" : "veryfast", fast ? 23 : 19,
      quoted(part_), quoted(log_));
  std::signal(SIGPIPE, SIG_IGN);  // an encoder that ended is a failed write, not our end
  pipe_ = popen(command.c_str(), "w");
  if (!pipe_) throw UserError("{}: cannot start ffmpeg", path_.string());
}

FrameWriter::~FrameWriter() {
  close();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
  std::filesystem::remove(log_, ignored);
}

void FrameWriter::write(std::span<const std::uint8_t> yuv420) {
  if (std::fwrite(yuv420.data(), 1, yuv420.size(), pipe_) != yuv420.size()) fail(close());
}

void FrameWriter::finish() {
  if (const int status = close(); status != 0) fail(status);
  std::error_code failure;
  std::filesystem::remove(log_, failure);
  std::filesystem::rename(part_, path_, failure);
  if (failure) throw UserError("{}: cannot write: {}", path_.string(), failure.message());
}

int FrameWriter::close() {
  if (!pipe_) return 0;
  return pclose(std::exchange(pipe_, nullptr));
}

void FrameWriter::fail(int status) const {
  throw_if_stopped();  // ctrl-c ends the encoder too
  std::string reason = last_line(log_);
  if (reason.empty() && WIFSIGNALED(status))
    reason = fmt::format("it was killed by signal {}", WTERMSIG(status));
  std::error_code ignored;  // a full disk has no room for ffmpeg's words either
  if (reason.empty() && std::filesystem::space(path_.parent_path(), ignored).available < kNoRoom)
    reason = "no space left on the disk";
  throw UserError("{}: ffmpeg gave up{}{}", path_.string(), reason.empty() ? "" : ": ", reason);
}

}  // namespace fricid::film
