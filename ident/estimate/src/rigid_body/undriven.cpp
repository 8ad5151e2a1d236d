#include "rigid_body/undriven.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/not_finite.hpp"
#include "log_times.hpp"
#include "rigid_body/regression.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kRest = 0.1;         // of the least speed of the regression
constexpr double kShortestRun = 0.2;  // [s]
constexpr double kZero = 0.03;        // of the root mean square of a joint's torque
// What friction bears at rest, in Coulomb friction: of any torque; where all torques are zero,
// which motors that are on seldom give.
constexpr double kBorne = 3, kBorneOff = 1.5;
constexpr double kSigmas = 6;    // standard deviations of the regression
constexpr double kErrors = 3;    // standard errors by which Coulomb friction may be larger
constexpr double kUnlike = 0.5;  // of the friction that the regression expects, root mean square

/// Runs of samples in which a condition holds for long enough.
std::vector<Run> runs_of(const signals::Recording& r, const std::function<bool(int)>& holds) {
  const int shortest = static_cast<int>(std::ceil(kShortestRun / r.dt));
  std::vector<Run> runs;
  for (int k = 0; k < r.length(); ++k) {
    if (!holds(k)) continue;
    const int first = k;
    while (k + 1 < r.length() && holds(k + 1)) ++k;
    if (k - first + 1 >= shortest) runs.push_back({first, k});
  }
  return runs;
}

}  // namespace

std::vector<Fault> find_undriven(const dynamics::RobotModel& robot,
                                 std::span<const signals::Recording> recordings,
                                 const RigidBodyOptions& options, const RigidBodyFit& fit) {
  const int n = robot.n();
  const Eigen::VectorXd rms = filtered_torque_rms(recordings);
  const FrictionTorques friction = friction_target(robot, fit.pi, recordings, 1);
  Eigen::VectorXd least_speed(n);
  Eigen::ArrayXd borne(n), noise(n);  // of joints whose friction is known
  for (int j = 0; j < n; ++j) {
    const bool known = fit.equations[static_cast<std::size_t>(j)] > 0;
    borne[j] = known ? std::max(0.0, fit.Fc[j]) + kErrors * fit.Fc_se[j] : kInfinity;
    noise[j] = kSigmas * fit.sigma[j];
    least_speed[j] =
        options.min_speed_rad_s * dynamics::travel_scale(robot.joints[static_cast<std::size_t>(j)]);
  }
  // An arm that slows down or falls by itself has the friction that the regression expects.
  const auto is_moved_by_others = [&](const signals::Recording& r, const Run& run,
                                      const RowMatrix& friction_of_log) {
    const int samples = run.last - run.first + 1;
    bool slides = false, unlike = false;
    for (int j = 0; j < n; ++j) {
      const auto v = r.narrow.v.col(j).segment(run.first, samples).array();
      if (!(v.abs().maxCoeff() > least_speed[j])) continue;
      slides = true;
      if (!std::isfinite(borne[j])) continue;
      const Eigen::ArrayXd expected = fit.Fc[j] * v.sign() + fit.Fv[j] * v + fit.offset[j];
      const auto found = friction_of_log.col(j).segment(run.first, samples).array();
      if ((found - expected).matrix().norm() > kUnlike * expected.matrix().norm()) unlike = true;
    }
    return slides && unlike;
  };
  LogTimes held, moved;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const signals::Recording& r = recordings[i];
    const auto is_zero = [&](int k) {
      return (r.filtered_tau.row(k).transpose().cwiseAbs().array() < kZero * rms.array()).all();
    };
    const auto stands = [&](int k) {
      return r.log.q.row(k).allFinite() && r.log.tau.row(k).allFinite() &&
             (r.narrow.v.row(k).transpose().cwiseAbs().array() < kRest * least_speed.array()).all();
    };
    for (const Run& run : runs_of(r, stands)) {
      const int samples = run.last - run.first + 1;
      int zeros = 0;
      for (int k = run.first; k <= run.last; ++k) zeros += is_zero(k);
      const double most = 2 * zeros > samples ? kBorneOff : kBorne;
      const auto squares = friction[i].middleRows(run.first, samples).array().square();
      const Eigen::ArrayXd torque = squares.colwise().mean().sqrt().transpose();
      if ((torque > most * borne + noise).any()) held.add(r, run);
    }
    for (const Run& run : runs_of(r, [&](int k) { return is_zero(k) && !stands(k); }))
      if (is_moved_by_others(r, run, friction[i])) moved.add(r, run);
  }
  std::vector<Fault> faults;
  if (!held.empty())
    faults.push_back({"",
                      "the arm stands and the torque is not what holds it: a brake, a stop or "
                      "drives that are off, " +
                          held.words(),
                      held.remedy()});
  if (!moved.empty())
    faults.push_back(
        {"",
         "the arm moves and every torque is zero: drives that are off, or a hand, " + moved.words(),
         moved.remedy()});
  return faults;
}

}  // namespace fricid::estimate
