#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/base/single_normals.hpp"
#include "fricid/smc/guides.hpp"
#include "fricid/smc/history.hpp"
#include "fricid/smc/innovations.hpp"
#include "fricid/smc/lanes.hpp"
#include "fricid/smc/model.hpp"
#include "fricid/smc/report.hpp"
#include "fricid/smc/resampling.hpp"
#include "fricid/smc/streams.hpp"

namespace fricid::smc {

struct FilterOptions {
  int particles = 200;         ///< N >= 1
  double ess_threshold = 0.5;  ///< resample when ESS < threshold N; > 1 resamples always
  Resampling resampling = Resampling::kSystematic;
  /// Share of the particles that are drawn anew when one resamples; below 1 by `split_heaviest`,
  /// which keeps the histories of the others.
  double renewed = 1;
  std::uint64_t seed = 1;
  std::uint32_t sequence = 0;  ///< tells runs with one seed apart, < 2^29
  /// Observations (T x ny) to compute the NIS of, or none. Not with the twisted guide, whose
  /// particles know the future: take the NIS of its GaussianPath.
  const RowMatrix* y = nullptr;
};

/// Particle filter of a model under a guide (guides.hpp), N particles in the lanes of S = PackD or
/// PackF. Log weights and sums of weights are double for both. The result depends on the options,
/// the model and the observations alone.
///
/// @see Chopin & Papaspiliopoulos, An Introduction to Sequential Monte Carlo, 2020, ch. 10
template <StateSpaceModel M, Guide G>
class ParticleFilter {
 public:
  using S = typename G::Lanes;

  /// Keeps references to both.
  ParticleFilter(M& model, G& guide, const FilterOptions& options)
      : model_(&model),
        guide_(&guide),
        options_(options),
        innovations_(model),
        n_(model.state_size()),
        stride_(padded(options.particles)),
        x_(n_, options.particles),
        image_(n_, options.particles),
        temporary_(static_cast<std::size_t>(2 * n_), S(0)),
        noise_(static_cast<std::size_t>(n_ * stride_)),
        uniforms_(uniforms_needed(options.resampling, static_cast<std::size_t>(stride_))),
        ancestors_(static_cast<std::size_t>(stride_), 0),
        roots_(ancestors_),
        old_roots_(ancestors_),
        copies_(ancestors_),
        log_weights_(static_cast<std::size_t>(stride_)),
        past_log_weights_(log_weights_),
        weights_(log_weights_),
        past_weights_(log_weights_) {}

  const FilterOptions& options() const { return options_; }
  int particles() const { return options_.particles; }
  int steps() const { return guide_->steps(); }
  M& model() { return *model_; }

  /// Runs over all observations. Does not allocate, except in `report` when T grows.
  /// @param history  made for at least these sizes, or null when nothing will be smoothed
  void run(Report& report, History<S>* history = nullptr);

  /// What the last run left at step t. Computes its segment again where `history` does not hold it.
  /// x() and the weights are then those of the end of that segment.
  /// @pre the run did not fail and neither model, guide nor history was used otherwise since
  const Slice<S>& at(History<S>& history, int t);

  // The steps of a run, for those who write their own loop, as online estimation does:
  //   start, then for t = 0, 1, ..: weigh(t), and but for the last move(t)

  /// Draws x_0.
  void start();
  /// Takes in what the guide weighs at t; nothing when all weights vanish.
  std::optional<WeightSum> weigh(int t, Slice<S>* slice = nullptr);
  /// Resamples if due, and draws x_{t+1}.
  void move(int t, Slice<S>* slice = nullptr);
  /// Draws x_{t+1} from given ancestors (N); all log weights are -log N after.
  void move_from(int t, std::span<const int> ancestors, Slice<S>* slice = nullptr);
  /// Puts a particle at x (n).
  void place(int particle, std::span<const double> x);
  /// State of the filter before weigh(t), from which it continues later: to the last bit, whatever
  /// was run in between. Saving into a state saved before does not allocate.
  void save(FilterState<S>& state) const;
  void restore(const FilterState<S>& state);
  /// The random numbers of the next run.
  void set_sequence(std::uint32_t sequence) { options_.sequence = sequence; }

  const Cloud<S>& x() const { return x_; }
  /// Log weights of x(): normalised after weigh; after move what they carry on from t.
  std::span<const double> log_weights() const { return first(log_weights_); }
  /// Normalised weights as of the last weigh.
  std::span<const double> weights() const { return first(weights_); }
  /// Ancestors at t of the particles that the last move drew at t + 1.
  std::span<const int> ancestors() const { return first(ancestors_); }

 private:
  template <class T>
  std::span<T> first(std::vector<T>& v) const {
    return std::span<T>(v).first(static_cast<std::size_t>(options_.particles));
  }
  template <class T>
  std::span<const T> first(const std::vector<T>& v) const {
    return std::span<const T>(v).first(static_cast<std::size_t>(options_.particles));
  }
  std::uint64_t stream(int t) const {
    return stream_of(Purpose::kFilter, options_.sequence, static_cast<std::uint32_t>(t));
  }
  void draw_noise(int t) { fill_normal(options_.seed, stream(t), noise_); }
  const S* noise_of(int b);
  void level_weights();
  void draw_ancestors(int t);
  void draw_next(int t, Slice<S>* slice);
  void record_innovation(int t, Report& report);
  int count_roots();

  M* model_;
  G* guide_;
  FilterOptions options_;
  InnovationMonitor<S> innovations_;
  int n_, stride_;
  Cloud<S> x_, image_;
  std::vector<S> temporary_;  // noise and image of one block
  std::vector<float> noise_;  // (n, stride)
  std::vector<double> uniforms_;
  std::vector<int> ancestors_, roots_, old_roots_, copies_;
  std::vector<double> log_weights_, past_log_weights_, weights_, past_weights_;
  double ess_ = 0;
  bool resampled_ = false;
};

}  // namespace fricid::smc

#include "fricid/smc/detail/particle_filter_impl.hpp"
