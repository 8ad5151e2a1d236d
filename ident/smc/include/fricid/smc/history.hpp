#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

#include "fricid/smc/lanes.hpp"

namespace fricid::smc {

/// One step of a filter as the smoothers need it. Lanes past N have no meaning.
template <class S>
struct Slice {
  Cloud<S> x;                       ///< particles x_t
  Cloud<S> image;                   ///< F = f_t(x_t), not valid at the last step
  std::vector<double> log_weights;  ///< (N) of x_t given y_0 .. y_t alone, up to a constant
  std::vector<int> ancestors;       ///< (N) of the particles at t + 1, not valid at the last step
};

/// All that a filter carries from one step to the next: particles and their log weights, (N).
template <class S>
struct FilterState {
  Cloud<S> x;
  std::vector<double> log_weights;
};

/// Particles of a whole run, owned by the caller, used again by run after run.
///
/// With an interval of K steps only one segment of K slices is held, and the state of the filter at
/// the first step of every segment; ParticleFilter::at computes a segment again when it is asked
/// for, from the same random numbers and hence to the same bytes. K = T holds all, K near sqrt(T)
/// needs the least memory, O(N sqrt T), at the price of a second forward pass.
template <class S>
class History {
 public:
  /// @param interval  K in [1, T]
  History(int state_size, int particles, int steps, int interval)
      : steps_(steps), interval_(interval) {
    assert(interval >= 1 && interval <= steps);
    const auto count = static_cast<std::size_t>(padded(particles));
    const Cloud<S> cloud(state_size, particles);
    slices_.resize(static_cast<std::size_t>(interval),
                   {cloud, cloud, std::vector<double>(count), std::vector<int>(count)});
    const int segments = (steps + interval - 1) / interval;
    checkpoints_.resize(static_cast<std::size_t>(segments), {cloud, std::vector<double>(count)});
  }
  /// Holds every step: O(N T).
  static History full(int state_size, int particles, int steps) {
    return History(state_size, particles, steps, steps);
  }
  /// O(N sqrt T).
  static History checkpointed(int state_size, int particles, int steps) {
    const int root = static_cast<int>(std::ceil(std::sqrt(2.0 * steps)));
    return History(state_size, particles, steps, std::clamp(root, 1, steps));
  }

  int steps() const { return steps_; }
  int interval() const { return interval_; }
  int segment_of(int t) const { return t / interval_; }
  Slice<S>& slice(int t) { return slices_[static_cast<std::size_t>(t % interval_)]; }
  FilterState<S>& checkpoint(int segment) {
    return checkpoints_[static_cast<std::size_t>(segment)];
  }

  int held = -1;  ///< the segment whose slices are held

 private:
  int steps_, interval_;
  std::vector<Slice<S>> slices_;
  std::vector<FilterState<S>> checkpoints_;
};

}  // namespace fricid::smc
