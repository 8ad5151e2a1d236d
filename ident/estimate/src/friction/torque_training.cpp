#include "fricid/estimate/friction/torque_training.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/adam.hpp"
#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "support.hpp"
#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr int kLanes = TorqueWindows<PackF>::lanes();
constexpr int kSamplesWorthThreads = 100;  // of a pack; below, starting threads takes longer

/// Root mean square of the target over the rows that count, per joint (n) [N m].
std::vector<double> target_sizes(std::span<const TorqueData> data) {
  std::vector<double> sizes;
  for (Eigen::Index j = 0; j < data.front().target.cols(); ++j) {
    double square = 0, rows = 0;
    for (const TorqueData& d : data)
      for (Eigen::Index k = 0; k < d.target.rows(); ++k)
        if (d.use(k, j)) square += d.target(k, j) * d.target(k, j), rows += 1;
    const double size = std::sqrt(square / std::max(1.0, rows));
    sizes.push_back(size > 0 ? size : 1);
  }
  return sizes;
}

std::vector<data::RowMatrix> states(const Arm& arm, std::span<const Recording> motions, int jobs) {
  if (arm.friction.model.state_size() > 0) return wash_out(arm, motions, jobs);
  std::vector<data::RowMatrix> none;
  for (const Recording& r : motions) none.emplace_back(r.length(), 0);
  return none;
}

/// Mean over joints of residual / target mean square on the held-out rows.
double held_out_share(const Arm& arm, std::span<const TorqueData> data,
                      std::span<const data::RowMatrix> z, const std::vector<int>& test_begin,
                      const std::vector<double>& response, int jobs) {
  const friction::RobotFriction& model = arm.friction.model;
  const int n = model.joint_count(), margin = static_cast<int>(response.size()) - 1;
  std::vector<Eigen::VectorXd> residual(data.size(), Eigen::VectorXd::Zero(n)), target = residual;
  parallel_for(static_cast<int>(data.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    const TorqueData& d = data[s];
    const int T = d.motion.length(), first = test_begin[s] - margin;
    data::RowMatrix tau(T, n);
    std::vector<friction::Input<double>> in(static_cast<std::size_t>(n));
    for (int k = std::max(0, first); k < T; ++k) {
      for (int j = 0; j < n; ++j)
        in[static_cast<std::size_t>(j)] = {d.motion.q(k, j), d.motion.v(k, j), d.motion.tau(k, j),
                                           d.motion.temperature(k, j)};
      model.torque<double>(arm.friction.theta, in,
                           {z[s].row(k).data(), static_cast<std::size_t>(z[s].cols())},
                           {tau.row(k).data(), static_cast<std::size_t>(n)});
    }
    for (int k = test_begin[s]; k + margin < T; ++k)
      for (int j = 0; j < n; ++j) {
        if (!d.use(k, j)) continue;
        double f = response[0] * tau(k, j);
        for (int m = 1; m <= margin; ++m)
          f += response[static_cast<std::size_t>(m)] * (tau(k - m, j) + tau(k + m, j));
        residual[s][j] += (f - d.target(k, j)) * (f - d.target(k, j));
        target[s][j] += d.target(k, j) * d.target(k, j);
      }
  });
  for (std::size_t s = 1; s < data.size(); ++s) {
    residual[0] += residual[s];
    target[0] += target[s];
  }
  const double share = residual[0].cwiseQuotient(target[0].cwiseMax(1e-300)).mean();
  return std::isfinite(share) ? share : TorqueWindows<PackF>::kFallen;
}

}  // namespace

std::vector<TorqueData> torque_data(const Arm& arm, std::span<const Filtered> sequences,
                                    std::span<const Recording> recordings, bool filtered) {
  std::vector<TorqueData> out;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const Filtered& sequence = sequences[s];
    TorqueData data{recordings[s],
                    sequence.tau - rigid_body_torque(arm.robot, arm.robot.pi, sequence),
                    sequence.use};
    if (!filtered) {
      data.motion.q = sequence.q;
      data.motion.v = sequence.v;
    }
    out.push_back(std::move(data));
  }
  return out;
}

TorqueReport train_torque(const Arm& start, std::span<const TorqueData> data,
                          const TorqueOptions& options, std::string_view label, int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  const double dt = data.front().motion.dt;
  const int steps = std::max(1, static_cast<int>(std::lround(options.window_s / dt)));
  std::vector<double> response{1};
  if (options.filtered)
    response = impulse_response(ZeroPhaseButterworth(options.cutoff_hz, 1 / dt));
  const int margin = static_cast<int>(response.size()) - 1;

  std::vector<Recording> motions;
  for (const TorqueData& d : data) motions.push_back(d.motion);
  const Split split = split_recordings(motions, options.hold_out);
  for (std::size_t i = 0; i < motions.size(); ++i)
    if (split.train_end[i] < 2 * margin + 2 * steps)
      throw UserError("{}: {} samples are too few for windows of {} s", motions[i].name,
                      motions[i].length(), options.window_s);

  TorqueReport report;
  report.arm = start;
  CoordinateOptions friction_alone;
  friction_alone.rigid_body = false;
  const ArmCoordinates coordinates(start, friction_alone);
  Arm arm = start;
  Eigen::VectorXd c = coordinates.start(), c_bar;
  coordinates.apply(c, arm);
  Adam adam(coordinates.size());
  Rng rng(options.seed, 0);

  const int packs = (options.batch + kLanes - 1) / kLanes;
  const std::vector<double> sizes = target_sizes(data);
  std::vector<TorqueWindows<PackF>> rollouts;
  for (int p = 0; p < packs; ++p)
    rollouts.emplace_back(arm.friction.model, data, steps, sizes, response);
  std::vector<Eigen::VectorXd> parts(static_cast<std::size_t>(packs));
  std::vector<double> losses(parts.size());
  const Eigen::VectorXd no_pi_bar = Eigen::VectorXd::Zero(arm.robot.pi.size());
  const int threads = steps + 2 * margin >= kSamplesWorthThreads ? jobs : 1;

  std::vector<data::RowMatrix> z = states(arm, motions, jobs);
  const auto look = [&](int iteration) {
    report.checked.push_back(iteration);
    report.held_out.push_back(held_out_share(arm, data, z, split.test_begin, response, jobs));
    if (report.held_out.back() < report.held_out[static_cast<std::size_t>(report.best)]) {
      report.best = static_cast<int>(report.held_out.size()) - 1;
      report.arm = arm;
    }
  };
  look(0);

  Progress progress(fmt::format("torque {}", label), options.iterations);
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    throw_if_stopped();
    if (iteration > 0 && iteration % options.wash_out_every == 0) z = states(arm, motions, jobs);
    std::vector<Window> windows =
        draw_windows(motions, split, steps + 2 * margin, options.batch, 0, rng);
    for (Window& window : windows) window.begin += margin;
    parallel_for(packs, threads, [&](int p) {
      const auto i = static_cast<std::size_t>(p), first = i * kLanes;
      const auto count = std::min<std::size_t>(kLanes, windows.size() - first);
      parts[i].setZero(static_cast<Eigen::Index>(arm.friction.theta.size()));
      rollouts[i].set_parameters(arm.friction.theta);
      losses[i] = rollouts[i].loss(std::span(windows).subspan(first, count), z);
      rollouts[i].add_gradient(view(parts[i]));
    });
    for (std::size_t i = 1; i < parts.size(); ++i) {
      parts[0] += parts[i];
      losses[0] += losses[i];
    }
    parts[0] /= options.batch;
    report.loss.push_back(losses[0] / options.batch);
    coordinates.pull_back(c, no_pi_bar, parts[0], c_bar);
    const double rate = options.rate * training_schedule(iteration, options.iterations);
    if (!adam.step(c_bar, rate, coordinates.rate(), coordinates.lower(), coordinates.upper(), c))
      ++report.skipped;
    coordinates.apply(c, arm);
    const int done = iteration + 1;
    if (done * options.checks / options.iterations >
        iteration * options.checks / options.iterations) {
      z = states(arm, motions, jobs);
      look(done);
    }
    progress.advance(
        1, fmt::format("loss {:.3g}, held out {:.3g}", report.loss.back(), report.held_out.back()));
  }

  const double best = report.held_out[static_cast<std::size_t>(report.best)];
  report.outcome = std::isfinite(best) ? Outcome::kIterationLimit : Outcome::kFailed;
  report.message =
      fmt::format("{:.3g} of the held-out torque left after {} of {} iterations, {:.3g} before",
                  best, report.checked[static_cast<std::size_t>(report.best)], options.iterations,
                  report.held_out.front());
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace fricid::estimate
