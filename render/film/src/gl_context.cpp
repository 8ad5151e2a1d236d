#include "fricid/film/gl_context.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <optional>

#include "fricid/base/error.hpp"
#include "gl_backends.hpp"

namespace fricid::film {
namespace {

constexpr std::array kBackends{GlBackend::kEgl, GlBackend::kOsmesa};
constexpr unsigned kGlRenderer = 0x1F01;
constexpr std::array kSoftware{"llvmpipe", "softpipe", "Software Rasterizer"};
constexpr unsigned kPatience = 20;  // [s] timeout of a driver that hangs

/// libmujoco looks its functions up once: the first context of the process decides.
std::atomic<std::optional<GlBackend>> bound;
static_assert(std::atomic<std::optional<GlBackend>>::is_always_lock_free);

/// Result of trying a backend in a process of its own, which leaves this one free to choose.
std::string try_elsewhere(GlBackend backend) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return "not tried";
  const pid_t child = fork();
  if (child == 0) {
    alarm(kPatience);
    std::string found;
    try {
      found = make_gl_context(backend)->renderer();
    } catch (const std::exception& error) {
      found = error.what();
    }
    const bool sent = write(ends[1], found.data(), found.size()) >= 0;
    _exit(sent ? 0 : 1);
  }
  close(ends[1]);
  std::string found;
  std::array<char, 256> part{};
  for (ssize_t n = 0; (n = read(ends[0], part.data(), part.size())) > 0;)
    found.append(part.data(), static_cast<std::size_t>(n));
  close(ends[0]);
  if (child > 0) waitpid(child, nullptr, 0);
  return found.empty() ? "the driver crashed or hangs" : found;
}

}  // namespace

GlBackend backend_of(std::string_view name) {
  if (const auto backend = value_named<GlBackend>(name)) return *backend;
  throw UserError("renderer {}: allowed: egl, osmesa", name);
}

std::string renderer_of(const GlLookup& function) {
  auto* get = reinterpret_cast<const unsigned char* (*)(unsigned)>(function("glGetString"));
  const unsigned char* text = get ? get(kGlRenderer) : nullptr;
  return text ? reinterpret_cast<const char*>(text) : "unknown";
}

bool draws_by_processor(const GlLookup& function) {
  const std::string renderer = renderer_of(function);
  return std::any_of(kSoftware.begin(), kSoftware.end(),
                     [&](const char* name) { return renderer.find(name) != std::string::npos; });
}

std::unique_ptr<GlContext> make_gl_context(GlBackend backend, int width, int height) {
  if (const auto before = bound.load(); before && *before != backend)
    throw UserError("this process draws by {} already, {} needs another process", name_of(*before),
                    name_of(backend));
  auto context = backend == GlBackend::kOsmesa ? make_osmesa_context(width, height)
                                               : make_egl_context(width, height);
  bound = backend;
  return context;
}

std::unique_ptr<GlContext> make_gl_context(std::string_view wanted, int width, int height) {
  if (const char* choice = std::getenv("FRICID_GL"); wanted.empty() && choice) wanted = choice;
  if (!wanted.empty()) return make_gl_context(backend_of(wanted), width, height);
  std::string reasons;
  for (const GlBackend backend : kBackends) try {
      return make_gl_context(backend, width, height);
    } catch (const UserError& error) {
      reasons +=
          fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", name_of(backend), error.what());
    }
  throw UserError("found nothing to draw with: {}", reasons);
}

bool gl_was_used() { return bound.load().has_value(); }

std::vector<std::string> describe_gl_backends() {
  std::vector<std::string> lines;
  for (const GlBackend backend : kBackends)
    lines.push_back(fmt::format("{}: {}", name_of(backend), try_elsewhere(backend)));
  return lines;
}

}  // namespace fricid::film
