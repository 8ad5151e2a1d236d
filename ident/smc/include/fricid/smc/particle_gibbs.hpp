#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/smc/backward_kernel.hpp"
#include "fricid/smc/history.hpp"
#include "fricid/smc/model.hpp"
#include "fricid/smc/particle_filter.hpp"

namespace fricid::smc {

/// Particle Gibbs with ancestor sampling (Lindsten, Jordan & Schon, JMLR 15, 2014): a Markov kernel
/// on paths that leaves p(x_0 .. x_{T-1} | y) as it is for any N >= 2. One particle follows the
/// given path; its ancestor is drawn anew at every step by the backward kernel, so that the path is
/// renewed also where all particles share one ancestor.
template <StateSpaceModel M, Guide G>
class ParticleGibbs {
 public:
  using S = typename G::Lanes;

  /// @param options  ess_threshold and resampling are not used: all steps resample multinomially
  ParticleGibbs(M& model, G& guide, const FilterOptions& options)
      : filter_(model, guide, options),
        kernel_(model.Q(), options.particles),
        history_(History<S>::full(model.state_size(), options.particles, guide.steps())),
        uniforms_(static_cast<std::size_t>(options.particles + 1)),
        ancestors_(static_cast<std::size_t>(options.particles)),
        seed_(options.seed) {}

  /// Draws a new path given the old one.
  /// @param path   (T x n), in and out
  /// @param sweep  number of the sweep, which with the seed of the options gives the random numbers
  /// @return false when all weights vanish; the path is then as it was
  bool sweep(RowMatrix& path, std::uint32_t sweep);

 private:
  static std::span<const double> row(const RowMatrix& path, int t) {
    return {path.data() + t * path.cols(), static_cast<std::size_t>(path.cols())};
  }

  ParticleFilter<M, G> filter_;
  BackwardKernel<S> kernel_;
  History<S> history_;
  std::vector<double> uniforms_;
  std::vector<int> ancestors_;
  std::uint64_t seed_;
};

template <StateSpaceModel M, Guide G>
bool ParticleGibbs<M, G>::sweep(RowMatrix& path, std::uint32_t sweep) {
  constexpr int kReference = 0;
  const int T = filter_.steps();
  const auto N = static_cast<std::size_t>(filter_.particles());
  filter_.set_sequence(sweep);
  filter_.start();
  filter_.place(kReference, row(path, 0));
  for (int t = 0; t < T; ++t) {
    Slice<S>& slice = history_.slice(t);
    if (!filter_.weigh(t, &slice)) return false;
    const auto step = static_cast<std::uint32_t>(t);
    fill_uniform(seed_, stream_of(Purpose::kGibbs, sweep, step), 0, uniforms_);
    if (t + 1 == T) break;

    // the ancestor of the reference, and those of the others
    kernel_.prepare(slice);
    kernel_.aim(row(path, t + 1));
    double ess;
    const int parent = kernel_.draw(uniforms_[N], ess);
    if (parent < 0) return false;
    ancestors_[kReference] = parent;
    resample(Resampling::kMultinomial, filter_.weights(), std::span(uniforms_).first(N),
             std::span(ancestors_).subspan(1));
    filter_.move_from(t, ancestors_, &slice);
    filter_.place(kReference, row(path, t + 1));
  }

  int index = pick(filter_.weights(), uniforms_[0]);
  for (int t = T - 1; t >= 0; --t) {
    const Slice<S>& slice = history_.slice(t);
    if (t + 1 < T) index = slice.ancestors[static_cast<std::size_t>(index)];
    for (int i = 0; i < path.cols(); ++i) path(t, i) = slice.x.at(index, i);
  }
  return true;
}

}  // namespace fricid::smc
