#include "fricid/estimate/online/online.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/base/error.hpp"
#include "fricid/estimate/em/latent_friction_model.hpp"
#include "fricid/estimate/online/online_state.hpp"
#include "fricid/smc/guides.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "support.hpp"

namespace fricid::estimate {

namespace {

/// Mean square of the errors of the best foretold sample, in its standard deviations, beyond which
/// a filter is lost.
constexpr double kLost = 100;

}  // namespace

smc::Gaussian online_start(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                           const Eigen::VectorXd& z, const LatentNoise& noise, double v_sd,
                           const Eigen::VectorXd& z_sd) {
  const Eigen::Index n = q.size(), nz = z.size();
  smc::Gaussian x;
  x.mean.resize(2 * n + nz);
  x.mean << q, v, z;
  Eigen::VectorXd variance(2 * n + nz);
  variance << 4 * noise.R.head(n), Eigen::VectorXd::Constant(n, v_sd * v_sd), z_sd.cwiseAbs2();
  x.covariance = variance.asDiagonal();
  return x;
}

/// The filter on a model, an observation and a torque of one row each, overwritten every sample.
struct OnlineEstimator::Filter {
  using Guide = smc::AdaptedGuide<PackD>;

  Arm arm;
  signals::Recording held;
  smc::RowMatrix y;
  LatentFrictionModel model;
  Guide guide;
  smc::ParticleFilter<LatentFrictionModel, Guide> filter;
  OnlineEstimate out;
  int t = 0;
  std::vector<PackD> tau_f;
  Eigen::VectorXd sum, squares;  // weighted, of [q, v, z, tau_f] about the reference
  Eigen::VectorXd reference;
  Eigen::VectorXd last_y;  // (n) [rad], NaN where missing
  std::vector<double> placed;
  Eigen::VectorXd law_sd;  // of the friction torque about the law [N m]

  static signals::Recording ring(const Arm& arm, double dt) {
    const int n = arm.robot.n();
    signals::Recording held;
    held.log.name = "online";
    held.dt = dt;
    held.wide.q = held.held_tau = RowMatrix::Zero(1, n);
    held.temperature = RowMatrix::Constant(1, n, kRoomTemperature);
    return held;
  }

  Filter(Arm an_arm, const LatentNoise& noise, const smc::Gaussian& start,
         const OnlineOptions& options)
      : arm(std::move(an_arm)),
        held(ring(arm, noise.dt)),
        y(smc::RowMatrix::Constant(1, noise.R.size(), std::numeric_limits<double>::quiet_NaN())),
        model(arm, held, noise, start, options.step),
        guide(model, y, std::numeric_limits<int>::max()),
        filter(model, guide, {.particles = options.particles, .seed = options.seed}),
        last_y(start.mean.head(arm.robot.n())),
        placed(static_cast<std::size_t>(model.state_size())),
        law_sd(noise.friction.size() > 0 ? noise.friction.cwiseSqrt().eval()
                                         : Eigen::VectorXd::Zero(arm.robot.n())) {
    const Eigen::Index n = arm.robot.n(), nz = arm.friction.model.state_size();
    tau_f.resize(static_cast<std::size_t>(n));
    for (auto* part : {&out.q, &out.v, &out.tau_f, &out.q_sd, &out.v_sd, &out.tau_f_sd})
      part->setZero(n);
    for (auto* part : {&out.z, &out.z_sd}) part->setZero(nz);
    sum.resize(3 * n + nz);
    squares.resize(3 * n + nz);
    reference.resize(3 * n + nz);
    begin();
  }

  void begin() {
    t = 0;
    last_y = model.initial().mean.head(last_y.size());
    filter.start();
    out.log_likelihood = guide.log_start();
    out.lost = false;
    out.ess = filter.particles();
    summarise();
  }

  bool is_lost(double log_weight) const {
    return log_weight < guide.largest_log_weight() - 0.5 * kLost * guide.present();
  }

  /// Shifts the particles to the positions measured last and the velocity between them and those
  /// before; the friction states go on from where they were, driven by that motion.
  void follow() {
    summarise();
    const Eigen::Index n = last_y.size();
    for (int i = 0; i < filter.particles(); ++i) {
      const PackD* state = filter.x().block(i / PackD::kLanes);
      for (std::size_t c = 0; c < placed.size(); ++c) placed[c] = state[c][i % PackD::kLanes];
      for (Eigen::Index j = 0; j < n; ++j) {
        const double now = y(0, j), v = (now - last_y[j]) / held.dt;
        if (std::isfinite(now)) placed[static_cast<std::size_t>(j)] += now - out.q[j];
        if (std::isfinite(v)) placed[static_cast<std::size_t>(n + j)] += v - out.v[j];
      }
      filter.place(i, placed);
    }
  }

  /// Means and standard deviations over the weighted particles.
  void summarise() {
    const auto n = static_cast<std::size_t>(arm.robot.n());
    const auto nx = static_cast<std::size_t>(model.state_size());
    const std::span<const double> log_weights = filter.log_weights();
    const int blocks = filter.x().blocks();
    sum.setZero();
    squares.setZero();
    double total = 0;
    for (int b = 0; b < blocks; ++b) {
      const PackD* state = filter.x().block(b);
      model.friction_torque<PackD>(t, {state, nx}, tau_f);
      for (int k = 0; k < PackD::kLanes; ++k) {
        const auto i = static_cast<std::size_t>(b * PackD::kLanes + k);
        if (i >= log_weights.size()) break;
        const double w = std::exp(log_weights[i]);
        total += w;
        for (std::size_t c = 0; c < nx + n; ++c) {
          const auto row = static_cast<Eigen::Index>(c);
          const double value = c < nx ? state[c][k] : tau_f[c - nx][k];
          if (i == 0) reference[row] = value;
          const double d = value - reference[row];
          sum[row] += w * d;
          squares[row] += w * d * d;
        }
      }
    }
    sum /= total;
    squares = (squares / total - sum.cwiseAbs2()).cwiseMax(0).cwiseSqrt();
    sum += reference;
    const auto joints = static_cast<Eigen::Index>(n);
    const Eigen::Index nz = out.z.size();
    out.q = sum.head(joints);
    out.v = sum.segment(joints, joints);
    out.z = sum.segment(2 * joints, nz);
    out.tau_f = sum.tail(joints);
    out.q_sd = squares.head(joints);
    out.v_sd = squares.segment(joints, joints);
    out.z_sd = squares.segment(2 * joints, nz);
    for (Eigen::Index j = 0; j < joints; ++j)
      out.tau_f_sd[j] = std::hypot(squares[2 * joints + nz + j], law_sd[j]);
  }
};

OnlineEstimator::OnlineEstimator(Arm arm, const LatentNoise& noise, const smc::Gaussian& start,
                                 const OnlineOptions& options)
    : filter_(std::make_unique<Filter>(std::move(arm), noise, start, options)) {}
OnlineEstimator::~OnlineEstimator() = default;
OnlineEstimator::OnlineEstimator(OnlineEstimator&&) noexcept = default;

const OnlineEstimate& OnlineEstimator::estimate() const { return filter_->out; }

void OnlineEstimator::reset() { filter_->begin(); }

const OnlineEstimate& OnlineEstimator::step(std::span<const double> tau, std::span<const double> y,
                                            std::span<const double> temperature) {
  Filter& f = *filter_;
  assert(std::ssize(tau) == f.held.held_tau.cols() && std::ssize(y) == f.y.cols());
  std::copy(tau.begin(), tau.end(), f.held.held_tau.data());
  std::copy(y.begin(), y.end(), f.y.data());
  if (!temperature.empty())
    std::copy(temperature.begin(), temperature.end(), f.held.temperature.data());
  const auto weighed = f.filter.weigh(f.t);
  if (weighed) {
    f.out.log_likelihood += weighed->log_sum;
    f.out.ess = weighed->ess;
    f.filter.move(f.t);
  } else {
    f.out.log_likelihood = -std::numeric_limits<double>::infinity();
    f.out.ess = 0;
    f.filter.start();
  }
  f.out.lost = !weighed || f.is_lost(weighed->log_sum);
  if (f.out.lost) f.follow();
  f.last_y = f.y.row(0).head(f.last_y.size());
  ++f.t;
  f.summarise();
  return f.out;
}

void OnlineEstimator::save(State& state) const {
  filter_->filter.save(state.particles);
  state.estimate = filter_->out;
  state.last_y = filter_->last_y;
  state.t = filter_->t;
}

void OnlineEstimator::restore(const State& state) {
  filter_->filter.restore(state.particles);
  filter_->out = state.estimate;
  filter_->last_y = state.last_y;
  filter_->t = state.t;
}

}  // namespace fricid::estimate
