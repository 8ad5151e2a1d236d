#include "fricid/estimate/em/latent_friction_model.hpp"

#include <algorithm>

#include "fricid/base/error.hpp"

namespace fricid::estimate {
namespace {

constexpr int kMostPartLatents = 4;

/// The parts of a state [q, v, z].
template <class Span>
struct Parts {
  Span q, v, z;
};

template <class Span>
Parts<Span> split(Span x, int n) {
  const auto size = static_cast<std::size_t>(n);
  return {x.subspan(0, size), x.subspan(size, size), x.subspan(2 * size)};
}

}  // namespace

template <class S>
LatentFrictionModel::Lanes<S>::Lanes(const Arm& arm, StepOptions step)
    : stepper(arm, step), tau(static_cast<std::size_t>(arm.robot.n())), temperature(tau.size()) {
  const auto nx = static_cast<std::size_t>(2 * arm.robot.n() + arm.friction.model.state_size());
  history.resize(nx * static_cast<std::size_t>(stepper.leaps() + 1));
  bar.resize(nx);
}

template <>
LatentFrictionModel::Lanes<double>& LatentFrictionModel::lanes<double>() {
  return one_;
}
template <>
LatentFrictionModel::Lanes<PackD>& LatentFrictionModel::lanes<PackD>() {
  return wide_;
}
template <>
LatentFrictionModel::Lanes<PackF>& LatentFrictionModel::lanes<PackF>() {
  return narrow_;
}

LatentFrictionModel::LatentFrictionModel(const Arm& arm, const signals::Recording& recording,
                                         const LatentNoise& noise, smc::Gaussian initial,
                                         StepOptions step)
    : recording_(&recording),
      n_(arm.robot.n()),
      nz_(arm.friction.model.state_size()),
      initial_(std::move(initial)),
      Q_(noise.Q(step.substeps)),
      C_(Eigen::MatrixXd::Identity(noise.R.size(), 2 * n_ + nz_)),
      R_(noise.R.asDiagonal()),
      one_(arm, step),
      wide_(arm, step),
      narrow_(arm, step),
      broadcast_(static_cast<std::size_t>(2 * n_ + nz_)),
      pi_bar_(static_cast<std::size_t>(arm.robot.parameter_count())),
      theta_bar_(arm.friction.theta.size()) {
  if (recording.n() != n_)
    throw UserError("{}: {} joints, the robot has {}", recording.log.name, recording.n(), n_);
  if (Q_.rows() != state_size() || initial_.mean.size() != state_size() ||
      initial_.covariance.rows() != state_size() || initial_.covariance.cols() != state_size())
    throw UserError("latent model: Q has {} entries, the start {}, the state has {}", Q_.rows(),
                    initial_.mean.size(), state_size());
  if (noise.R.size() != n_ && noise.R.size() != 2 * n_)
    throw UserError("latent model: R has {} entries, allowed {} (q) or {} (q, v)", noise.R.size(),
                    n_, 2 * n_);
  const friction::RobotFriction& friction = arm.friction.model;
  for (int j = 0; j < n_; ++j) {
    smc::Part& part = parts_.emplace_back(smc::Part{{j, n_ + j}, n_ + j});
    const int z = friction.state_begin(j), end = friction.state_begin(j + 1);
    for (int i = z; i < std::min(end, z + kMostPartLatents); ++i) part.states.push_back(2 * n_ + i);
  }
}

/// Torque and temperature of sample t in every lane.
template <class S>
void LatentFrictionModel::hold(int t, Lanes<S>& lanes) const {
  const Eigen::Index row = t % recording_->held_tau.rows();
  for (int j = 0; j < n_; ++j) {
    const auto i = static_cast<std::size_t>(j);
    lanes.tau[i] = S(recording_->held_tau(row, j));
    lanes.temperature[i] = S(recording_->temperature(row, j));
  }
}

template <class S>
void LatentFrictionModel::transition(int t, std::span<S> x) {
  Lanes<S>& l = lanes<S>();
  hold(t, l);
  const auto [q, v, z] = split(x, n_);
  l.stepper.step(l.tau, l.temperature, recording_->dt, q, v, z);
}

/// The sample step, keeping the state at every leap.
template <class S>
void LatentFrictionModel::roll(int t, std::span<const S> x, Lanes<S>& l) {
  hold(t, l);
  std::copy(x.begin(), x.end(), l.history.begin());
  const std::size_t nx = x.size();
  for (int k = 0; k < l.stepper.leaps(); ++k) {
    const auto from = l.history.begin() + static_cast<std::ptrdiff_t>(nx) * k;
    std::copy_n(from, nx, from + static_cast<std::ptrdiff_t>(nx));
    const auto [q, v, z] =
        split(std::span(l.history).subspan(nx * static_cast<std::size_t>(k + 1), nx), n_);
    l.stepper.leap(l.tau, l.temperature, recording_->dt, q, v, z);
  }
}

/// Pulls l.bar back through the step that `roll` kept, adding up the parameters' adjoints.
template <class S>
void LatentFrictionModel::pull(Lanes<S>& l, std::span<S> pi_bar, std::span<S> theta_bar) {
  const std::size_t nx = l.bar.size();
  const auto [q_bar, v_bar, z_bar] = split(std::span(l.bar), n_);
  for (int k = l.stepper.leaps(); k-- > 0;) {
    const auto [q, v, z] =
        split(std::span<const S>(l.history).subspan(nx * static_cast<std::size_t>(k), nx), n_);
    l.stepper.leap_pullback(l.tau, l.temperature, recording_->dt, q, v, z, q_bar, v_bar, z_bar,
                            pi_bar, theta_bar);
  }
}

void LatentFrictionModel::linearise(int t, const Eigen::VectorXd& x, Eigen::VectorXd& f,
                                    Eigen::MatrixXd& A) {
  linearise(t, x, f, A, nullptr);
}

void LatentFrictionModel::linearise(int t, const Eigen::VectorXd& x, Eigen::VectorXd& f,
                                    Eigen::MatrixXd& A, Eigen::MatrixXd& B) {
  linearise(t, x, f, A, &B);
}

void LatentFrictionModel::linearise(int t, const Eigen::VectorXd& x, Eigen::VectorXd& f,
                                    Eigen::MatrixXd& A, Eigen::MatrixXd* B) {
  Lanes<PackD>& l = wide_;
  const int nx = state_size();
  for (int i = 0; i < nx; ++i) broadcast_[static_cast<std::size_t>(i)] = PackD(x[i]);
  roll<PackD>(t, broadcast_, l);
  f.resize(nx);
  A.resize(nx, nx);
  if (B) B->resize(nx, parameter_count());
  const auto last = l.history.end() - nx;
  for (int i = 0; i < nx; ++i) f[i] = last[i][0];
  for (int row = 0; row < nx; row += PackD::kLanes) {
    const int rows = std::min(PackD::kLanes, nx - row);
    std::fill(l.bar.begin(), l.bar.end(), PackD(0));
    for (int k = 0; k < rows; ++k) l.bar[static_cast<std::size_t>(row + k)].set(k, 1);
    if (B) {
      std::fill(pi_bar_.begin(), pi_bar_.end(), PackD(0));
      std::fill(theta_bar_.begin(), theta_bar_.end(), PackD(0));
      pull<PackD>(l, pi_bar_, theta_bar_);
    } else {
      pull(l);
    }
    for (int i = 0; i < nx; ++i)
      for (int k = 0; k < rows; ++k) A(row + k, i) = l.bar[static_cast<std::size_t>(i)][k];
    if (!B) continue;
    int column = 0;
    for (const auto* bar : {&pi_bar_, &theta_bar_})
      for (const PackD& lanes : *bar) {
        for (int k = 0; k < rows; ++k) (*B)(row + k, column) = lanes[k];
        ++column;
      }
  }
}

template <class S>
void LatentFrictionModel::jacobian(int t, std::span<const S> x, std::span<S> A) {
  Lanes<S>& l = lanes<S>();
  roll<S>(t, x, l);
  const std::size_t nx = x.size();
  for (std::size_t row = 0; row < nx; ++row) {
    std::fill(l.bar.begin(), l.bar.end(), S(0));
    l.bar[row] = S(1);
    pull(l);
    std::copy(l.bar.begin(), l.bar.end(), A.begin() + static_cast<std::ptrdiff_t>(row * nx));
  }
}

template <class S>
void LatentFrictionModel::friction_torque(int t, std::span<const S> x, std::span<S> tau_f) {
  Lanes<S>& l = lanes<S>();
  hold(t, l);
  const auto [q, v, z] = split(x, n_);
  l.stepper.friction_torque(l.tau, l.temperature, q, v, z, tau_f);
}

#define FRICID_INSTANTIATE_LATENT(S)                                                     \
  template void LatentFrictionModel::transition<S>(int, std::span<S>);                   \
  template void LatentFrictionModel::jacobian<S>(int, std::span<const S>, std::span<S>); \
  template void LatentFrictionModel::friction_torque<S>(int, std::span<const S>, std::span<S>);
FRICID_INSTANTIATE_LATENT(double)
FRICID_INSTANTIATE_LATENT(PackD)
FRICID_INSTANTIATE_LATENT(PackF)
#undef FRICID_INSTANTIATE_LATENT

}  // namespace fricid::estimate
