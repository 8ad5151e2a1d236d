#include "rigid_body/regression.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "blocks.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/dynamics/algorithms.hpp"

namespace fricid::estimate {
namespace {

constexpr double kStandstill = 0.1;  // share of the least speed that counts as standing
constexpr int kLeastBlocks = 10, kMostBlocks = 60;  // of all sequences, about
constexpr std::array kSharesOfMemory{1.0, 0.6, 0.4, 0.25};
constexpr double kLeastLeft = 0.25;                       // of the fast rows
constexpr double kShareOfSpeed = 0.15, kFastRows = 0.05;  // of a slow joint's own speed

int friction_column(int p, int n, int kind, int j) { return p + kind * n + j; }

// Filtered sign of the velocity of joint j: Coulomb friction of 1 N m after the
// filter.
Eigen::VectorXd filtered_sign(const signals::Recording& sequence, int j, double cutoff_hz) {
  Eigen::VectorXd s = sequence.wide.v.col(j).array().sign();
  std::vector<double> work;
  signals::ZeroPhaseButterworth(cutoff_hz, 1 / sequence.dt)
      .apply(std::span<double>(s.data(), static_cast<std::size_t>(s.size())), work);
  return s;
}

// Speed above which rows of joint j enter.
double least_speed(std::span<const signals::Recording> sequences, int j, double min_speed) {
  std::vector<double> speeds;
  for (const signals::Recording& s : sequences)
    for (int k = 0; k < s.length(); ++k)
      if (s.use(k, j)) speeds.push_back(std::abs(s.narrow.v(k, j)));
  if (speeds.empty()) return min_speed;
  const auto fast = speeds.end() - 1 -
                    static_cast<std::ptrdiff_t>(kFastRows * static_cast<double>(speeds.size()));
  std::nth_element(speeds.begin(), fast, speeds.end());
  return std::min(min_speed, kShareOfSpeed * *fast);
}

/// Seconds of the recordings, of passages of one motion those of the first.
double seconds_of_motion(std::span<const signals::Recording> recordings) {
  double seconds = 0;
  std::vector<int> seen;
  for (const signals::Recording& r : recordings) {
    if (r.motion_number >= 0 && std::ranges::count(seen, r.motion_number) > 0) continue;
    seen.push_back(r.motion_number);
    seconds += (r.period > 0 ? r.period : r.length()) * r.dt;
  }
  return seconds;
}

bool is_fast(const signals::Recording& s, int j, int k, double min_speed) {
  return s.use(k, j) && std::abs(s.narrow.v(k, j)) > min_speed;
}

// Rows of joint j that may enter: fast, and neither standing nor turning within the filter's
// memory.
std::vector<bool> sliding_rows(const signals::Recording& s, int j, double min_speed,
                               double memory_s) {
  const int memory = static_cast<int>(std::lround(memory_s / s.dt));
  std::vector<bool> rows(static_cast<std::size_t>(s.length()));
  for (int k = 0; k < s.length(); ++k)
    rows[static_cast<std::size_t>(k)] = is_fast(s, j, k, min_speed);
  for (int k = 0; k + 1 < s.length(); ++k) {
    const double v = s.wide.v(k, j), next = s.wide.v(k + 1, j);
    if (v * next > 0 && std::abs(v) >= kStandstill * min_speed) continue;
    const int end = std::min(s.length(), k + memory + 1);
    for (int i = std::max(0, k - memory); i < end; ++i) rows[static_cast<std::size_t>(i)] = false;
  }
  return rows;
}

// Time about a reversal of joint j that is left out [s]: the filter's memory, or as much less as
// leaves a share of the fast rows of a joint that reverses often.
double memory_of(std::span<const signals::Recording> sequences, int j, double min_speed,
                 const RigidBodyOptions& options) {
  std::ptrdiff_t fast = 0;
  for (const signals::Recording& s : sequences)
    for (int k = 0; k < s.length(); ++k) fast += is_fast(s, j, k, min_speed);
  double memory = options.memory_periods / options.cutoff_hz;
  for (const double share : kSharesOfMemory) {
    memory = share * options.memory_periods / options.cutoff_hz;
    std::ptrdiff_t left = 0;
    for (const signals::Recording& s : sequences)
      left += std::ranges::count(sliding_rows(s, j, min_speed, memory), true);
    if (static_cast<double>(left) >= kLeastLeft * static_cast<double>(fast)) break;
  }
  return memory;
}

}  // namespace

double late_by(const signals::Recording& recording, int k, int joint) {
  const int from = std::max(0, k - 1), to = std::min(recording.length() - 1, k + 1);
  return recording.log.torque_delay_sd *
         (recording.filtered_tau(to, joint) - recording.filtered_tau(from, joint)) /
         ((to - from) * recording.dt);
}

Regression stack(const dynamics::RobotModel& robot, std::span<const signals::Recording> sequences,
                 const RigidBodyOptions& options, const FrictionTorques* shape, RigidBodyFit& fit) {
  const int n = robot.n(), p = robot.parameter_count();
  fit.rows.assign(static_cast<std::size_t>(n), 0);
  fit.rows_total = fit.equations = fit.rows;
  fit.least_speed.clear();

  std::vector<double> memory;
  for (int j = 0; j < n; ++j) {
    fit.least_speed.push_back(least_speed(sequences, j, options.min_speed_rad_s));
    memory.push_back(memory_of(sequences, j, fit.least_speed.back(), options));
  }

  // Count, then fill.
  Eigen::Index count = 0;
  std::vector<std::vector<std::vector<bool>>> used(sequences.size());  // [sequence][joint][sample]
  for (std::size_t i = 0; i < sequences.size(); ++i) {
    const signals::Recording& s = sequences[i];
    const int every = signals::decimation(s.dt, options.cutoff_hz);
    for (int j = 0; j < n; ++j) {
      const auto at = static_cast<std::size_t>(j);
      used[i].push_back(sliding_rows(s, j, fit.least_speed[at], memory[at]));
      fit.rows_total[at] += s.length();
      for (int k = 0; k < s.length(); ++k) {
        if (!used[i][at][static_cast<std::size_t>(k)]) continue;
        ++fit.rows[at];
        if (k % every == 0) ++fit.equations[at], ++count;
      }
    }
  }

  Regression out;
  out.rows.setZero(count, p + 3 * n);
  out.tau.resize(count);
  out.late.resize(count);
  for (std::vector<int>* of_rows : {&out.joint, &out.sequence, &out.sample})
    of_rows->reserve(static_cast<std::size_t>(count));
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd Y(n, p);
  std::vector<std::vector<double>> speeds(static_cast<std::size_t>(n));
  const double seconds = seconds_of_motion(sequences);
  const TimeBlocks blocks(
      sequences, std::max(std::min(kBlock, seconds / kLeastBlocks), seconds / kMostBlocks));
  for (std::size_t i = 0; i < sequences.size(); ++i) {
    const signals::Recording& s = sequences[i];
    const int every = signals::decimation(s.dt, options.cutoff_hz);
    Eigen::MatrixXd coulomb(s.length(), n);
    for (int j = 0; j < n; ++j) coulomb.col(j) = filtered_sign(s, j, options.cutoff_hz);
    for (int k = 0; k < s.length(); k += every) {
      regressor_at(robot, ws, s.narrow, k, Y);
      for (int j = 0; j < n; ++j) {
        if (!used[i][static_cast<std::size_t>(j)][static_cast<std::size_t>(k)]) continue;
        const auto r = static_cast<Eigen::Index>(out.joint.size());
        out.rows.row(r).head(p) = Y.row(j);
        out.tau[r] = s.filtered_tau(k, j);
        out.late[r] = late_by(s, k, j);
        out.rows(r, friction_column(p, n, 0, j)) = shape ? (*shape)[i](k, j) : coulomb(k, j);
        out.rows(r, friction_column(p, n, 1, j)) = s.narrow.v(k, j);
        if (options.offset) out.rows(r, friction_column(p, n, 2, j)) = 1;
        speeds[static_cast<std::size_t>(j)].push_back(std::abs(s.narrow.v(k, j)));
        out.joint.push_back(j);
        out.sequence.push_back(static_cast<int>(i));
        out.sample.push_back(k);
        out.passage.push_back(blocks.passage_of(i, k));
      }
    }
  }
  fit.speeds.clear();
  for (std::vector<double>& of_joint : speeds) fit.speeds.push_back(signals::speed_range(of_joint));
  return out;
}

void regressor_at(const dynamics::RobotModel& robot, dynamics::Workspace<double>& ws,
                  const signals::Motion& motion, int k, Eigen::Ref<Eigen::MatrixXd> Y) {
  const auto row = [&](const RowMatrix& x) {
    return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(x.cols()));
  };
  dynamics::regressor(robot, ws, row(motion.q), row(motion.v), row(motion.a), Y);
}

int viscous_column(const dynamics::RobotModel& robot, int joint) {
  return friction_column(robot.parameter_count(), robot.n(), 1, joint);
}

std::vector<int> excited_friction(const dynamics::RobotModel& robot, const Regression& data) {
  std::vector<int> columns;
  for (int k = robot.parameter_count(); k < static_cast<int>(data.rows.cols()); ++k)
    if (data.rows.col(k).squaredNorm() > 0) columns.push_back(k);
  return columns;
}

FrictionTorques friction_target(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                                std::span<const signals::Recording> sequences, int jobs) {
  FrictionTorques target(sequences.size());
  parallel_for(static_cast<int>(sequences.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    target[s] = sequences[s].filtered_tau - rigid_body_torque(robot, pi, sequences[s]);
  });
  return target;
}

}  // namespace fricid::estimate
