// Both ways to draw give the same picture. A program of its own: a process that has drawn cannot
// fork.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>

#include "fricid/base/error.hpp"
#include "fricid/film/arm_painter.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"
#include "temporary_folder.hpp"

namespace fricid::film {
namespace {

using ::testing::StartsWith;

constexpr int kWidth = 320, kHeight = 240;
constexpr std::array<double, 6> kPose{0.4, -1.1, 1, -0.4, -0.9, 0};

constexpr int kMissing = 77;

std::unique_ptr<GlContext> context_or_end(GlBackend backend) try {
  return make_gl_context(backend);
} catch (const UserError&) {
  _exit(kMissing);
}

/// What a process of its own draws with one backend; empty where that backend is not there.
Image drawn_by(GlBackend backend, const std::filesystem::path& file) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    try {
      const auto context = context_or_end(backend);
      const sim::MujocoArm arm =
          sim::make_arm(scene::load_problem(source_dir() / "scenes/kr6_demo.toml"));
      ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::final(),
                         context->functions());
      std::array<double, 6> other = kPose;
      other[0] += 0.2;
      const std::array<PaintedArm, 2> arms{{{kPose}, {other, Paint{0, 0.4f, 0.7f, 0.5f}}}};
      save_png(painter.paint(View{{0.1, 0, 1.1}, 1.8, 135}, kWidth, kHeight, arms), file);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(status == 0 || WEXITSTATUS(status) == kMissing) << name_of(backend);
  return status == 0 ? load_png(file) : Image{};
}

using Backends = TemporaryFolder;

TEST_F(Backends, DrawTheSamePicture) {
  const Image egl = drawn_by(GlBackend::kEgl, folder / "egl.png");
  const Image osmesa = drawn_by(GlBackend::kOsmesa, folder / "osmesa.png");
  if (egl.rgb.empty() || osmesa.rgb.empty()) GTEST_SKIP() << "needs EGL and OSMesa";
  EXPECT_LT(share_differing(egl, osmesa, 1), 1e-3);
}

TEST_F(Backends, AreDescribedWithoutChoosingOne) {
  const auto lines = describe_gl_backends();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_THAT(lines[0], StartsWith("egl: "));
  EXPECT_THAT(lines[1], StartsWith("osmesa: "));
  EXPECT_EQ(describe_gl_backends(), lines);
}

}  // namespace
}  // namespace fricid::film
