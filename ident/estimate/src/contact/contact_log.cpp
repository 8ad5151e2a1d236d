#include "fricid/estimate/contact/contact_log.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/estimate/contact/momentum_observer.hpp"
#include "fricid/estimate/online/log_start.hpp"
#include "fricid/estimate/online/online_log.hpp"
#include "fricid/signals/overview.hpp"
#include "fricid/system/transmission.hpp"
#include "missing.hpp"

namespace fricid::estimate {
namespace {

constexpr double kTimeConstants = 5;  // within which the low-pass settles
constexpr double kSlid = 1e-3;        // [rad or m] in a gap, beyond which friction has changed
constexpr double kSettling = 5e-3;    // [rad or m] of travel within which friction settles
constexpr double kRest = 0.5;         // [s] within so little travel: the arm stands
constexpr double kPlay = 2.5;         // standard deviations of the noise of an encoder

/// Which joints know their torque.
class Settling {
 public:
  /// At the first sample, a joint that moves not yet.
  Settling(const Eigen::RowVectorXd& q, const Eigen::RowVectorXd& v, double dt, double bandwidth_hz)
      : samples_(2 + std::ceil(kTimeConstants / (2 * std::numbers::pi * bandwidth_hz * dt))),
        begin_(q),
        travel_((v.array() == 0).select(0.0, Eigen::RowVectorXd::Constant(q.size(), kSettling))) {}

  /// The observer begins anew at q, `before` the last known positions.
  void begin(const Eigen::RowVectorXd& before, const Eigen::RowVectorXd& q) {
    since_ = 0;
    begin_ = q;
    travel_ = ((q - before).array().abs() < kSlid)
                  .select(0.0, Eigen::RowVectorXd::Constant(q.size(), kSettling));
  }
  void step(const Eigen::RowVectorXd& q) {
    ++since_;
    travel_ = ((q - begin_).array().abs() >= kSettling).select(0.0, travel_);
  }
  bool settled(Eigen::Index j) const { return since_ >= samples_ && travel_[j] == 0; }

 private:
  double samples_, since_ = 0;
  Eigen::RowVectorXd begin_, travel_;  // still to come from there
};

/// Positions without the noise of their encoders: they follow as through a play as wide as that.
class Followed {
 public:
  /// @param q  (T, n) of the whole log, missing values NaN  @param first  positions
  Followed(ConstRowMatrix q, const Eigen::RowVectorXd& first)
      : play_(q.cols()), at_(first.begin(), first.end()) {
    for (Eigen::Index j = 0; j < q.cols(); ++j)
      play_[j] = std::fmax(0, kPlay * signals::noise_of_differences(q.col(j)));
  }
  std::span<const double> step(const Eigen::RowVectorXd& q) {
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      double& at = at_[static_cast<std::size_t>(j)];
      at = std::clamp(at, q[j] - play_[j], q[j] + play_[j]);
    }
    return at_;
  }

 private:
  Eigen::RowVectorXd play_;
  std::vector<double> at_;
};

/// Whether the arm stands: no joint has left where it was for some time.
class Rest {
 public:
  explicit Rest(double dt) : samples_(kRest / dt) {}

  bool step(const Eigen::RowVectorXd& q) {
    const bool stays = at_.size() > 0 && (q - at_).cwiseAbs().maxCoeff() < kSettling;
    if (!stays) at_ = q;
    since_ = stays ? since_ + 1 : 0;
    return since_ >= samples_;
  }

 private:
  double samples_, since_ = 0;
  Eigen::RowVectorXd at_;
};

}  // namespace

data::ContactSignals observe_log(const data::ModelFile& model, const data::Dataset& at_joints,
                                 const ObserverOptions& options) {
  const int n = model.arm.robot.n(), T = at_joints.length();
  if (at_joints.n() != n)
    throw UserError("{}: {} joints, model {} has {}", at_joints.name, at_joints.n(), model.name, n);
  const Transmission motors(model.arm.robot);
  data::Dataset log = motors.to_motors(at_joints);
  if (options.bandwidth_hz > log.rate_hz / 2)
    throw UserError("{}: an observer of {:g} Hz; allowed: up to half the rate of the log, {:g} Hz",
                    log.name, options.bandwidth_hz, log.rate_hz / 2);
  if (log.temperature.size() == 0) log.temperature.setConstant(T, n, kRoomTemperature);
  hold_missing(log.temperature, kRoomTemperature);
  RowMatrix held_tau = log.tau, held_q = log.q;
  hold_missing(held_tau, 0);
  hold_missing(held_q, 0);

  data::ContactSignals out;
  out.joint_names = log.joint_names;
  out.model = model.name;
  out.log = log.name;
  out.t = log.t;
  out.tau_ext.setConstant(T, n, kNan);
  out.tau_f.setConstant(T, n, kNan);
  // the torque of a sample moves the arm to the next
  const auto is_whole = [&](int k) {
    return log.q.row(k).allFinite() && (k == 0 || log.tau.row(k - 1).allFinite());
  };
  int first = 0;
  while (first < T && !is_whole(first)) ++first;
  if (first == T) return out;
  const auto from_first = [&](const RowMatrix& x) { return x.bottomRows(T - first); };
  const LogStart start = log_start(model.arm, log.dt(), from_first(held_q), from_first(held_tau),
                                   from_first(log.temperature));
  MomentumObserver observer(model.arm, log.dt(), options.bandwidth_hz, start.z);
  std::optional<OnlineEstimator> filter;
  if (options.particles > 0)
    filter.emplace(begin_online(
        model, start, log.rate_hz,
        {.particles = options.particles, .step = {8, 4}, .seed = options.seed}, log.name));
  const auto row = [n](const RowMatrix& x, int k) {
    return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(n));
  };
  Settling settling(log.q.row(first), start.v, log.dt(), options.bandwidth_hz);
  Followed followed(log.q, log.q.row(first));
  Rest rest(log.dt());
  int last_whole = first - 1;
  for (int k = 0; k < T; ++k) {
    if (k % 1000 == 0) throw_if_stopped();
    const auto tau = row(held_tau, std::max(0, k - 1)), q = row(log.q, k),
               temperature = row(log.temperature, k);
    if (is_whole(k)) {
      if (last_whole != k - 1) {
        observer.restart();
        settling.begin(log.q.row(last_whole), log.q.row(k));
      }
      last_whole = k;
      settling.step(log.q.row(k));
      const std::span<const double> seen = followed.step(log.q.row(k));
      std::span<const double> r;
      // at rest the filter would take a push for friction, which holds the arm in both cases
      if (const bool rests = rest.step(log.q.row(k)); filter && !rests) {
        const Eigen::VectorXd& tau_f = filter->estimate().tau_f;  // at the sample before
        r = observer.step_with(tau, q, temperature, {tau_f.data(), static_cast<std::size_t>(n)},
                               seen);
      } else {
        r = observer.step(tau, q, temperature, seen);
      }
      for (int j = 0; j < n; ++j) {
        if (!settling.settled(j)) continue;
        out.tau_ext(k, j) = r[static_cast<std::size_t>(j)];
        out.tau_f(k, j) = observer.friction()[static_cast<std::size_t>(j)];
      }
    }
    if (filter && k > first) filter->step(tau, q, temperature);
  }
  if (motors.coupled()) {
    out.tau_ext = motors.torque_to_joints(out.tau_ext);
    out.tau_f = motors.torque_to_joints(out.tau_f);
  }
  return out;
}

}  // namespace fricid::estimate
