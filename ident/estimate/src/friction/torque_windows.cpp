#include "fricid/estimate/friction/torque_windows.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/math.hpp"

namespace fricid::estimate {

template <class S>
TorqueWindows<S>::TorqueWindows(const friction::RobotFriction& model, const TorqueData& data,
                                int steps, std::vector<double> scale, std::vector<double> response)
    : model_(model),
      data_(data),
      steps_(steps),
      n_(model.joint_count()),
      nz_(model.state_size()),
      scale_(std::move(scale)),
      response_(std::move(response)) {
  const auto n = static_cast<std::size_t>(n_), nz = static_cast<std::size_t>(nz_);
  const auto samples = static_cast<std::size_t>(steps + 2 * margin());
  theta_.resize(static_cast<std::size_t>(model.parameter_count()));
  theta_bar_.resize(theta_.size());
  z_.resize((samples + 1) * nz);
  tau_.resize(samples * n);
  slope_.resize(samples * n);
  z_bar_.resize(nz);
  z_next_bar_.resize(nz);
  in_.resize(n);
  in_bar_.resize(n);
  fallen_.resize(static_cast<std::size_t>(lanes()));
  windows_.reserve(fallen_.size());
}

template <class S>
void TorqueWindows<S>::set_parameters(std::span<const double> theta) {
  for (std::size_t i = 0; i < theta.size(); ++i) theta_[i] = S(theta[i]);
}

/// Row of a sample in its recording; unused lanes repeat the first window.
template <class S>
int TorqueWindows<S>::row(int lane, int sample) const {
  const std::size_t k = lane < std::ssize(windows_) ? static_cast<std::size_t>(lane) : 0;
  return windows_[k].begin - margin() + sample;
}

/// Inputs of the torque at a sample.
template <class S>
void TorqueWindows<S>::motion_at(int sample) {
  for (int k = 0; k < lanes(); ++k) {
    const std::size_t w = k < std::ssize(windows_) ? static_cast<std::size_t>(k) : 0;
    const signals::Recording& r = recording_of(windows_[w]);
    const signals::Motion& motion = r.motion(data_.band);
    const int at = row(k, sample);
    for (int j = 0; j < n_; ++j) {
      friction::Input<S>& in = in_[static_cast<std::size_t>(j)];
      set_lane(in.q, k, static_cast<Number>(motion.q(at, j)));
      set_lane(in.v, k, static_cast<Number>(motion.v(at, j)));
      set_lane(in.load, k, static_cast<Number>(r.held_tau(at, j)));
      set_lane(in.temperature, k, static_cast<Number>(r.temperature(at, j)));
    }
  }
}

/// Inputs of the step from a sample to the next.
template <class S>
void TorqueWindows<S>::motion_over(int sample) {
  motion_at(sample);
  for (int k = 0; k < lanes(); ++k) {
    const std::size_t w = k < std::ssize(windows_) ? static_cast<std::size_t>(k) : 0;
    const signals::Recording& r = recording_of(windows_[w]);
    const signals::Motion& motion = r.motion(data_.band);
    const int at = row(k, sample);
    for (int j = 0; j < n_; ++j) {
      friction::Input<S>& in = in_[static_cast<std::size_t>(j)];
      set_lane(in.q, k, static_cast<Number>(motion.q(at + 1, j)));
      set_lane(in.v, k, static_cast<Number>((motion.q(at + 1, j) - motion.q(at, j)) / r.dt));
    }
  }
}

template <class S>
double TorqueWindows<S>::loss(std::span<const Window> windows, std::span<const RowMatrix> z) {
  windows_.assign(windows.begin(), windows.end());
  const auto n = static_cast<std::size_t>(n_);
  const int samples = steps_ + 2 * margin();
  for (int k = 0; k < lanes(); ++k) {
    const std::size_t w = k < std::ssize(windows_) ? static_cast<std::size_t>(k) : 0;
    const auto from = z[static_cast<std::size_t>(windows_[w].recording)].row(row(k, 0));
    for (int i = 0; i < nz_; ++i) set_lane(state(0)[i], k, static_cast<Number>(from[i]));
  }
  for (int sample = 0; sample < samples; ++sample) {
    const std::span<S> now(state(sample), static_cast<std::size_t>(nz_));
    motion_at(sample);
    model_.template torque<S>(theta_, in_, now,
                              std::span<S>(tau_).subspan(static_cast<std::size_t>(sample) * n, n));
    if (nz_ == 0 || sample + 1 == samples) continue;
    const std::span<S> next(state(sample + 1), static_cast<std::size_t>(nz_));
    std::copy(now.begin(), now.end(), next.begin());
    motion_over(sample);
    model_.template step<S>(theta_, in_, data_.recordings.front().dt, next);
  }

  std::fill(slope_.begin(), slope_.end(), S(0));
  S sum(0);
  const S share(1.0 / (steps_ * n_));
  for (int step = 0; step < steps_; ++step) {
    const int centre = step + margin();
    for (int j = 0; j < n_; ++j) {
      S target(0), weight(0);
      for (int k = 0; k < lanes(); ++k) {
        const std::size_t w = k < std::ssize(windows_) ? static_cast<std::size_t>(k) : 0;
        if (!recording_of(windows_[w]).use(row(k, centre), j)) continue;
        const RowMatrix& wanted = data_.target[static_cast<std::size_t>(windows_[w].recording)];
        set_lane(target, k, static_cast<Number>(wanted(row(k, centre), j)));
        set_lane(weight, k, Number(1));
      }
      const auto tau = [&](int sample) -> const S& {
        return tau_[static_cast<std::size_t>(sample * n_ + j)];
      };
      S f = S(response_[0]) * tau(centre);
      for (int m = 1; m <= margin(); ++m)
        f += S(response_[static_cast<std::size_t>(m)]) * (tau(centre - m) + tau(centre + m));
      const S inverse(1 / scale_[static_cast<std::size_t>(j)]);
      const S e = weight * (f - target) * inverse;
      sum += share * e * e;
      const S f_bar = S(2) * share * weight * e * inverse;
      for (int m = -margin(); m <= margin(); ++m)
        slope_[static_cast<std::size_t>((centre + m) * n_ + j)] +=
            S(response_[static_cast<std::size_t>(std::abs(m))]) * f_bar;
    }
  }
  double total = 0;
  for (int k = 0; k < lanes(); ++k) {
    const double value = lane(sum, k);
    const bool fallen = !std::isfinite(value) || value > kFallen;
    fallen_[static_cast<std::size_t>(k)] = fallen;
    if (k < std::ssize(windows_)) total += fallen ? kFallen : value;
  }
  return total;
}

template <class S>
void TorqueWindows<S>::add_gradient(std::span<double> theta_bar) {
  const auto n = static_cast<std::size_t>(n_), nz = static_cast<std::size_t>(nz_);
  const int samples = steps_ + 2 * margin();
  std::fill(theta_bar_.begin(), theta_bar_.end(), S(0));
  std::fill(z_bar_.begin(), z_bar_.end(), S(0));
  const friction::Input<S> none{S(0), S(0), S(0), S(0)};  // motion is given, not differentiated
  for (int sample = samples; sample-- > 0;) {
    const std::span<const S> now(state(sample), nz);
    if (nz_ > 0 && sample + 1 < samples) {
      std::swap(z_bar_, z_next_bar_);
      std::fill(z_bar_.begin(), z_bar_.end(), S(0));
      std::fill(in_bar_.begin(), in_bar_.end(), none);
      motion_over(sample);
      model_.template step_pullback<S>(theta_, in_, data_.recordings.front().dt, now, z_next_bar_,
                                       theta_bar_, in_bar_, z_bar_);
    }
    std::fill(in_bar_.begin(), in_bar_.end(), none);
    motion_at(sample);
    model_.template torque_pullback<S>(
        theta_, in_, now,
        std::span<const S>(slope_).subspan(static_cast<std::size_t>(sample) * n, n), theta_bar_,
        in_bar_, z_bar_);
  }
  for (std::size_t i = 0; i < theta_bar.size(); ++i)
    for (int k = 0; k < std::ssize(windows_); ++k)
      if (!fallen_[static_cast<std::size_t>(k)]) theta_bar[i] += lane(theta_bar_[i], k);
}

template class TorqueWindows<PackD>;
template class TorqueWindows<PackF>;

}  // namespace fricid::estimate
