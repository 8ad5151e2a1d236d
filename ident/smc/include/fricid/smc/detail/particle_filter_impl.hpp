// Included by particle_filter.hpp.
#pragma once

namespace fricid::smc {

template <StateSpaceModel M, Guide G>
auto ParticleFilter<M, G>::noise_of(int b) -> const S* {
  for (int i = 0; i < n_; ++i) {
    temporary_[static_cast<std::size_t>(i)] =
        load<S>(noise_.data() + i * stride_ + b * kLaneCount<S>);
  }
  return temporary_.data();
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::start() {
  draw_noise(0);
  for (int b = 0; b < x_.blocks(); ++b) guide_->start(noise_of(b), x_.block(b));
  const auto N = static_cast<std::size_t>(particles());
  std::fill(log_weights_.begin(), log_weights_.end(), -std::numeric_limits<double>::infinity());
  level_weights();
  for (std::size_t i = 0; i < roots_.size(); ++i) roots_[i] = i < N ? static_cast<int>(i) : 0;
  resampled_ = false;
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::level_weights() {
  const auto N = static_cast<std::size_t>(particles());
  std::fill_n(log_weights_.begin(), N, -std::log(static_cast<double>(N)));
}

template <StateSpaceModel M, Guide G>
std::optional<WeightSum> ParticleFilter<M, G>::weigh(int t, Slice<S>* slice) {
  constexpr int kLanes = kLaneCount<S>;
  const bool has_next = t + 1 < steps();
  const bool wants_past = slice != nullptr || options_.y != nullptr;
  guide_->prepare(t);
  for (int b = 0; b < x_.blocks(); ++b) {
    const S* x = x_.block(b);
    S* F = nullptr;
    if (has_next) {
      F = image_.block(b);
      std::copy_n(x, n_, F);
      model_->transition(t, std::span<S>(F, static_cast<std::size_t>(n_)));
    }
    const LogWeight<S> gained = guide_->log_weight(x, F, wants_past);
    // lanes past N carry -inf, whatever they gain
    const int lanes = std::min(kLanes, particles() - b * kLanes);
    double* const log_weights = log_weights_.data() + b * kLanes;
    double* const past = past_log_weights_.data() + b * kLanes;
    if (wants_past)
      for (int k = 0; k < lanes; ++k)
        past[k] = log_weights[k] + static_cast<double>(lane(gained.past, k));
    for (int k = 0; k < lanes; ++k) log_weights[k] += static_cast<double>(lane(gained.total, k));
  }
  const auto sum = normalise(first(log_weights_), weights_);
  if (!sum) return {};
  for (double& lw : log_weights_) lw -= sum->log_sum;
  ess_ = sum->ess;
  if (slice != nullptr) {
    slice->x = x_;
    if (has_next) slice->image = image_;
    slice->log_weights = has_next ? past_log_weights_ : log_weights_;
  }
  return sum;
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::draw_ancestors(int t) {
  const auto N = static_cast<std::size_t>(particles());
  resampled_ = ess_ < options_.ess_threshold * static_cast<double>(N);
  const std::span<int> drawn = std::span(ancestors_).first(N);
  if (resampled_) {
    fill_uniform(options_.seed, stream(t), 0, uniforms_);
    const int renewed = static_cast<int>(options_.renewed * static_cast<double>(N));
    if (renewed + 1 < particles()) {
      split_heaviest(first(weights_), renewed, uniforms_[0], drawn, first(log_weights_),
                     first(copies_));
      for (double& w : first(log_weights_)) w = std::log(w);
    } else {
      resample(options_.resampling, first(weights_), uniforms_, drawn);
      level_weights();
    }
  } else {
    std::iota(drawn.begin(), drawn.end(), 0);
  }
  // empty lanes follow the last particle, lest they wander off on their own
  std::fill(ancestors_.begin() + particles(), ancestors_.end(), drawn.back());
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::move(int t, Slice<S>* slice) {
  draw_ancestors(t);
  draw_next(t, slice);
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::move_from(int t, std::span<const int> ancestors, Slice<S>* slice) {
  std::copy(ancestors.begin(), ancestors.end(), ancestors_.begin());
  resampled_ = true;
  level_weights();
  draw_next(t, slice);
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::place(int particle, std::span<const double> x) {
  for (int i = 0; i < n_; ++i) {
    x_.set(particle, i, static_cast<Real<S>>(x[static_cast<std::size_t>(i)]));
  }
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::draw_next(int t, Slice<S>* slice) {
  draw_noise(t + 1);
  for (int b = 0; b < x_.blocks(); ++b) {
    const S* F = image_.block(b);
    if (resampled_ || b + 1 == x_.blocks()) {
      S* copy = temporary_.data() + n_;
      image_.gather(b, ancestors_, copy);
      F = copy;
    }
    guide_->move(F, noise_of(b), x_.block(b));
  }
  if (resampled_) {
    old_roots_.swap(roots_);
    for (std::size_t i = 0; i < roots_.size(); ++i) {
      roots_[i] = old_roots_[static_cast<std::size_t>(ancestors_[i])];
    }
  }
  if (slice != nullptr) slice->ancestors = ancestors_;
}

template <StateSpaceModel M, Guide G>
int ParticleFilter<M, G>::count_roots() {
  const auto N = static_cast<std::size_t>(particles());
  std::fill(old_roots_.begin(), old_roots_.end(), 0);
  int count = 0;
  for (std::size_t i = 0; i < N; ++i) {
    int& met = old_roots_[static_cast<std::size_t>(roots_[i])];
    count += met == 0 ? 1 : 0;
    met = 1;
  }
  return count;
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::save(FilterState<S>& state) const {
  state.x = x_;
  state.log_weights = log_weights_;
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::restore(const FilterState<S>& state) {
  x_ = state.x;
  log_weights_ = state.log_weights;
}

template <StateSpaceModel M, Guide G>
void ParticleFilter<M, G>::run(Report& report, History<S>* history) {
  const int T = steps();
  report.reset(T, particles());
  report.log_likelihood = guide_->log_start();
  if (!std::isfinite(report.log_likelihood)) return;
  start();
  if (options_.y != nullptr) {
    innovations_.start(row_of(*options_.y, 0));
    innovations_.add_to(report);
  }
  for (int t = 0; t < T; ++t) {
    if (history != nullptr && t % history->interval() == 0) {
      history->held = history->segment_of(t);
      save(history->checkpoint(history->held));
    }
    Slice<S>* slice = history != nullptr ? &history->slice(t) : nullptr;
    const auto sum = weigh(t, slice);
    if (!sum) {
      report.log_likelihood = -std::numeric_limits<double>::infinity();
      return;
    }
    report.log_likelihood += sum->log_sum;
    report.ess[static_cast<std::size_t>(t)] = sum->ess;
    report.steps = t + 1;
    if (t + 1 == T) break;
    if (options_.y != nullptr) {
      normalise(first(past_log_weights_), past_weights_);
      innovations_.predict(image_, first(past_weights_), row_of(*options_.y, t + 1));
      innovations_.add_to(report);
    }
    move(t, slice);
    report.resampled += resampled_ ? 1 : 0;
  }
  report.distinct_roots = count_roots();
  report.failed = false;
}

template <StateSpaceModel M, Guide G>
auto ParticleFilter<M, G>::at(History<S>& history, int t) -> const Slice<S>& {
  const int segment = history.segment_of(t);
  if (segment != history.held) {
    restore(history.checkpoint(segment));
    history.held = segment;
    const int begin = segment * history.interval();
    const int end = std::min(begin + history.interval(), steps());
    for (int u = begin; u < end; ++u) {
      weigh(u, &history.slice(u));
      if (u + 1 < steps()) move(u, &history.slice(u));
    }
  }
  return history.slice(t);
}

}  // namespace fricid::smc
