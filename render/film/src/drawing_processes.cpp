#include "drawing_processes.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <thread>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/base/processes.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/film/gl_context.hpp"

namespace fricid::film {
namespace {

constexpr int kMostProcesses = 8;  // each takes 0.2 GB for a final picture

/// Header of a picture, or of the message why there is none.
struct Header {
  std::uint64_t size;
  bool is_picture;
};

bool send(int pipe, const void* data, std::size_t size) {
  const auto* from = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t sent = write(pipe, from, size);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    from += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool receive(int pipe, void* data, std::size_t size) {
  auto* to = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t got = read(pipe, to, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

/// Draws pictures first, first + stride, ... into the pipe until its reader closes it.
void draw_all(int pipe, int first, int stride, int count, const std::function<Draw()>& open) {
  try {
    const Draw draw = open();
    for (int k = first; k < count; k += stride) {
      throw_if_stopped();
      const PictureBytes picture = draw(k);
      const Header header{picture.size(), true};
      if (!send(pipe, &header, sizeof header) || !send(pipe, picture.data(), picture.size()))
        return;
    }
  } catch (const std::exception& error) {
    const std::string reason = error.what();
    const Header header{reason.size(), false};
    if (send(pipe, &header, sizeof header)) send(pipe, reason.data(), reason.size());
  } catch (const Stopped&) {
    // the reader was stopped too
  }
}

int processes_for(int count, int jobs) {
  const int wanted = jobs > 0 ? jobs : static_cast<int>(std::thread::hardware_concurrency());
  return std::clamp(wanted, 1, std::clamp(count, 1, kMostProcesses));
}

}  // namespace

DrawingProcesses::DrawingProcesses(int count, int jobs, const std::function<Draw()>& open)
    : DrawingProcesses() {  // from here on the destructor ends started processes
  const int stride = processes_for(count, jobs);
  if (stride == 1 || gl_was_used()) {
    draw_here_ = open();
    return;
  }
  for (int first = 0; first < stride; ++first) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw UserError("cannot make a pipe to draw through");
    const pid_t id = fork();
    if (id == 0) {
      close(ends[0]);
      for (const Process& before : processes_) close(before.pipe);
      setenv("LP_NUM_THREADS", "0", 0);  // llvmpipe's own threads would only compete
      draw_all(ends[1], first, stride, count, open);
      _exit(0);
    }
    close(ends[1]);
    if (id < 0) {
      close(ends[0]);
      throw UserError("cannot start a process that draws");
    }
    processes_.push_back({id, ends[0]});
  }
}

DrawingProcesses::~DrawingProcesses() {
  for (const Process& process : processes_) close(process.pipe);
  for (const Process& process : processes_) wait_for_process(process.id);
}

PictureBytes DrawingProcesses::next() {
  const int k = next_++;
  if (draw_here_) return draw_here_(k);
  const int pipe = processes_[static_cast<std::size_t>(k) % processes_.size()].pipe;
  Header header{};
  if (receive(pipe, &header, sizeof header)) {
    PictureBytes bytes(header.size);
    if (receive(pipe, bytes.data(), bytes.size())) {
      if (header.is_picture) return bytes;
      throw UserError("{}", std::string(bytes.begin(), bytes.end()));
    }
  }
  throw_if_stopped();
  throw UserError("a process that draws was killed");
}

}  // namespace fricid::film
