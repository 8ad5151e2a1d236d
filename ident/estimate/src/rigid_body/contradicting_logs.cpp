#include "rigid_body/contradicting_logs.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"

namespace fricid::estimate {
namespace {

constexpr int kRowsPerUnknown = 5;  // of a log that is fitted alone
constexpr double kLogGain = 2.5;    // log of the variance of a joint; see `find_contradictions`

/// A log fitted alone.
struct Log {
  int sequence = 0;
  StackedByJoint rows;
  Solution alone;
};

/// The rows of some recordings, the friction of each in columns of its own where asked for.
StackedByJoint rows_of(const StackedByJoint& all, std::span<const int> sequences,
                       bool own_friction) {
  const Eigen::Index friction = all.plain - all.base;
  const auto copies = own_friction ? std::ssize(sequences) : 1;
  StackedByJoint out;
  out.base = all.base;
  out.size = out.plain = all.base + copies * friction;
  for (const JointRows& joint : all.joints) {
    Columns chosen;
    std::vector<std::ptrdiff_t> copy;
    for (std::size_t i = 0; i < joint.at.size(); ++i) {
      const int sequence = all.sequence[static_cast<std::size_t>(joint.at[i])];
      const auto found = std::ranges::find(sequences, sequence);
      if (found == sequences.end()) continue;
      chosen.push_back(static_cast<Eigen::Index>(i));
      copy.push_back(own_friction ? found - sequences.begin() : 0);
    }
    JointRows rows;
    rows.at = chosen;
    rows.X.setZero(std::ssize(chosen), out.size);
    for (Eigen::Index r = 0; r < rows.X.rows(); ++r) {
      const auto row = joint.X.row(chosen[static_cast<std::size_t>(r)]);
      rows.X.row(r).head(all.base) = row.head(all.base);
      rows.X.row(r).segment(all.base + copy[static_cast<std::size_t>(r)] * friction, friction) =
          row.segment(all.base, friction);
    }
    rows.y = joint.y(chosen);
    rows.XX = rows.X.transpose() * rows.X;
    rows.Xy = rows.X.transpose() * rows.y;
    out.rows += rows.X.rows();
    out.joints.push_back(std::move(rows));
  }
  return out;
}

std::vector<Log> long_logs(const StackedByJoint& all, int recordings) {
  std::vector<Log> logs;
  for (int i = 0; i < recordings; ++i) {
    const int sequences[] = {i};
    StackedByJoint rows = rows_of(all, sequences, false);
    if (rows.rows < kRowsPerUnknown * all.plain) continue;
    Solution alone = solve(rows, rows.plain);
    logs.push_back({i, std::move(rows), std::move(alone)});
  }
  return logs;
}

/// Variances of each joint that a fit leaves, the unknowns spent.
Eigen::ArrayXd variances(const Eigen::VectorXd& squares, const StackedByJoint& together,
                         Eigen::Index unknowns) {
  const double left = 1 - static_cast<double>(unknowns) / static_cast<double>(together.rows);
  Eigen::ArrayXd out(squares.size());
  for (Eigen::Index j = 0; j < squares.size(); ++j) {
    const JointRows& joint = together.joints[static_cast<std::size_t>(j)];
    out[j] = std::pow(sigma_of(squares[j] / left, joint), 2);
  }
  return out;
}

Eigen::ArrayXd variances(const Solution& fit, const StackedByJoint& together) {
  Eigen::VectorXd squares(together.n());
  for (int j = 0; j < together.n(); ++j)
    squares[j] = together.joints[static_cast<std::size_t>(j)].squares(fit.x);
  return variances(squares, together, fit.unknowns);
}

/// The unknown among `first` to `end` in which two logs differ most by their errors.
Fault name_difference(std::span<const Log> logs, std::span<const signals::Recording> recordings,
                      const StackedByJoint& all, Eigen::Index first, Eigen::Index end) {
  double most = -1;
  std::string found;
  for (std::size_t a = 0; a < logs.size(); ++a)
    for (std::size_t b = a + 1; b < logs.size(); ++b)
      for (Eigen::Index k = first; k < end; ++k) {
        const Solution &x = logs[a].alone, &y = logs[b].alone;
        const double z = std::abs(x.x[k] - y.x[k]) / std::hypot(x.error[k], y.error[k]);
        if (x.error[k] == 0 || y.error[k] == 0 || !(z > most)) continue;
        most = z;
        found = fmt::format("{} is {:.3g} in {} and {:.3g} in {}",
                            all.names[static_cast<std::size_t>(k)], x.x[k],
                            recordings[static_cast<std::size_t>(logs[a].sequence)].log.name, y.x[k],
                            recordings[static_cast<std::size_t>(logs[b].sequence)].log.name);
      }
  return {"", "the logs contradict each other: " + found, ""};
}

}  // namespace

std::vector<Fault> find_contradicting_logs(const StackedByJoint& all,
                                           std::span<const signals::Recording> recordings) {
  const std::vector<Log> logs = long_logs(all, static_cast<int>(recordings.size()));
  if (logs.size() < 2) return {};
  std::vector<int> sequences;
  for (const Log& log : logs) sequences.push_back(log.sequence);
  const StackedByJoint together = rows_of(all, sequences, false),
                       own_friction = rows_of(all, sequences, true);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(all.n());
  Eigen::Index unknowns = 0;
  for (const Log& log : logs) {
    unknowns += log.alone.unknowns;
    for (int j = 0; j < all.n(); ++j)
      squares[j] += log.rows.joints[static_cast<std::size_t>(j)].squares(log.alone.x);
  }
  const Eigen::ArrayXd of_one = variances(solve(together, together.plain), together),
                       of_friction =
                           variances(solve(own_friction, own_friction.plain), own_friction),
                       of_each = variances(squares, together, unknowns);

  const bool bodies = (of_friction / of_each).log().maxCoeff() > kLogGain;
  if (!bodies && !((of_one / of_friction).log().maxCoeff() > kLogGain)) return {};
  Fault fault = bodies ? name_difference(logs, recordings, all, 0, all.base)
                       : name_difference(logs, recordings, all, all.base, all.plain);
  const bool has_temperature = std::ranges::all_of(
      recordings, [](const signals::Recording& r) { return r.log.temperature.size() > 0; });
  fault.remedy = bodies
                     ? "fit logs with another load or another base apart (`fricid payload` finds a "
                       "load from two logs)"
                 : has_temperature ? "fit them apart, or with friction that depends on the "
                                     "temperature: the lvm, or modifiers = [\"temperature\"]"
                                   : "fit them apart, or log the temperature of the gears";
  fault.without_temperature = !bodies && has_temperature;
  return {fault};
}

}  // namespace fricid::estimate
