#include "fricid/estimate/torque/arm_torque_data.hpp"

#include <algorithm>

#include "fricid/dynamics/algorithms.hpp"
#include "rigid_body/regression.hpp"

namespace fricid::estimate {
namespace {

/// Per recording, what friction and rigid body have to explain (T, n) [N m].
std::vector<RowMatrix> torques(std::span<const signals::Recording> recordings) {
  std::vector<RowMatrix> torque;
  for (const signals::Recording& r : recordings) torque.push_back(r.filtered_tau);
  return torque;
}

/// Samples that the filter needs for the rows of each recording.
std::vector<SampleRange> needed(std::span<const signals::Recording> recordings,
                                std::span<const std::vector<int>> row, double cutoff_hz) {
  std::vector<SampleRange> ranges;
  for (std::size_t s = 0; s < recordings.size(); ++s) {
    const signals::Recording& r = recordings[s];
    const int padding = signals::ZeroPhaseButterworth(cutoff_hz, 1 / r.dt).padding();
    ranges.push_back(row[s].empty()
                         ? SampleRange{0, 0}
                         : SampleRange{std::max(0, row[s].front() - padding),
                                       std::min(r.length(), row[s].back() + padding + 1)});
  }
  return ranges;
}

}  // namespace

ArmTorqueData::ArmTorqueData(const dynamics::RobotModel& robot,
                             std::span<const signals::Recording> recordings, double cutoff_hz,
                             std::span<const int> begin, std::span<const int> end)
    : recordings_(recordings), cutoff_hz_(cutoff_hz) {
  const int n = robot.n();
  const auto p = static_cast<Eigen::Index>(robot.parameter_count());
  const std::vector<RowMatrix> torque = torques(recordings);
  for (int j = 0; j < n; ++j) {
    std::vector<std::vector<int>> row;
    Eigen::Index count = 0;
    for (std::size_t s = 0; s < recordings.size(); ++s) {
      const signals::Recording& r = recordings[s];
      const int every = signals::decimation(r.dt, cutoff_hz);
      const int first = begin.empty() ? 0 : begin[s], last = end.empty() ? r.length() : end[s];
      row.emplace_back();
      for (int k = 0; k < r.length(); k += every)
        if (k >= first && k < last && r.use(k, j)) row.back().push_back(k);
      count += std::ssize(row.back());
    }
    JointFrictionData friction = friction_of(torque, j, row);
    joints_.push_back({.friction = std::move(friction),
                       .row = std::move(row),
                       .Y = Eigen::MatrixXd(count, p),
                       .tau = Eigen::VectorXd(count),
                       .YY = {},
                       .open = {}});
  }
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd Y(n, p);
  std::vector<Eigen::Index> at(static_cast<std::size_t>(n), 0);
  std::vector<std::size_t> next(static_cast<std::size_t>(n));
  for (std::size_t s = 0; s < recordings.size(); ++s) {
    const signals::Recording& r = recordings[s];
    std::fill(next.begin(), next.end(), 0);
    for (int k = 0; k < r.length(); k += signals::decimation(r.dt, cutoff_hz)) {
      regressor_at(robot, ws, r.narrow, k, Y);
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        Joint& joint = joints_[j];
        if (next[j] >= joint.row[s].size() || joint.row[s][next[j]] != k) continue;
        joint.Y.row(at[j]) = Y.row(static_cast<Eigen::Index>(j));
        joint.tau[at[j]++] = r.filtered_tau(k, static_cast<Eigen::Index>(j));
        ++next[j];
      }
    }
  }
  for (Joint& joint : joints_) joint.YY = joint.Y.transpose() * joint.Y;
}

void ArmTorqueData::take_load() {
  const std::vector<RowMatrix> torque = torques(recordings_);
  for (int j = 0; j < n(); ++j) {
    Joint& joint = joints_[static_cast<std::size_t>(j)];
    joint.friction = friction_of(torque, j, joint.row);
  }
  if (deflection_.size() > 0) begin_springs_at(deflection_);
}

void ArmTorqueData::begin_springs_at(const Eigen::MatrixXd& deflection) {
  deflection_ = deflection;
  for (int j = 0; j < n(); ++j)
    joints_[static_cast<std::size_t>(j)].friction.begin_springs_at(
        {deflection_.col(j).begin(), deflection_.col(j).end()});
}

void ArmTorqueData::take_springs(const Springs& springs) {
  begin_springs_at(springs.deflection);
  if (whole_.empty())
    for (const Joint& joint : joints_) whole_.push_back({joint.Y, joint.tau});
  for (int j = 0; j < n(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    Joint& joint = joints_[i];
    joint.open.clear();
    Eigen::Index begin = 0;
    for (std::size_t s = 0; s < joint.row.size(); ++s) {
      const std::vector<int>& rows = joint.row[s];
      const int until = springs.until(static_cast<Eigen::Index>(s), j);
      const auto open = std::ranges::lower_bound(rows, until) - rows.begin();
      if (open > 0) joint.open.emplace_back(begin, open);
      begin += std::ssize(rows);
    }
    joint.Y = whole_[i].Y;
    joint.tau = whole_[i].tau;
    joint.centre(joint.Y);
    joint.centre(joint.tau);
    joint.YY = joint.Y.transpose() * joint.Y;
  }
}

void ArmTorqueData::Joint::centre(Eigen::Ref<Eigen::MatrixXd> x) const {
  for (const auto& [begin, size] : open) {
    auto part = x.middleRows(begin, size);
    part.rowwise() -= part.colwise().mean().eval();
  }
}

Eigen::VectorXd ArmTorqueData::squares(const Arm& arm, int j) const {
  const Eigen::VectorXd e = residual(arm, j);
  Eigen::VectorXd sum(std::ssize(joint(j).row));
  Eigen::Index r = 0;
  for (Eigen::Index s = 0; s < sum.size(); ++s) {
    const std::ptrdiff_t rows = std::ssize(joint(j).row[static_cast<std::size_t>(s)]);
    sum[s] = e.segment(r, rows).squaredNorm();
    r += rows;
  }
  return sum;
}

JointFrictionData ArmTorqueData::friction_of(std::span<const RowMatrix> torque, int j,
                                             std::span<const std::vector<int>> row) const {
  return JointFrictionData(recordings_, torque, j, cutoff_hz_, {},
                           needed(recordings_, row, cutoff_hz_));
}

Eigen::VectorXd ArmTorqueData::Joint::predict(const friction::RobotFriction& one,
                                              std::span<const double> theta) const {
  const PerSample predicted = friction.predict(one, theta);
  Eigen::VectorXd f(tau.size());
  Eigen::Index r = 0;
  for (std::size_t s = 0; s < row.size(); ++s)
    for (const int k : row[s]) f[r++] = predicted[s][static_cast<std::size_t>(k)];
  centre(f);
  return f;
}

Eigen::VectorXd ArmTorqueData::residual(const Arm& arm, int j) const {
  const friction::Friction f = friction_of_joint(arm.friction, j);
  return joint(j).Y * arm.robot.pi + joint(j).predict(f.model, f.theta) - joint(j).tau;
}

double ArmTorqueData::load_gain(const Arm& arm, int j) const {
  const friction::Friction f = friction_of_joint(arm.friction, j);
  return f.model.reads_load() ? joint(j).friction.load_gain(f.model, f.theta) : 0;
}

}  // namespace fricid::estimate
