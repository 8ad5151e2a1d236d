#include "fricid/estimate/friction/torque_training.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/estimate/wash_out.hpp"
#include "fricid/optimise/adam.hpp"
#include "fricid/optimise/descent.hpp"
#include "support.hpp"
#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr int kWindowLanes = TorqueWindows<PackF>::lanes();
constexpr int kSamplesWorthThreads = 100;  // of a pack; below, starting threads takes longer

/// Root mean square of the target over the rows that count, per joint (n) [N m].
std::vector<double> target_sizes(const TorqueData& data) {
  std::vector<double> sizes;
  for (Eigen::Index j = 0; j < data.target.front().cols(); ++j) {
    double square = 0, rows = 0;
    for (std::size_t s = 0; s < data.target.size(); ++s) {
      const RowMatrix& target = data.target[s];
      for (Eigen::Index k = 0; k < target.rows(); ++k)
        if (data.recordings[s].use(k, j)) square += target(k, j) * target(k, j), rows += 1;
    }
    const double size = std::sqrt(square / std::max(1.0, rows));
    sizes.push_back(size > 0 ? size : 1);
  }
  return sizes;
}

std::vector<RowMatrix> states(const Arm& arm, const TorqueData& data, int jobs) {
  if (arm.friction.model.state_size() > 0) return wash_out(arm, data.recordings, jobs, data.band);
  std::vector<RowMatrix> none;
  for (const signals::Recording& r : data.recordings) none.emplace_back(r.length(), 0);
  return none;
}

/// Mean over joints of residual / target mean square on the held-out rows.
double held_out_share(const Arm& arm, const TorqueData& data, std::span<const RowMatrix> z,
                      const std::vector<int>& test_begin, const std::vector<double>& response,
                      int jobs) {
  const friction::RobotFriction& model = arm.friction.model;
  const int n = model.joint_count(), margin = static_cast<int>(response.size()) - 1;
  std::vector<Eigen::VectorXd> residual(data.target.size(), Eigen::VectorXd::Zero(n)),
      target = residual;
  parallel_for(static_cast<int>(data.target.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    const signals::Recording& r = data.recordings[s];
    const signals::Motion& motion = r.motion(data.band);
    const int T = r.length(), first = test_begin[s] - margin;
    RowMatrix tau(T, n);
    std::vector<friction::Input<double>> in(static_cast<std::size_t>(n));
    for (int k = std::max(0, first); k < T; ++k) {
      for (int j = 0; j < n; ++j)
        in[static_cast<std::size_t>(j)] = {motion.q(k, j), motion.v(k, j), r.held_tau(k, j),
                                           r.temperature(k, j)};
      model.torque<double>(arm.friction.theta, in,
                           {z[s].row(k).data(), static_cast<std::size_t>(z[s].cols())},
                           {tau.row(k).data(), static_cast<std::size_t>(n)});
    }
    for (int k = test_begin[s]; k + margin < T; ++k)
      for (int j = 0; j < n; ++j) {
        if (!r.use(k, j)) continue;
        double f = response[0] * tau(k, j);
        for (int m = 1; m <= margin; ++m)
          f += response[static_cast<std::size_t>(m)] * (tau(k - m, j) + tau(k + m, j));
        const double wanted = data.target[s](k, j);
        residual[s][j] += (f - wanted) * (f - wanted);
        target[s][j] += wanted * wanted;
      }
  });
  for (std::size_t s = 1; s < data.target.size(); ++s) {
    residual[0] += residual[s];
    target[0] += target[s];
  }
  const double share = residual[0].cwiseQuotient(target[0].cwiseMax(1e-300)).mean();
  return std::isfinite(share) ? share : TorqueWindows<PackF>::kFallen;
}

/// What a descent on the torque needs, see optimise::descend.
class TorqueProblem {
 public:
  TorqueProblem(const ArmPoint& start, const TorqueData& data, const TorqueOptions& options,
                int steps, const std::vector<double>& response, int jobs)
      : data_(data),
        options_(options),
        steps_(steps),
        margin_(static_cast<int>(response.size()) - 1),
        jobs_(jobs),
        threads_(steps + 2 * margin_ >= kSamplesWorthThreads ? jobs : 1),
        response_(response),
        split_(split_recordings(data.recordings, options.hold_out)),
        rng_(options.seed, 0),
        parts_(static_cast<std::size_t>((options.batch + kWindowLanes - 1) / kWindowLanes)),
        losses_(parts_.size()),
        no_pi_bar_(Eigen::VectorXd::Zero(start.arm().robot.pi.size())),
        adam_(start.c().size()) {
    const std::vector<double> sizes = target_sizes(data);
    for (std::size_t p = 0; p < parts_.size(); ++p)
      rollouts_.emplace_back(start.arm().friction.model, data, steps, sizes, response);
  }

  void begin(const ArmPoint& point) { adam_ = optimise::Adam(point.c().size()); }

  void prepare(int iteration, const ArmPoint& point) {
    if (iteration > 0 && iteration % options_.wash_out_every == 0)
      z_ = states(point.arm(), data_, jobs_);
  }

  double loss(const ArmPoint& point, Eigen::VectorXd& gradient) {
    const std::vector<double>& theta = point.arm().friction.theta;
    std::vector<Window> windows =
        draw_windows(data_.recordings, split_, steps_ + 2 * margin_, options_.batch, 0, rng_);
    for (Window& window : windows) window.begin += margin_;
    parallel_for(static_cast<int>(parts_.size()), threads_, [&](int p) {
      const auto i = static_cast<std::size_t>(p), first = i * kWindowLanes;
      const auto count = std::min<std::size_t>(kWindowLanes, windows.size() - first);
      parts_[i].setZero(static_cast<Eigen::Index>(theta.size()));
      rollouts_[i].set_parameters(theta);
      losses_[i] = rollouts_[i].loss(std::span(windows).subspan(first, count), z_);
      rollouts_[i].add_gradient(view(parts_[i]));
    });
    for (std::size_t i = 1; i < parts_.size(); ++i) {
      parts_[0] += parts_[i];
      losses_[0] += losses_[i];
    }
    parts_[0] /= options_.batch;
    point.pull_back(no_pi_bar_, parts_[0], gradient);
    return losses_[0] / options_.batch;
  }

  std::pair<Eigen::VectorXd, bool> step(const ArmPoint& point, const Eigen::VectorXd& gradient,
                                        double rate) {
    const ArmCoordinates& coordinates = point.coordinates();
    Eigen::VectorXd c = point.c();
    const bool moved = adam_.step(gradient, rate, coordinates.rate(), coordinates.box(), c);
    return {std::move(c), moved};
  }

  double held_out(const ArmPoint& point) {
    z_ = states(point.arm(), data_, jobs_);
    return held_out_share(point.arm(), data_, z_, split_.test_begin, response_, jobs_);
  }

  std::string describe(double loss, double held_out) const {
    return fmt::format("loss {:.3g}, held out {:.3g}", loss, held_out);
  }

 private:
  const TorqueData& data_;
  const TorqueOptions& options_;
  int steps_, margin_, jobs_, threads_;
  const std::vector<double>& response_;
  Split split_;
  Rng rng_;
  std::vector<RowMatrix> z_;
  std::vector<Eigen::VectorXd> parts_;  // gradient of each pack
  std::vector<double> losses_;          // of each pack
  std::vector<TorqueWindows<PackF>> rollouts_;
  Eigen::VectorXd no_pi_bar_;
  optimise::Adam adam_;
};

}  // namespace

TorqueData torque_data(const Arm& arm, std::span<const signals::Recording> recordings,
                       bool filtered) {
  TorqueData out{recordings, filtered ? signals::Band::kWide : signals::Band::kNarrow, {}};
  for (const signals::Recording& r : recordings)
    out.target.push_back(r.filtered_tau - rigid_body_torque(arm.robot, arm.robot.pi, r));
  return out;
}

TorqueReport train_torque(const Arm& start, const TorqueData& data, const TorqueOptions& options,
                          std::string_view label, int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const std::span<const signals::Recording> recordings = data.recordings;
  const double dt = recordings.front().dt;
  const int steps = std::max(1, static_cast<int>(std::lround(options.window_s / dt)));
  std::vector<double> response{1};
  if (options.filtered)
    response = signals::impulse_response(signals::ZeroPhaseButterworth(options.cutoff_hz, 1 / dt));
  const int margin = static_cast<int>(response.size()) - 1;

  const Split split = split_recordings(recordings, options.hold_out);
  for (std::size_t i = 0; i < recordings.size(); ++i)
    if (split.train_end[i] < 2 * margin + 2 * steps)
      throw UserError("{}: {} samples are too few for windows of {} s", recordings[i].log.name,
                      recordings[i].length(), options.window_s);

  CoordinateOptions friction_alone;
  friction_alone.rigid_body = false;
  const ArmCoordinates coordinates(start, friction_alone);
  ArmPoint point(coordinates, start);
  point.move_to(point.c());
  const ArmPoint first = point;
  TorqueProblem problem(first, data, options, steps, response, jobs);

  TorqueReport report;
  report.history = optimise::descend(
      problem, point,
      {.iterations = options.iterations, .rate = options.rate, .checks = options.checks},
      fmt::format("torque {}", label));
  report.arm = report.history.best > 0 ? point.arm() : start;
  const double best = report.history.best_held_out();
  report.outcome = std::isfinite(best) ? Outcome::kIterationLimit : Outcome::kFailed;
  report.message = fmt::format(
      "{:.3g} of the held-out torque left after {} of {} iterations, {:.3g} before", best,
      report.history.best_iteration(), options.iterations, report.history.held_out.front());
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace fricid::estimate
