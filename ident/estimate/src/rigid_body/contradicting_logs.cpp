#include "rigid_body/contradicting_logs.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "rigid_body/information.hpp"

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

std::vector<Log> long_logs(const StackedByJoint& all, int recordings) {
  std::vector<Log> logs;
  for (int i = 0; i < recordings; ++i) {
    Log log;
    log.sequence = i;
    log.rows.base = all.base;
    log.rows.size = log.rows.plain = all.plain;
    for (const JointRows& joint : all.joints) {
      Columns chosen;
      for (std::size_t r = 0; r < joint.at.size(); ++r)
        if (all.sequence[static_cast<std::size_t>(joint.at[r])] == i)
          chosen.push_back(static_cast<Eigen::Index>(r));
      log.rows.joints.push_back(normal_equations(joint, chosen, all.plain));
      log.rows.rows += static_cast<Eigen::Index>(log.rows.joints.back().count);
    }
    if (log.rows.rows < kRowsPerUnknown * all.plain) continue;
    log.alone = solve(log.rows, all.plain);
    logs.push_back(std::move(log));
  }
  return logs;
}

/// The rows of a joint on the first `base` columns, the best of the others, its friction, taken
/// out (Schur complement). @param unknowns  counts these
JointRows without_friction(const JointRows& rows, Eigen::Index base, Eigen::Index& unknowns) {
  Columns friction;
  for (Eigen::Index k = base; k < rows.Xy.size(); ++k)
    if (rows.XX(k, k) > 0) friction.push_back(k);
  unknowns += std::ssize(friction);
  const Eigen::MatrixXd across = rows.XX(friction, Eigen::seqN(0, base));
  const Eigen::VectorXd own = rows.Xy(friction);
  const Eigen::MatrixXd inverse = invert(rows.XX(friction, friction), nullptr);
  JointRows out;
  out.XX = rows.XX.topLeftCorner(base, base) - across.transpose() * inverse * across;
  out.Xy = rows.Xy.head(base) - across.transpose() * (inverse * own);
  out.yy = rows.yy - own.dot(inverse * own);
  out.count = rows.count;
  return out;
}

/// All logs as one regression, each joint's rows being `of` those of a log.
StackedByJoint joined(const std::vector<Log>& logs, Eigen::Index size,
                      const std::function<JointRows(const JointRows&)>& of) {
  StackedByJoint sum;
  sum.size = sum.plain = size;
  for (const Log& log : logs) {
    sum.rows += log.rows.rows;
    for (std::size_t j = 0; j < log.rows.joints.size(); ++j) {
      if (sum.joints.size() == j)
        sum.joints.push_back(of(log.rows.joints[j]));
      else
        sum.joints[j].add(of(log.rows.joints[j]));
    }
  }
  return sum;
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

/// @param unknowns  beside those of the fit
Eigen::ArrayXd variances_of_fit(const StackedByJoint& together, Eigen::Index unknowns) {
  const Solution fit = solve(together, together.plain);
  Eigen::VectorXd squares(together.n());
  for (int j = 0; j < together.n(); ++j)
    squares[j] = together.joints[static_cast<std::size_t>(j)].squares(fit.x);
  return variances(squares, together, fit.unknowns + unknowns);
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
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(all.n());
  Eigen::Index unknowns = 0, of_frictions = 0;
  for (const Log& log : logs) {
    unknowns += log.alone.unknowns;
    for (int j = 0; j < all.n(); ++j)
      squares[j] += log.rows.joints[static_cast<std::size_t>(j)].squares(log.alone.x);
  }
  const StackedByJoint one = joined(logs, all.plain, std::identity());
  const StackedByJoint bodies_alone = joined(logs, all.base, [&](const JointRows& rows) {
    return without_friction(rows, all.base, of_frictions);
  });
  const Eigen::ArrayXd of_one = variances_of_fit(one, 0),
                       of_friction = variances_of_fit(bodies_alone, of_frictions),
                       of_each = variances(squares, one, unknowns);

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
