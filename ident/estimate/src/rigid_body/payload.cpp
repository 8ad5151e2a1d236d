#include "fricid/estimate/rigid_body/payload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "fricid/dynamics/physical_inertia.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/reweight.hpp"
#include "rigid_body/zeros.hpp"

namespace fricid::estimate {
namespace {

using dynamics::Vector10;

constexpr int kLoad = 10;   // parameters of a body
constexpr int kPasses = 4;  // of the regression

// A load so wide that it only decides what the data leave open: a ton, a metre away.
Vector10 widest() { return Vector10{{1e3, 1e3, 1e3, 1e3, 1e3, 1e3, 1e3, 1e3, 1e3, 1e3}}; }

/// Unknowns: arm (p), friction without (5 n), friction with (5 n), load (10). Friction is that of
/// the regression (3 n), the bend of its viscous curve (n) and its growth with the torque (n).
struct LoadColumns {
  int p, n;
  int friction(bool with) const { return p + (with ? 5 * n : 0); }
  int bend(bool with) const { return friction(with) + 3 * n; }
  int growth(bool with) const { return friction(with) + 4 * n; }
  int load() const { return p + 10 * n; }
  int size() const { return load() + kLoad; }
};

// Both regressions as one; joints of the loaded logs are groups n, n + 1, ...
Regression joined(const LoadColumns& at, int link, const Regression& without,
                  const Regression& with) {
  const Eigen::Index first = without.tau.size(), second = with.tau.size();
  Regression all;
  all.rows.setZero(first + second, at.size());
  all.rows.topLeftCorner(first, at.p) = without.rows.leftCols(at.p);
  all.rows.bottomLeftCorner(second, at.p) = with.rows.leftCols(at.p);
  all.rows.block(0, at.friction(false), first, 3 * at.n) = without.rows.rightCols(3 * at.n);
  all.rows.block(first, at.friction(true), second, 3 * at.n) = with.rows.rightCols(3 * at.n);
  all.rows.bottomRightCorner(second, kLoad) = with.rows.middleCols(kLoad * link, kLoad);
  all.tau.resize(first + second);
  all.tau << without.tau, with.tau;
  all.late.resize(first + second);
  all.late << without.late, with.late;
  all.joint = without.joint;
  for (const int j : with.joint) all.joint.push_back(at.n + j);
  all.passage = without.passage;
  const int before = without.passage.empty() ? 0 : 1 + std::ranges::max(without.passage);
  for (const int i : with.passage) all.passage.push_back(before + i);
  return all;
}

// Friction that is not in the regression: a viscous curve that is no line, and growth of the
// Coulomb friction with the torque of the motor.
// @param tau  (N) that torque
void set_curves(const LoadColumns& at, const Eigen::VectorXd& tau, Regression& all) {
  for (Eigen::Index r = 0; r < tau.size(); ++r) {
    const int group = all.joint[static_cast<std::size_t>(r)], j = group % at.n;
    const bool with = group >= at.n;
    const int friction = at.friction(with) + j;
    const double coulomb = all.rows(r, friction), v = all.rows(r, friction + at.n);
    all.rows(r, at.bend(with) + j) = std::copysign(std::sqrt(std::abs(v)), v);
    all.rows(r, at.growth(with) + j) = std::abs(tau[r]) * coulomb;
  }
}

// Precision (square, as many as unknowns) that holds what the data leave open.
Eigen::MatrixXd wide_precision(const LoadColumns& at, const dynamics::Nominal& nominal) {
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(at.size(), at.size());
  const Eigen::MatrixXd pull = weak_pull(nominal.robot, nominal.guesses);
  precision.topLeftCorner(at.p, at.p) = pull.transpose() * pull;
  precision.diagonal().head(at.load()).array() += 1e-12;  // linear torques and friction not excited
  for (const bool with : {false, true})
    precision.diagonal()
        .segment(at.growth(with), at.n)
        .setConstant(1 / (kUsualGrowth * kUsualGrowth));
  precision.diagonal().tail(kLoad) = widest().cwiseAbs2().cwiseInverse();
  return precision;
}

// d (m, c, I about the centre of mass) / d (m, m c, I about the origin), by columns of the latter.
Eigen::Matrix<double, 10, 10> body_jacobian(const Vector10& pi) {
  const double m = pi[0];
  const Eigen::Vector3d h = pi.segment<3>(1), c = h / m;
  const auto steiner = [](const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
    return Eigen::Matrix3d(x.dot(y) * Eigen::Matrix3d::Identity() -
                           0.5 * (x * y.transpose() + y * x.transpose()));
  };
  Eigen::Matrix<double, 10, 10> J = Eigen::Matrix<double, 10, 10>::Identity();
  const auto set_inertia = [&](int column, const Eigen::Matrix3d& dI) {
    J.col(column).tail<6>() << dI(0, 0), dI(0, 1), dI(1, 1), dI(0, 2), dI(1, 2), dI(2, 2);
  };
  J.col(0).segment<3>(1) = -c / m;
  set_inertia(0, steiner(c, c));
  for (int k = 0; k < 3; ++k) {
    J.col(1 + k).segment<3>(1) = Eigen::Vector3d::Unit(k) / m;
    set_inertia(1 + k, -2 * steiner(c, Eigen::Vector3d::Unit(k)));
  }
  return J;
}

Eigen::Matrix3d symmetric(const Eigen::Matrix<double, 6, 1>& I) {
  Eigen::Matrix3d M;
  M << I[0], I[1], I[3], I[1], I[2], I[4], I[3], I[4], I[5];
  return M;
}

// A ball to begin with: of the estimated mass, where that is one.
Vector10 ball(double mass) {
  constexpr double kRadius = 0.1, kLightest = 1e-3;
  const double m = std::max(mass, kLightest), I = 0.4 * m * kRadius * kRadius;
  return Vector10{{m, 0, 0, 0, I, 0, I, 0, 0, I}};
}

/// By how much the torque of the arm without the load is larger in the logs with it, as a share:
/// one more unknown, of the column that the solution gives that torque.
struct Excess {
  double share = 0, error = 0;
  double left = 0;  ///< sum of the logs of the joints' sigmas: less explains more

  bool is_seen() const {
    constexpr double kSigmas = 5, kLeast = 0.02;  // below: the torque constant of a warm motor
    return std::abs(share) > std::max(kSigmas * error, kLeast);
  }
};

/// A position that the logs with the load show larger than those without it [rad or m].
struct Shift {
  int joint = -1;  ///< -1: none
  double by = 0, error = 0;
  double left = 0;  ///< likewise
};

/// The regression, and what decides where the data are silent.
struct Problem {
  const Regression& data;
  const Eigen::MatrixXd& precision;
  const Eigen::VectorXd& mean;
  bool robust;
};

/// Unknowns beside those of the problem, each N(0, 1) a priori, and their errors.
struct Further {
  Eigen::VectorXd x, error, sigma;
  double left() const { return sigma.array().max(1e-300).log().sum(); }
};

/// @param columns  (N x ..) of them
Further solve_with(const LoadColumns& at, const Problem& problem, const Eigen::MatrixXd& columns) {
  const Eigen::Index own = at.size(), more = columns.cols(), all = own + more;
  Eigen::MatrixXd rows(columns.rows(), all), precision = Eigen::MatrixXd::Identity(all, all);
  rows << problem.data.rows, columns;
  precision.topLeftCorner(own, own) = problem.precision;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(all);
  mean.head(own) = problem.mean;
  const Regression& data = problem.data;
  const Weighted solved =
      reweight(rows, data.tau, data.joint, 2 * at.n, problem.robust, precision, mean);
  const Eigen::MatrixXd root = jackknife_root(rows, data.tau, solved, data.passage, precision);
  return {solved.x.tail(more), root.bottomRows(more).rowwise().norm(), solved.sigma};
}

Excess excess_of(const LoadColumns& at, const Problem& problem, const Eigen::VectorXd& x) {
  Eigen::VectorXd arm = problem.data.rows.leftCols(at.p) * x.head(at.p);
  for (Eigen::Index r = 0; r < arm.size(); ++r)
    if (problem.data.joint[static_cast<std::size_t>(r)] < at.n) arm[r] = 0;
  const Further found = solve_with(at, problem, arm);
  return {found.x[0], found.error[0], found.left()};
}

/// Torque of shifts (N x n) in the rows with the load, zero in those without.
/// @param second  the regression with the load, whose rows come last
/// @param rows    N, of both logs
Eigen::MatrixXd shifts_of_loaded(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                                 const Regression& second, std::span<const signals::Recording> with,
                                 Eigen::Index rows) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows, robot.n());
  out.bottomRows(second.tau.size()) =
      torque_of_shifts(robot, pi, second.joint, second.sequence, second.sample, with);
  return out;
}

/// The shift that is surest, where it explains a share of what a joint leaves.
Shift shift_of(const LoadColumns& at, const Problem& problem, const Weighted& plain,
               const Eigen::MatrixXd& columns) {
  constexpr double kSigmas = 6, kLeast = 2e-3, kGain = 1.1;  // [rad or m]; of a joint's variance
  const Further found = solve_with(at, problem, columns);
  const Eigen::ArrayXd ratio = plain.sigma.array() / found.sigma.array();
  if (!(ratio.isFinite().select(ratio, 1).square().maxCoeff() > kGain)) return {};
  Shift surest;
  for (int j = 0; j < at.n; ++j) {
    const double by = found.x[j], error = found.error[j];
    if (!(std::abs(by) > std::max(kSigmas * error, kLeast))) continue;
    if (surest.joint < 0 || std::abs(by) * surest.error > std::abs(surest.by) * error)
      surest = {j, by, error, found.left()};
  }
  return surest;
}

// Outcome and message of a solution.
void judge(const dynamics::RobotModel& robot, Eigen::Index equations, const Excess& excess,
           const Shift& shift, PayloadFit& fit) {
  constexpr double kDetermined = 0.5;  // of the size
  constexpr double kSeen = 3;          // standard errors of the mass
  const auto lost = (fit.standard_error.array() > kDetermined * fit.size.array()).count();
  const double lighter = -fit.free[0], error = fit.standard_error[0];
  if (!fit.pi.allFinite() || !fit.standard_error.allFinite()) {
    fit.message = "no finite solution";
    return;
  }
  if (shift.joint >= 0 && (!excess.is_seen() || shift.left < excess.left)) {
    const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(shift.joint)];
    fit.message = fmt::format(
        "the logs with the load show {} {:.3g} +- {:.1g} {} further than those without it: another "
        "zero of the joint; record both with one, or mend offset_rad of [position] in the contract",
        joint.name, shift.by, shift.error, unit_of_joint("rad", slides(joint)));
    return;
  }
  if (excess.is_seen()) {
    fit.message = fmt::format(
        "the logs with the load show {:.3g} +- {:.1g} times the torque of the arm that those "
        "without it show: another arm, another zero of a joint, or another torque scale in one of "
        "the two; "
        "make scale of [torque] in the contract agree, or record both alike",
        1 + excess.share, excess.error);
    return;
  }
  if (lighter > kSeen * error) {
    fit.message = fmt::format(
        "the logs with the load show {:.3g} +- {:.1g} kg less than those without it: swap the two",
        lighter, error);
    return;
  }
  fit.outcome = lost > 0 ? Outcome::kIllConditioned : Outcome::kConverged;
  if (fit.body.m < kSeen * fit.body_error.m)
    fit.message =
        fmt::format("no load is seen: mass {:.2g} +- {:.2g} kg", fit.body.m, fit.body_error.m);
  else if (lost > 0)
    fit.message = fmt::format(
        "{} of 10 parameters have a standard error above half of their size: turn the load about "
        "more axes",
        lost);
  else
    fit.message = fmt::format("{} equations", equations);
}

}  // namespace

PayloadFit payload_least_squares(const dynamics::RobotModel& robot, const dynamics::Frame& frame,
                                 std::span<const signals::Recording> without,
                                 std::span<const signals::Recording> with,
                                 const RigidBodyOptions& options) {
  if (frame.link < 0)
    throw UserError("frame {}: does not move; allowed: one that a joint carries", frame.name);
  const dynamics::Nominal nominal = dynamics::complete(robot);
  const LoadColumns at{robot.parameter_count(), robot.n()};
  PayloadFit fit;
  RigidBodyFit counts, loaded;
  const Regression first = stack(robot, without, options, nullptr, counts);
  const Regression second = stack(robot, with, options, nullptr, loaded);
  for (int j = 0; j < at.n; ++j)
    fit.equations.push_back(counts.equations[static_cast<std::size_t>(j)] +
                            loaded.equations[static_cast<std::size_t>(j)]);
  if (std::min(first.tau.size(), second.tau.size()) <= kLoad + 3 * at.n) {
    fit.message = fmt::format(
        "joints slide at {} samples without the load and at {} with it, too few for a load; record "
        "motion of all joints in both, every channel at every sample",
        first.tau.size(), second.tau.size());
    return fit;
  }
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(at.size());
  mean.head(at.p) = nominal.robot.pi;
  Regression data = joined(at, frame.link, first, second);
  const Eigen::MatrixXd precision = wide_precision(at, nominal);
  const Eigen::VectorXd no_growth = Eigen::VectorXd::Zero(data.tau.size());
  Weighted solved;
  for (int pass = 0; pass < kPasses; ++pass) {
    // the measured torque in a regressor would explain itself where an axis is mostly friction
    set_curves(at, pass > 0 ? Eigen::VectorXd(data.rows * solved.x) : no_growth, data);
    solved = reweight(data.rows, data.tau, data.joint, 2 * at.n, options.robust, precision, mean);
  }
  fit.sigma = solved.sigma;

  // in the frame: free, then the nearest body
  const Eigen::Matrix<double, 10, 10> T = dynamics::inertia_in_frame(frame.R, frame.p);
  const Eigen::MatrixXd inverse = invert(solved.H, nullptr);
  const Eigen::MatrixXd covariance = T * inverse.bottomRightCorner<kLoad, kLoad>() * T.transpose();
  fit.free = T * solved.x.tail<kLoad>();
  const Eigen::MatrixXd of_blocks =
      jackknife_root(data.rows, data.tau, solved, data.passage, precision);
  Eigen::MatrixXd errors(kLoad, of_blocks.cols() + 1);
  errors << of_blocks.bottomRows<kLoad>(),
      moved_by(data.late, data.rows, solved, inverse).tail<kLoad>();
  errors = (T * errors).eval();
  fit.standard_error = errors.rowwise().norm();
  const Eigen::MatrixXd root = inverse_root(covariance);
  fit.pi = fit_physical_body(root, root * fit.free, ball(fit.free[0]));
  fit.size << fit.pi[0], Eigen::Vector3d::Constant(fit.pi.segment<3>(1).norm()),
      Eigen::Matrix<double, 6, 1>::Constant((fit.pi[4] + fit.pi[6] + fit.pi[9]) / 3);

  const Eigen::Matrix<double, 10, 10> J = body_jacobian(fit.pi);
  const Vector10 error = (J * errors).rowwise().norm();
  fit.body = dynamics::body_of(fit.pi);
  fit.body_error = {error[0], error.segment<3>(1), symmetric(error.tail<6>())};

  const Problem problem{data, precision, mean, options.robust};
  Eigen::VectorXd carrying = solved.x.head(at.p);
  carrying.segment<kLoad>(kLoad * frame.link) += solved.x.tail<kLoad>();
  const Eigen::MatrixXd shifts = shifts_of_loaded(robot, carrying, second, with, data.tau.size());
  judge(robot, data.tau.size(), excess_of(at, problem, solved.x),
        shift_of(at, problem, solved, shifts), fit);
  return fit;
}

}  // namespace fricid::estimate
