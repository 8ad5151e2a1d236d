#include "fricid/estimate/em/transitions.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/eigen_instances.hpp"

namespace fricid::estimate {

TransitionLoss::TransitionLoss(const Arm& arm, std::span<const signals::Recording> recordings,
                               StepOptions step, std::span<const double> rigid_body_speed)
    : recordings_(recordings),
      stepper_(arm, step),
      n_(arm.robot.n()),
      nz_(arm.friction.model.state_size()),
      dt_(recordings.front().dt),
      coupling_(position_per_velocity(dt_, step.substeps)),
      rigid_body_speed_(Eigen::RowVectorXd::Zero(n_)),
      slow_(static_cast<std::size_t>(lanes())) {
  std::ranges::copy(rigid_body_speed, rigid_body_speed_.begin());
  const auto nx = static_cast<std::size_t>(2 * n_ + nz_);
  history_.resize(nx * static_cast<std::size_t>(stepper_.leaps() + 1));
  residual_.resize(nx);
  bar_.resize(nx);
  whitened_.resize(nx);
  tau_.resize(static_cast<std::size_t>(n_));
  temperature_.resize(tau_.size());
  pi_.resize(static_cast<std::size_t>(arm.robot.parameter_count()));
  theta_.resize(arm.friction.theta.size());
  pi_bar_.resize(pi_.size());
  theta_bar_.resize(theta_.size());
}

void TransitionLoss::set_parameters(std::span<const double> pi, std::span<const double> theta) {
  for (std::size_t i = 0; i < pi.size(); ++i) pi_[i] = PackD(pi[i]);
  for (std::size_t i = 0; i < theta.size(); ++i) theta_[i] = PackD(theta[i]);
  stepper_.set_parameters(pi_, theta_);
}

double TransitionLoss::loss(std::span<const Transition> transitions, std::span<const Paths> paths,
                            const LatentNoise& noise, std::span<double> squares) {
  count_ = static_cast<int>(transitions.size());
  const auto n = static_cast<std::size_t>(n_), nx = residual_.size();
  for (int k = 0; k < lanes(); ++k) {
    // unused lanes repeat the first transition
    const Transition& at = transitions[k < count_ ? static_cast<std::size_t>(k) : 0];
    const signals::Recording& r = recordings_[static_cast<std::size_t>(at.recording)];
    const smc::RowMatrix& x =
        paths[static_cast<std::size_t>(at.recording)][static_cast<std::size_t>(at.path)];
    for (std::size_t i = 0; i < nx; ++i) {
      history_[i].set(k, x(at.t, static_cast<Eigen::Index>(i)));
      residual_[i].set(k, x(at.t + 1, static_cast<Eigen::Index>(i)));
    }
    slow_[static_cast<std::size_t>(k)] =
        (x.row(at.t).segment(n_, n_).array().abs() < rigid_body_speed_.array()).any();
    for (std::size_t j = 0; j < n; ++j) {
      tau_[j].set(k, r.held_tau(at.t, static_cast<Eigen::Index>(j)));
      temperature_[j].set(k, r.temperature(at.t, static_cast<Eigen::Index>(j)));
    }
  }
  for (int l = 0; l < stepper_.leaps(); ++l) {
    const std::span from = std::span(history_).subspan(nx * static_cast<std::size_t>(l), nx);
    const std::span to = std::span(history_).subspan(nx * static_cast<std::size_t>(l + 1), nx);
    std::copy(from.begin(), from.end(), to.begin());
    stepper_.leap(tau_, temperature_, dt_, to.subspan(0, n), to.subspan(n, n), to.subspan(2 * n));
  }
  const std::span f = std::span(history_).last(nx);
  PackD sum(0);
  const auto weigh = [&](std::size_t i, const PackD& r, double variance) {
    const PackD slope = PackD(1 / variance) * r;
    whitened_[i] = PackD(1 / std::sqrt(variance)) * r;
    sum += PackD(0.5) * slope * r;
    if (!squares.empty())
      for (int k = 0; k < count_; ++k) squares[i] += r[k] * r[k];
    return slope;
  };
  for (std::size_t i = 0; i < nx; ++i) residual_[i] -= f[i];
  const PackD c(coupling_);
  for (std::size_t j = 0; j < n; ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const PackD slope = weigh(j, residual_[j] - c * residual_[n + j], noise.q[row]);
    bar_[j] = -slope;
    bar_[n + j] = c * slope - weigh(n + j, residual_[n + j], noise.v[row]);
  }
  for (std::size_t i = 2 * n; i < nx; ++i)
    bar_[i] = -weigh(i, residual_[i], noise.z[static_cast<Eigen::Index>(i - 2 * n)]);
  double total = 0;
  for (int k = 0; k < count_; ++k) total += sum[k];
  return total;
}

/// Pulls `bar` of x_{t+1} back through the step; parameters' adjoints are then in pi_bar_,
/// theta_bar_.
void TransitionLoss::pull(std::span<PackD> bar) {
  const auto n = static_cast<std::size_t>(n_), nx = bar.size();
  std::fill(pi_bar_.begin(), pi_bar_.end(), PackD(0));
  std::fill(theta_bar_.begin(), theta_bar_.end(), PackD(0));
  for (int l = stepper_.leaps(); l-- > 0;) {
    const std::span x =
        std::span<const PackD>(history_).subspan(nx * static_cast<std::size_t>(l), nx);
    stepper_.leap_pullback(tau_, temperature_, dt_, x.subspan(0, n), x.subspan(n, n),
                           x.subspan(2 * n), bar.subspan(0, n), bar.subspan(n, n),
                           bar.subspan(2 * n), pi_bar_, theta_bar_);
  }
}

void TransitionLoss::add_gradient(std::span<double> pi_bar, std::span<double> theta_bar) {
  pull(bar_);
  for (std::size_t i = 0; i < pi_bar.size(); ++i)
    for (int k = 0; k < count_; ++k)
      if (!slow_[static_cast<std::size_t>(k)]) pi_bar[i] += pi_bar_[i][k];
  for (std::size_t i = 0; i < theta_bar.size(); ++i)
    for (int k = 0; k < count_; ++k) theta_bar[i] += theta_bar_[i][k];
}

void TransitionLoss::add_normal_equations(const Eigen::MatrixXd& parameters_of,
                                          const LatentNoise& noise, Eigen::MatrixXd& JJ,
                                          Eigen::VectorXd& Jw) {
  const auto n = static_cast<std::size_t>(n_), nx = bar_.size();
  const Eigen::Index rows = static_cast<Eigen::Index>(nx) * count_;
  const auto pi_size = static_cast<Eigen::Index>(pi_bar_.size());
  Eigen::MatrixXd physical(rows, parameters_of.rows());
  Eigen::VectorXd w(rows);
  for (std::size_t i = 0; i < nx; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    std::fill(bar_.begin(), bar_.end(), PackD(0));
    // w_q = (e_q - c e_v) / sd, the others e / sd, with e = x' - f
    if (i < n) {
      const double sd = std::sqrt(noise.q[row]);
      bar_[i] = PackD(-1 / sd);
      bar_[n + i] = PackD(coupling_ / sd);
    } else {
      const auto from = static_cast<Eigen::Index>(i < 2 * n ? i - n : i - 2 * n);
      bar_[i] = PackD(-1 / std::sqrt(i < 2 * n ? noise.v[from] : noise.z[from]));
    }
    pull(bar_);
    for (int k = 0; k < count_; ++k) {
      const Eigen::Index at = row * count_ + k;
      w[at] = whitened_[i][k];
      for (Eigen::Index p = 0; p < physical.cols(); ++p)
        physical(at, p) = p >= pi_size ? theta_bar_[static_cast<std::size_t>(p - pi_size)][k]
                          : slow_[static_cast<std::size_t>(k)]
                              ? 0
                              : pi_bar_[static_cast<std::size_t>(p)][k];
    }
  }
  const Eigen::MatrixXd J = physical * parameters_of;
  JJ.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose());
  Jw.noalias() += J.transpose() * w;
}

}  // namespace fricid::estimate
