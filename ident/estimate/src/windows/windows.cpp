#include "fricid/estimate/windows/windows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/base/math.hpp"

namespace fricid::estimate {
namespace {

const RowMatrix& logged_q(const signals::Recording& r) { return r.log.q; }
const RowMatrix& wide_q(const signals::Recording& r) { return r.wide.q; }
const RowMatrix& wide_v(const signals::Recording& r) { return r.wide.v; }
const RowMatrix& held_tau(const signals::Recording& r) { return r.held_tau; }
const RowMatrix& temperature(const signals::Recording& r) { return r.temperature; }

}  // namespace

template <class S>
WindowRollout<S>::WindowRollout(const Arm& arm, std::span<const signals::Recording> recordings,
                                StepOptions step, int steps, ErrorScales scales)
    : arm_(arm),
      recordings_(recordings),
      stepper_(arm, step),
      steps_(steps),
      n_(arm.robot.n()),
      nz_(arm.friction.model.state_size()),
      scales_(scales) {
  const auto n = static_cast<std::size_t>(n_), nz = static_cast<std::size_t>(nz_);
  const auto leaps = static_cast<std::size_t>(stepper_.leaps() * steps + 1);
  history_.resize(leaps * (2 * n + nz));
  slope_.resize(static_cast<std::size_t>(steps) * 2 * n);
  root_.resize(slope_.size());
  for (auto* x : {&tau_, &temperature_, &target_, &q_bar_, &v_bar_}) x->resize(n);
  z_bar_.resize(nz);
  pi_.resize(static_cast<std::size_t>(arm.robot.parameter_count()));
  theta_.resize(arm.friction.theta.size());
  pi_bar_.resize(pi_.size());
  theta_bar_.resize(theta_.size());
  square_.resize(static_cast<std::size_t>(lanes()));
  fallen_.resize(square_.size());
  windows_.reserve(square_.size());
}

template <class S>
void WindowRollout<S>::set_parameters(std::span<const double> pi, std::span<const double> theta) {
  for (std::size_t i = 0; i < pi.size(); ++i) pi_[i] = S(pi[i]);
  for (std::size_t i = 0; i < theta.size(); ++i) theta_[i] = S(theta[i]);
  stepper_.set_parameters(pi_, theta_);
}

template <class S>
auto WindowRollout<S>::frame(int leap) -> Frame {
  const auto n = static_cast<std::size_t>(n_), nz = static_cast<std::size_t>(nz_);
  S* at = history_.data() + static_cast<std::size_t>(leap) * (2 * n + nz);
  return {{at, n}, {at + n, n}, {at + 2 * n, nz}};
}

/// Row `step` of a signal in every window; unused lanes repeat the first window.
template <class S>
void WindowRollout<S>::gather(Signal signal, int step, std::vector<S>& out) const {
  using Number = decltype(lane(S(), 0));
  for (int k = 0; k < lanes(); ++k) {
    const Window& w = windows_[k < std::ssize(windows_) ? static_cast<std::size_t>(k) : 0];
    const auto row = signal(recordings_[static_cast<std::size_t>(w.recording)]).row(w.begin + step);
    for (int j = 0; j < n_; ++j)
      set_lane(out[static_cast<std::size_t>(j)], k, static_cast<Number>(row[j]));
  }
}

template <class S>
double WindowRollout<S>::loss(std::span<const Window> windows, std::span<const RowMatrix> z) {
  using Number = decltype(lane(S(), 0));
  windows_.assign(windows.begin(), windows.end());
  const double dt = recordings_.front().dt;
  const int leaps = stepper_.leaps();

  Frame x = frame(0);
  gather(wide_q, 0, target_);
  std::copy(target_.begin(), target_.end(), x.q.begin());
  gather(wide_v, 0, target_);
  std::copy(target_.begin(), target_.end(), x.v.begin());
  for (int k = 0; k < lanes(); ++k) {
    const Window& w = windows_[k < std::ssize(windows_) ? static_cast<std::size_t>(k) : 0];
    const auto row = z[static_cast<std::size_t>(w.recording)].row(w.begin);
    for (int i = 0; i < nz_; ++i)
      set_lane(x.z[static_cast<std::size_t>(i)], k, static_cast<Number>(row[i]));
  }

  S sum(0), square(0);
  const S share(1.0 / (steps_ * n_)), s_q(1 / scales_.q), s_v(1 / scales_.v);
  const auto n = static_cast<std::size_t>(n_);
  for (int step = 0; step < steps_; ++step) {
    gather(held_tau, step, tau_);
    gather(temperature, step, temperature_);
    for (int l = 0; l < leaps; ++l) {
      const Frame before = frame(step * leaps + l);
      x = frame(step * leaps + l + 1);
      std::copy(before.q.begin(), before.q.end(), x.q.begin());
      std::copy(before.v.begin(), before.v.end(), x.v.begin());
      std::copy(before.z.begin(), before.z.end(), x.z.begin());
      stepper_.leap(tau_, temperature_, dt, x.q, x.v, x.z);
    }
    const std::size_t at = static_cast<std::size_t>(step) * 2 * n;
    const auto add = [&](const std::vector<S>& target, std::span<S> value, S scale, std::size_t out,
                         bool is_position) {
      for (std::size_t j = 0; j < n; ++j) {
        const S e = value[j] - target[j];
        const auto known = target[j] == target[j];
        const S r = select(known, e * scale, S(0));
        const S root = sqrt(S(1) + r * r);
        // rho without the cancellation of sqrt(1 + r^2) - 1
        sum += share * r * r / (root + S(1));
        slope_[out + j] = share * scale * r / root;
        root_[out + j] = select(known, scale * sqrt(share / root), S(0));
        if (is_position) square += share * select(known, e * e, S(0));
      }
    };
    gather(logged_q, step + 1, target_);
    add(target_, x.q, s_q, at, true);
    gather(wide_v, step + 1, target_);
    add(target_, x.v, s_v, at + n, false);
  }

  double total = 0;
  for (int k = 0; k < lanes(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double value = lane(sum, k);
    fallen_[i] = !std::isfinite(value) || value > kFallen;
    square_[i] = fallen_[i] ? std::numeric_limits<double>::infinity() : lane(square, k);
    if (k < std::ssize(windows_)) total += fallen_[i] ? kFallen : value;
  }
  return total;
}

/// Adjoints of the parameters in every lane, from those of q and v at every sample.
template <class S>
void WindowRollout<S>::sweep(const std::vector<S>& slope) {
  const auto n = static_cast<std::size_t>(n_);
  const double dt = recordings_.front().dt;
  const int leaps = stepper_.leaps();
  for (auto* x : {&q_bar_, &v_bar_, &z_bar_, &pi_bar_, &theta_bar_})
    std::fill(x->begin(), x->end(), S(0));
  for (int step = steps_; step-- > 0;) {
    gather(held_tau, step, tau_);
    gather(temperature, step, temperature_);
    const S* at = slope.data() + static_cast<std::size_t>(step) * 2 * n;
    for (std::size_t j = 0; j < n; ++j) {
      q_bar_[j] += at[j];
      v_bar_[j] += at[n + j];
    }
    for (int l = leaps; l-- > 0;) {
      const Frame x = frame(step * leaps + l);
      stepper_.leap_pullback(tau_, temperature_, dt, x.q, x.v, x.z, q_bar_, v_bar_, z_bar_, pi_bar_,
                             theta_bar_);
    }
  }
}

template <class S>
void WindowRollout<S>::add_gradient(std::span<double> pi_bar, std::span<double> theta_bar) {
  sweep(slope_);
  const auto add = [&](const std::vector<S>& lanes_bar, std::span<double> bar) {
    for (std::size_t i = 0; i < bar.size(); ++i)
      for (int k = 0; k < std::ssize(windows_); ++k)
        if (!fallen_[static_cast<std::size_t>(k)]) bar[i] += lane(lanes_bar[i], k);
  };
  add(pi_bar_, pi_bar);
  add(theta_bar_, theta_bar);
}

template <class S>
void WindowRollout<S>::curvature_samples(Rng& rng, Eigen::Ref<Eigen::MatrixXd> pi_bar,
                                         Eigen::Ref<Eigen::MatrixXd> theta_bar) {
  for (S& root : root_)
    for (int k = 0; k < lanes(); ++k)
      if (rng.uniform() < 0.5) set_lane(root, k, -lane(root, k));
  sweep(root_);
  const auto columns = [&](const std::vector<S>& lanes_bar, Eigen::Ref<Eigen::MatrixXd> bar) {
    for (Eigen::Index k = 0; k < bar.cols(); ++k) {
      const bool fallen = fallen_[static_cast<std::size_t>(k)];
      for (Eigen::Index i = 0; i < bar.rows(); ++i)
        bar(i, k) = fallen ? 0 : lane(lanes_bar[static_cast<std::size_t>(i)], static_cast<int>(k));
    }
  };
  columns(pi_bar_, pi_bar);
  columns(theta_bar_, theta_bar);
}

template <class S>
double WindowRollout<S>::mean_square(int k) const {
  return square_[static_cast<std::size_t>(k)];
}

template class WindowRollout<PackD>;
template class WindowRollout<PackF>;

}  // namespace fricid::estimate
