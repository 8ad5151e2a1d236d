#include "fricid/estimate/em/e_step.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/smc/backward_sampling.hpp"
#include "fricid/smc/kalman.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/statistical_twist.hpp"

namespace fricid::estimate {
namespace {

constexpr int kPsiIterations = 2;  // of the path that the twisted filter follows
// Where paths are traced, seldom and few at a time are resampled.
constexpr double kTracedEss = 0.25, kTracedRenewed = 0.05;

void say(const smc::Warning& w, EStepResult& out) {
  out.warnings.push_back(fmt::format("{}: {}; {}", w.figure, w.meaning, w.remedy));
}

/// Filter under a guide and paths by `backward`.
/// @param nis_counts  whether its innovations say something of the noise
template <class Guide>
void run_particles(LatentFrictionModel& model, Guide& guide, const smc::RowMatrix& y,
                   smc::Backward backward, const EStepOptions& options, EStepResult& out,
                   bool nis_counts = true) {
  smc::FilterOptions filter_options;
  filter_options.particles = options.particles;
  filter_options.seed = options.seed;
  filter_options.sequence = options.sequence;
  filter_options.y = &y;
  if (backward == smc::Backward::kTrace) {
    filter_options.ess_threshold = kTracedEss;
    filter_options.renewed = kTracedRenewed;
  }
  smc::ParticleFilter<LatentFrictionModel, Guide> filter(model, guide, filter_options);
  auto history = smc::History<PackD>::checkpointed(model.state_size(), options.particles,
                                                   static_cast<int>(y.rows()));
  smc::Report report;
  filter.run(report, &history);
  out.log_likelihood = report.log_likelihood;
  out.failed = report.failed;
  if (!report.failed) {
    smc::BackwardWorkspace<PackD> ws(model.Q(), options.particles, options.paths);
    smc::BackwardOptions backward_options;
    backward_options.method = backward;
    backward_options.seed = options.seed;
    backward_options.sequence = options.sequence;
    smc::sample_paths(filter, history, backward_options, ws, out.paths, report);
    out.failed = report.failed;
  }
  out.nis = report.nis_per_channel();
  out.roots = static_cast<double>(report.distinct_roots) / options.particles;
  out.backward_ess =
      backward == smc::Backward::kExact && !report.failed ? report.median_backward_ess() : 0;
  if (!nis_counts) {
    report.nis.clear();
    report.present.clear();
  }
  for (const smc::Warning& w : report.warnings()) say(w, out);
}

}  // namespace

EStepResult smooth(LatentFrictionModel& model, const signals::Recording& recording, int steps,
                   const EStepOptions& options) {
  EStepResult out;
  out.paths.resize(static_cast<std::size_t>(options.paths));
  const smc::RowMatrix y = recording.log.q.topRows(steps);

  if (options.method == EStep::kAdapted) {
    smc::AdaptedGuide<PackD> guide(model, y);
    run_particles(model, guide, y, smc::Backward::kExact, options, out);
    return out;
  }
  if (options.method == EStep::kBootstrap) {
    smc::BootstrapGuide<PackD> guide(model, y);
    run_particles(model, guide, y, smc::Backward::kExact, options, out);
    return out;
  }
  smc::GaussianPath path;
  smc::gaussian_smoother(model, y, path, options.method == EStep::kPsi ? kPsiIterations : 0);
  out.log_likelihood = path.log_likelihood;
  out.failed = path.failed;
  const smc::NisFigure nis = smc::nis_figure(path.nis, path.present);
  out.nis = nis.mean;
  if (path.failed) return out;
  if (const auto warning = nis.warning()) say(*warning, out);
  if (options.method == EStep::kPsi) {
    smc::Twist twist;
    const auto run = [&] {
      path = {};
      smc::TwistedGuide<PackD> guide(model, twist);
      // twisted particles use future observations, so their innovations are no test of the noise
      run_particles(model, guide, y, smc::Backward::kTrace, options, out, false);
    };
    const std::size_t said = out.warnings.size();
    out.failed = !smc::make_bent_twist(model, y, model.parts(), path.smoothed, twist);
    if (!out.failed) run();
    if (out.failed) {
      smc::gaussian_smoother(model, y, path, kPsiIterations);
      smc::make_twist(model, y, path, twist);
      out.warnings.resize(said);
      out.warnings.emplace_back(
          "psi: the bent twist failed, the plain one was used; the model is far from the data, or "
          "strongly nonlinear in several joints at once");
      run();
    }
    out.nis = nis.mean;
    return out;
  }
  smc::sample_gaussian_paths(model.Q(), path, options.seed, options.sequence, out.paths);
  return out;
}

}  // namespace fricid::estimate
