#include "rigid_body/contradictions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/dynamics/mount.hpp"
#include "fricid/system/transmission.hpp"
#include "rigid_body/changes.hpp"
#include "rigid_body/contradicting_logs.hpp"
#include "rigid_body/frames.hpp"
#include "rigid_body/gears.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/joint_rows.hpp"
#include "rigid_body/tilt.hpp"
#include "rigid_body/undriven.hpp"
#include "rigid_body/zeros.hpp"

namespace fricid::estimate {
namespace {

constexpr double kWidth = 0.5;       // sd of a factor's prior about 1
constexpr int kMostSteps = 40;       // of Gauss-Newton
constexpr double kConverged = 1e-3;  // change of a factor
constexpr double kSmallest = 0.02;   // factor over the largest: below, no torque of these bodies
constexpr int kPasses = 3;           // of friction that grows with the load of the last pass
// Log of the factor by which the unexplained variances must fall, in sum over the joints: friction
// that the linear regression has not lets springs and factors gain up to 1.8.
constexpr double kGain = 2.5;
constexpr double kLeast = 0.03, kCertain = 4;  // distance of a factor from 1: [1], standard errors
constexpr double kOfFrames = 1;  // gain that placements of joints, of many values, must have beyond

int middle_of(const Eigen::VectorXd& x) {
  std::vector<int> order(static_cast<std::size_t>(x.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int j) { return x[j]; });
  return order[order.size() / 2];
}

/// Factors s of the torque columns of a robot whose joints share inertial parameters:
///
///     tau_j = s_j Y_j pi + Fc_j F[sign v_j] + Fv_j v_j + offset_j + e_j.
///
/// Their common factor is that of all masses and cannot be told: the middle one is called 1.
struct TorqueScales {
  Eigen::VectorXd value;           ///< (n); empty: not found
  Eigen::VectorXd standard_error;  ///< (n); 0 where the gain is not worth a word
  /// Log of the factor by which they lower the unexplained variance, in sum over the joints.
  double gain = 0;
};

/// Joints whose factor is not 1, where the factors explain far more.
std::vector<int> scaled_joints(const TorqueScales& scales) {
  std::vector<int> joints;
  for (int j = 0; j < static_cast<int>(scales.value.size()); ++j)
    if (const double off = std::abs(scales.value[j] - 1);
        off > std::max(kLeast, kCertain * scales.standard_error[j]))
      joints.push_back(j);
  return joints;
}

/// The joints whose springs, one after the other, explain most, in parts of the data that they were
/// not fitted to as well.
struct Springs {
  std::vector<int> joints;
  double gain = 0;
};

/// @param sigma  of the residuals without springs
Springs find_springs(const StackedByJoint& all, Eigen::VectorXd sigma) {
  Springs springs;
  Columns plain(static_cast<std::size_t>(all.plain));
  std::iota(plain.begin(), plain.end(), 0);
  Columns columns = plain;
  for (double best = kGain; best > 0;) {
    best = 0;
    std::pair<int, Eigen::VectorXd> with;
    for (int j = 0; j < all.n(); ++j) {
      const Columns& own = all.springs[static_cast<std::size_t>(j)];
      if (own.empty() || std::ranges::count(springs.joints, j) > 0) continue;
      Columns more = columns;
      more.insert(more.end(), own.begin(), own.end());
      if (all.rows <= std::ssize(more)) continue;
      const Eigen::VectorXd less = solve(all, more).sigma;
      if (const double gain = gain_of(sigma, less); gain > std::max(best, kGain))
        best = gain, with = {j, less};
    }
    if (best == 0) break;
    const Columns& own = all.springs[static_cast<std::size_t>(with.first)];
    columns.insert(columns.end(), own.begin(), own.end());
    springs.joints.push_back(with.first);
    springs.gain += best;
    sigma = with.second;
  }
  if (springs.joints.empty()) return springs;
  const double held_out = gain_of(held_out_sigma(all, plain), held_out_sigma(all, columns));
  return held_out > kGain ? springs : Springs{};
}

/// A joint that slides has no angle: what depends on its position is a spring or an offset.
Fault spring_at(const dynamics::Joint& joint) {
  const bool slides = dynamics::slides(joint);
  return {joint.name,
          fmt::format("its {} goes with its own {} more than gravity and inertia explain",
                      slides ? "force" : "torque", slides ? "position" : "angle"),
          fmt::format("a spring, counterbalance or cable that the robot's file lacks: "
                      "[[robot.torque]] joint = \"{}\", terms = [{}]",
                      joint.name, slides ? "\"q\"" : "\"q\", \"sin(q)\", \"cos(q)\"")};
}

Fault fault_of(const Tilt& tilt) {
  return {"",
          fmt::format("gravity points {:.3g} +- {:.1g} rad from where the mount puts it",
                      tilt.angle, tilt.standard_error),
          fmt::format("in [robot] {}, or level the base", dynamics::mount_in_words(tilt.gravity))};
}

std::vector<Fault> faults_of(const MovedFrames& frames, const dynamics::RobotModel& robot) {
  const std::string times =
      fmt::format("{:.3g} times less of each joint unexplained", std::exp(frames.gain / robot.n()));
  const auto vector = [](const Eigen::Vector3d& x) {
    return fmt::format("({:.3f} {:.3f} {:.3f})", x[0], x[1], x[2]);
  };
  std::vector<Fault> faults;
  for (const MovedFrame& moved : frames.joints) {
    const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(moved.joint)];
    if (moved.zero != 0) {
      faults.push_back(
          {joint.name,
           fmt::format("its zero lies {:.3g} {} from that of the robot's file: {}", moved.zero,
                       unit_of_joint("rad", slides(joint)), times),
           "mend its <origin> in the URDF, or offset_rad of [position] in the contract"});
      continue;
    }
    std::vector<std::string> where;
    if (!moved.by.isZero())
      where.push_back(fmt::format("by {} m in the frame of its parent", vector(moved.by)));
    if (!moved.turn.isZero())
      where.push_back(fmt::format("turned by {} rad about its own", vector(moved.turn)));
    faults.push_back({joint.name,
                      fmt::format("its axis lies elsewhere than in the robot's file, {}: {}",
                                  fmt::join(where, ", "), times),
                      "mend <origin> and <axis> in the URDF, or take that of this arm"});
  }
  return faults;
}

Fault fault_of(const OtherGear& gear, const dynamics::RobotModel& robot) {
  return {
      robot.joints[static_cast<std::size_t>(gear.joint)].name,
      fmt::format("its gear has another ratio: it moves {:.3g} +- {:.1g} times as far as was "
                  "logged, and its torque is as many times less: {:.3g} times less of each joint "
                  "unexplained",
                  gear.ratio, gear.standard_error, std::exp(gear.gain / robot.n())),
      "correct gear_ratio of [position] and [torque] in the contract, or the unit of the encoder"};
}

/// Log of the share of the torque's variance that a regression leaves, in sum over the joints.
double log_unexplained(std::span<const signals::Recording> recordings, const RigidBodyFit& fit) {
  double sum = 0;
  for (Eigen::Index j = 0; j < fit.sigma.size(); ++j) {
    double torque = 0, square = 0, count = 0;
    for (const signals::Recording& r : recordings) {
      torque += r.filtered_tau.col(j).sum();
      square += r.filtered_tau.col(j).squaredNorm();
      count += static_cast<double>(r.filtered_tau.rows());
    }
    sum += std::log(fit.sigma[j] * fit.sigma[j] / (square / count - std::pow(torque / count, 2)));
  }
  return sum;
}

/// Torque columns of a robot with coupled motors that explain far more if they are read otherwise.
std::vector<Fault> find_misread_columns(const dynamics::RobotModel& robot,
                                        std::span<const signals::Recording> recordings,
                                        const RigidBodyOptions& options, const RigidBodyFit& fit) {
  std::vector<Fault> faults;
  if (!robot.coupled()) return faults;
  const double as_read = log_unexplained(recordings, fit);
  const Transmission transmission(robot);
  double best = kGain;
  for (const bool of_motors : {true, false}) {
    std::vector<signals::Recording> other(recordings.begin(), recordings.end());
    for (signals::Recording& r : other)
      r.filtered_tau = of_motors ? transmission.torque_to_joints(r.filtered_tau)
                                 : transmission.torque_to_motors(r.filtered_tau);
    const RigidBodyFit of_other = rigid_body_least_squares(robot, other, options);
    if (of_other.sigma.size() == 0) continue;
    const double gain = as_read - log_unexplained(other, of_other);
    if (!(gain > best)) continue;
    best = gain;
    faults = {
        {"",
         fmt::format("the torque leaves {:.0f} times less unexplained if its columns are those of "
                     "{}",
                     std::exp(gain), of_motors ? "the coupled motors" : "joints"),
         of_motors ? "in the contract [[coupling]] and kind = \"motor_torque\" (gear_ratio 1 where "
                     "the columns are multiplied by it), or log the torque about the joints"
                   : "kind = \"joint_torque\" in the contract, and [[robot.coupling]] in the "
                     "scene"}};
  }
  return faults;
}

/// A coupling of motors whose columns the log has, taken for those of joints.
struct CoupledColumns {
  dynamics::Coupling coupling;
  double gain = 0;
};

/// The coupling of neighbouring joints that explains most if the columns are those of its motors.
std::optional<CoupledColumns> find_columns_of_motors(const dynamics::RobotModel& robot,
                                                     std::span<const signals::Recording> recordings,
                                                     const RigidBodyOptions& options,
                                                     const RigidBodyFit& fit) {
  std::optional<CoupledColumns> best;
  if (robot.coupled()) return best;
  for (int j = 1; j < robot.n(); ++j) {
    if (slides(robot.joints[static_cast<std::size_t>(j)]) ||
        slides(robot.joints[static_cast<std::size_t>(j - 1)]))
      continue;
    for (const double factor : {-1.0, 1.0, -0.5, 0.5}) {
      dynamics::RobotModel coupled = robot;
      coupled.couplings = {{.joint = j, .motor = j - 1, .factor = factor}};
      const RigidBodyFit other = rigid_body_least_squares(coupled, recordings, options);
      if (other.sigma.size() == 0) continue;
      const double gain = gain_of(fit.sigma, other.sigma);
      if (gain > (best ? best->gain : kGain)) best = {coupled.couplings.front(), gain};
    }
  }
  return best;
}

Fault fault_of(const CoupledColumns& found, const dynamics::RobotModel& robot) {
  const auto name = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  const auto& [joint, motor, factor] = found.coupling;
  return {name(joint),
          fmt::format("{:.3g} times less of each joint unexplained if its columns and those of {} "
                      "are of coupled motors",
                      std::exp(found.gain / robot.n()), name(motor)),
          fmt::format("in the contract unit = \"motor_rad\" and kind = \"motor_torque\" "
                      "(gear_ratio 1 where it is in them), [[coupling]] joint = \"{}\", motor = "
                      "\"{}\", factor = {:g}",
                      name(joint), name(motor), factor)};
}

/// Columns of joint j for the unknowns base parameters, friction and growth, factors s (n), about
/// pi and s: with the target y + s_j Y pi the row is
///
///     s_j Y pi_new + s_new,j (Y pi) + friction.
Eigen::MatrixXd about(const StackedByJoint& all, const Eigen::VectorXd& pi, double s, int j) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(all.size, all.with_growth + all.n());
  T.topLeftCorner(all.with_growth, all.with_growth).setIdentity();
  T.diagonal().head(all.base).setConstant(s);
  T.col(all.with_growth + j).head(all.base) = pi;
  return T;
}

/// Standard errors of the factors over the middle one by the jackknife.
/// @param x  the solution about pi, s
Eigen::VectorXd errors_of(const StackedByJoint& all, const Eigen::VectorXd& pi,
                          const Eigen::VectorXd& s, const Eigen::VectorXd& x,
                          const Eigen::VectorXd& sigma, const Eigen::MatrixXd& prior) {
  const int n = all.n();
  const auto rows = [&](int j) {
    const JointRows& of_joint = all.joints[static_cast<std::size_t>(j)];
    const Eigen::VectorXd y = of_joint.y + s[j] * (of_joint.X.leftCols(all.base) * pi);
    return std::pair(Eigen::MatrixXd(of_joint.X * about(all, pi, s[j], j)), y);
  };
  const Eigen::MatrixXd root = jackknife_root(all, x, sigma, prior, rows).bottomRows(n);
  const int middle = middle_of(s);
  Eigen::VectorXd errors(n);
  for (int j = 0; j < n; ++j)
    errors[j] = (root.row(j) - root.row(middle) * (s[j] / s[middle])).norm() / s[middle];
  return errors;
}

/// Least squares in pi, s and friction by Gauss-Newton, no prior but s_j = 1 +- 0.5.
/// @param plain  solution with s = 1 and without growth
TorqueScales find_torque_scales(StackedByJoint all, const Solution& plain) {
  const int n = all.n();
  const Eigen::Index size = all.with_growth + n;
  if (n < 2 || all.rows <= size) return {};
  Solution apart = plain;
  for (int pass = 0; pass < kPasses; ++pass) {
    set_growth(apart.x.head(all.base), all);
    apart = solve(all, all.with_growth);
  }
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(size, size);
  prior.bottomRightCorner(n, n).diagonal().setConstant(std::pow(kWidth, -2));
  Eigen::VectorXd pi = apart.x.head(all.base), s = Eigen::VectorXd::Ones(n), sigma = apart.sigma;
  Eigen::VectorXd x;
  double change = 1;
  for (int step = 0; step < kMostSteps && change > kConverged; ++step) {
    set_growth(pi, all);
    Eigen::MatrixXd H = prior;
    Eigen::VectorXd g = prior * Eigen::VectorXd::Ones(size);
    std::vector<Eigen::MatrixXd> T;
    for (int j = 0; j < n; ++j) {
      const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
      const double weight = std::pow(sigma[j], -2);
      T.push_back(about(all, pi, s[j], j));
      H += weight * (T.back().transpose() * (rows.XX * T.back()));
      g += weight * (T.back().transpose() * (rows.Xy + s[j] * (rows.XX.leftCols(all.base) * pi)));
    }
    x = invert(H, nullptr) * g;
    if (!x.allFinite()) return {};
    for (int j = 0; j < n; ++j) {
      const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
      Eigen::VectorXd of_joint = T[static_cast<std::size_t>(j)] * x;
      of_joint.head(all.base) -= s[j] * pi;
      sigma[j] = sigma_of(rows.squares(of_joint), rows);
    }
    change = (x.tail(n) - s).cwiseAbs().maxCoeff();
    pi = x.head(all.base);
    s = x.tail(n);
  }
  if (change > kConverged || !(s.minCoeff() > kSmallest * s.maxCoeff())) return {};
  TorqueScales scales{s / s[middle_of(s)], Eigen::VectorXd::Zero(n), gain_of(apart.sigma, sigma)};
  if (scales.gain > kGain) scales.standard_error = errors_of(all, pi, s, x, sigma, prior);
  return scales;
}

/// What changes within or between logs, but for zeros.
std::vector<Fault> find_changes_and_contradictions(const dynamics::RobotModel& robot,
                                                   const StackedByJoint& all,
                                                   std::span<const signals::Recording> recordings) {
  const Changes changes = find_changes(robot, all, recordings);
  std::vector<Fault> faults;
  if (changes.what == Change::kOffset || changes.what == Change::kFactor) faults = changes.faults;
  // logs that differ in their bodies or friction are named by the parameter that differs
  if (faults.empty()) faults = find_contradicting_logs(all, recordings);
  return faults.empty() ? changes.faults : faults;
}

/// @param all  of the recordings
std::vector<Fault> find_differences(const dynamics::RobotModel& robot, const StackedByJoint& all,
                                    std::span<const signals::Recording> recordings,
                                    const RigidBodyOptions& options) {
  const OtherZeros zeros = find_other_zeros(robot, all, recordings, options);
  // another zero is believed where no other difference between the logs is left with it
  if (!zeros.faults.empty() &&
      find_changes_and_contradictions(robot, zeros.mended, recordings).empty())
    return zeros.faults;
  return find_changes_and_contradictions(robot, all, recordings);
}

}  // namespace

std::vector<Fault> find_differences(const dynamics::RobotModel& robot,
                                    std::span<const signals::Recording> recordings,
                                    const RigidBodyOptions& options) {
  return find_differences(robot, stack_by_joint(robot, recordings, options), recordings, options);
}

std::vector<Fault> find_contradictions(const dynamics::RobotModel& robot,
                                       std::span<const signals::Recording> recordings,
                                       const RigidBodyOptions& options, const RigidBodyFit& fit) {
  if (fit.sigma.size() == 0) return {};
  std::vector<Fault> faults = find_misread_columns(robot, recordings, options, fit);
  if (!faults.empty()) return faults;
  faults = find_undriven(robot, recordings, options, fit);
  if (!faults.empty() || !fit.prior.empty()) return faults;
  const StackedByJoint all = stack_by_joint(robot, recordings, options);
  const Solution plain = solve(all, all.plain);
  const TorqueScales scales = find_torque_scales(all, plain);
  const Springs springs = find_springs(all, plain.sigma);
  const std::optional<Tilt> tilt = find_tilt(robot, all, recordings, options);
  // another geometry makes logs of other poses differ
  const MovedFrames frames = find_moved_frames(robot, all, recordings, options);
  const double others = std::max({springs.gain, scales.gain, tilt ? tilt->gain : 0});
  // gravity of a forearm that a parallel linkage holds looks like a spring, or an axis elsewhere
  if (std::max(others, frames.gain) > kGain)
    if (const auto coupled = find_columns_of_motors(robot, recordings, options, fit);
        coupled && coupled->gain > std::max(others, frames.gain))
      return {fault_of(*coupled, robot)};
  // another ratio has one unknown, and other causes stand for it
  const std::optional<OtherGear> gear = find_other_gear(robot, all, recordings, options);
  if (gear && gear->gain > std::max(others, frames.gain - kOfFrames))
    return {fault_of(*gear, robot)};
  if (!frames.joints.empty() && frames.gain > others + kOfFrames) return faults_of(frames, robot);
  faults = find_differences(robot, all, recordings, options);
  if (!faults.empty()) return faults;
  const auto name = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  if (tilt && tilt->gain > std::max(springs.gain, scales.gain)) {
    faults.push_back(fault_of(*tilt));
  } else if (springs.gain > scales.gain) {
    for (const int j : springs.joints)
      faults.push_back(spring_at(robot.joints[static_cast<std::size_t>(j)]));
  } else if (scales.gain > kGain) {
    for (const int j : scaled_joints(scales))
      faults.push_back(
          {name(j),
           fmt::format("its torque is {:.3g} +- {:.1g} times what the other joints say of the "
                       "bodies that it moves",
                       scales.value[j], scales.standard_error[j]),
           fmt::format("correct its torque constant, gear ratio or scale: scale of [torque] in the "
                       "contract, {:.3g} times what it is, makes them agree",
                       1 / scales.value[j])});
  }
  return faults.empty() ? find_changing_friction(robot, all, recordings) : faults;
}

}  // namespace fricid::estimate
