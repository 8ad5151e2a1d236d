// Smoothed paths from a particle filter.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/smc/backward_kernel.hpp"
#include "fricid/smc/history.hpp"
#include "fricid/smc/model.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/streams.hpp"

namespace fricid::smc {

/// How the past of a path is found.
enum class Backward {
  kExact,  ///< drawn from all N particles: FFBSi, Godsill, Doucet & West (2004)
  kMoves,  ///< a few Metropolis moves from the genealogical ancestor: Bunch & Godsill (2013),
           ///< Dau & Chopin (2023); O(1) per path and step, pays for N in the thousands
  kTrace,  ///< the genealogical ancestor itself; right where the filter hardly resampled, as the
           ///< twisted one does
};

struct BackwardOptions {
  Backward method = Backward::kExact;
  int moves = 10;  ///< Metropolis moves per path and step
  std::uint64_t seed = 1;
  std::uint32_t sequence = 0;  ///< tells runs with one seed apart, < 2^29
};

/// Scratch of sample_paths.
template <class S>
class BackwardWorkspace {
 public:
  BackwardWorkspace(const Eigen::MatrixXd& Q, int particles, int paths, int moves = 10)
      : kernel(Q, particles),
        index(static_cast<std::size_t>(paths)),
        uniforms(static_cast<std::size_t>(paths * std::max(1, 2 * moves))),
        weights(static_cast<std::size_t>(particles)),
        cumulated(weights),
        met(weights.size()) {}

  BackwardKernel<S> kernel;
  std::vector<int> index;
  std::vector<double> uniforms, weights, cumulated;
  std::vector<char> met;
};

/// Draws M paths x_0 .. x_{T-1} given all observations, after `filter.run(report, &history)`. Fills
/// the backward figures of `report`; sets report.failed when no particle can have led to a path.
/// Does not allocate, but for the paths' storage when its size is new.
///
/// @param paths  M matrices, made (T x n); particles they end in are drawn systematically
template <StateSpaceModel M, Guide G>
void sample_paths(ParticleFilter<M, G>& filter, History<typename G::Lanes>& history,
                  const BackwardOptions& options, BackwardWorkspace<typename G::Lanes>& ws,
                  std::span<RowMatrix> paths, Report& report) {
  const int T = filter.steps(), n = filter.model().state_size();
  const std::size_t count = paths.size(), N = static_cast<std::size_t>(filter.particles());
  const auto stream = [&](int t) {
    return stream_of(Purpose::kBackward, options.sequence, static_cast<std::uint32_t>(t));
  };
  report.paths = static_cast<int>(count);
  report.backward_ess.clear();
  if (options.method == Backward::kExact) {
    report.backward_ess.resize(static_cast<std::size_t>(T - 1));
  }
  const std::span<int> index(ws.index.data(), count);
  long refreshed = 0;

  for (int t = T - 1; t >= 0; --t) {
    const auto& slice = filter.at(history, t);
    const std::span log_weights(slice.log_weights.data(), N);
    if (t == T - 1) {
      fill_uniform(options.seed, stream(t), 0, std::span(ws.uniforms).first(1));
      normalise(log_weights, ws.weights);
      resample(Resampling::kSystematic, ws.weights, ws.uniforms, index);
    } else if (options.method == Backward::kTrace) {
      for (int& i : index) i = slice.ancestors[static_cast<std::size_t>(i)];
    } else {
      ws.kernel.prepare(slice);
      const bool exact = options.method == Backward::kExact;
      const std::size_t per_path = exact ? 1 : static_cast<std::size_t>(2 * options.moves);
      const std::span u(ws.uniforms.data(), count * per_path);
      fill_uniform(options.seed, stream(t), 0, u);
      if (!exact) {
        normalise(log_weights, ws.weights);
        double sum = 0;
        for (std::size_t i = 0; i < N; ++i) ws.cumulated[i] = sum += ws.weights[i];
      }
      double ess_sum = 0;
      for (std::size_t m = 0; m < count; ++m) {
        ws.kernel.aim({paths[m].row(t + 1).data(), static_cast<std::size_t>(n)});
        const int ancestor = slice.ancestors[static_cast<std::size_t>(index[m])];
        int chosen = ancestor;
        if (exact) {
          double ess;
          chosen = ws.kernel.draw(u[m], ess);
          ess_sum += ess;
          if (chosen < 0) {
            report.failed = true;
            return;
          }
        } else {
          double distance = ws.kernel.squared_distance(chosen);
          for (std::size_t k = 0; k < per_path; k += 2) {
            const auto at = std::upper_bound(ws.cumulated.begin(), ws.cumulated.end() - 1,
                                             u[m * per_path + k] * ws.cumulated.back());
            const int proposed = static_cast<int>(at - ws.cumulated.begin());
            const double other = ws.kernel.squared_distance(proposed);
            if (u[m * per_path + k + 1] < std::exp(0.5 * (distance - other))) {
              chosen = proposed;
              distance = other;
            }
          }
        }
        refreshed += chosen != ancestor ? 1 : 0;
        index[m] = chosen;
      }
      if (exact) {
        report.backward_ess[static_cast<std::size_t>(t)] = ess_sum / static_cast<double>(count);
      }
    }
    for (std::size_t m = 0; m < count; ++m) {
      if (t == T - 1) paths[m].resize(T, n);
      for (int i = 0; i < n; ++i) paths[m](t, i) = slice.x.at(index[m], i);
    }
  }

  std::fill(ws.met.begin(), ws.met.end(), 0);
  for (const int i : index) ws.met[static_cast<std::size_t>(i)] = 1;
  report.path_roots = static_cast<int>(std::count(ws.met.begin(), ws.met.end(), 1));
  const bool traced = options.method == Backward::kTrace || T == 1;
  const auto steps = static_cast<double>(count) * (T - 1);
  report.refreshed = traced ? 1 : static_cast<double>(refreshed) / steps;
}

}  // namespace fricid::smc
