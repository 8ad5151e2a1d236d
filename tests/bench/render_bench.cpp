// One picture of the KR 6 at 1280 x 720 with two ghosts, drawn and read back. A process draws by
// one kind of context only, so each kind has a process of its own, which draws when it is told to.
#include <benchmark/benchmark.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <string>

#include "fricid/film/arm_painter.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::film {
namespace {

/// Draws one picture per byte read, and answers each with a byte.
void serve(GlBackend backend, PaintQuality quality, int orders, int answers) {
  const auto context = make_gl_context(backend);
  const sim::MujocoArm arm =
      sim::make_arm(scene::load_problem(source_dir() / "scenes/kr6_demo.toml"));
  ArmPainter painter(arm, "flange", 1280, 720, quality, context->functions());
  std::array<double, 6> q{0.4, -1.1, 1, -0.4, -0.9, 0}, left = q, right = q;
  left[0] -= 0.1;
  right[0] += 0.1;
  const std::array<PaintedArm, 3> arms{
      {{q}, {left, paint_of("#CC79A7", 0.5f)}, {right, paint_of("#009E73", 0.5f)}}};
  const View view{{0.1, 0, 1.1}, 2, 135, -8};
  for (char order = 0; read(orders, &order, 1) == 1;) {
    benchmark::DoNotOptimize(painter.paint(view, 1280, 720, arms));
    if (write(answers, &order, 1) != 1) return;
  }
}

void BM_RenderFrame(benchmark::State& state, GlBackend backend, PaintQuality quality) {
  std::array<int, 2> orders{}, answers{};
  if (pipe(orders.data()) != 0 || pipe(answers.data()) != 0) return state.SkipWithError("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    close(orders[1]);
    try {
      serve(backend, quality, orders[0], answers[1]);
    } catch (const std::exception&) {
      _exit(1);
    }
    _exit(0);
  }
  close(orders[0]);
  close(answers[1]);
  char byte = 0;
  const auto draw = [&] {
    return write(orders[1], &byte, 1) == 1 && read(answers[0], &byte, 1) == 1;
  };
  if (!draw()) state.SkipWithError("this kind of context is missing");
  for (auto _ : state)
    if (!draw()) {
      state.SkipWithError("the drawing process ended");
      break;
    }
  close(orders[1]);
  close(answers[0]);
  waitpid(child, nullptr, 0);
  state.SetItemsProcessed(state.iterations());  // frames/s
}
BENCHMARK_CAPTURE(BM_RenderFrame, osmesa_draft, GlBackend::kOsmesa, PaintQuality::draft())
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_RenderFrame, egl_draft, GlBackend::kEgl, PaintQuality::draft())
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_RenderFrame, osmesa_final, GlBackend::kOsmesa, PaintQuality::final())
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_RenderFrame, egl_final, GlBackend::kEgl, PaintQuality::final())
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace fricid::film
