#include "fricid/sim/excitation.hpp"

#include <fmt/format.h>
#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <span>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/sim/clearance.hpp"
#include "fricid/sim/streams.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Points per period of the fastest harmonic: while searching, and for the last word.
constexpr int kDesignDensity = 8, kCheckDensity = 80;
// What a limit may be exceeded by between the points of the last check, as a share and in metres.
constexpr double kShareGuard = 2e-3, kClearanceGuard = 1e-3;
// Criterion evaluations of the optimiser; 400 gain less than 0.4 in log det.
constexpr int kEvaluations = 120;
// Shrinking stops here: then the box itself is not free.
constexpr int kShrinks = 60;
constexpr double kShrink = 0.95;

/// Friction that the torque limit leaves room for, as shares of effort: at rest, and more at the
/// velocity limit. Upper ends of what is reported for geared industrial joints (Coulomb 5-8 %,
/// viscous 15-30 %).
constexpr double kFrictionAtRest = 0.08, kFrictionAtSpeed = 0.3;

/// Limits of one joint.
struct Bounds {
  double centre, half, velocity, acceleration, jerk, effort;
};

double or_infinity(double share, double limit) { return limit > 0 ? share * limit : kInfinity; }

std::vector<Bounds> make_bounds(const ExcitationOptions& config,
                                const dynamics::RobotModel& robot) {
  std::vector<Bounds> bounds;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const dynamics::Joint& joint = robot.joints[j];
    const bool limited = !joint.continuous && joint.upper > joint.lower;
    const double middle = limited ? (joint.lower + joint.upper) / 2 : 0;
    const double half = limited ? (joint.upper - joint.lower) / 2 : std::numbers::pi;
    Bounds b{config.centre.empty() ? middle : config.centre[j],
             config.half_range.empty() ? 0.9 * half : config.half_range[j],
             or_infinity(config.velocity_share, joint.velocity),
             or_infinity(config.acceleration_share, joint.acceleration),
             or_infinity(config.jerk_share, joint.jerk),
             or_infinity(config.torque_share, joint.effort)};
    if (limited && (b.centre - b.half < joint.lower || b.centre + b.half > joint.upper))
      throw UserError("excitation: {}: box [{:.3f}, {:.3f}] rad is outside [{:.3f}, {:.3f}]",
                      joint.name, b.centre - b.half, b.centre + b.half, joint.lower, joint.upper);
    bounds.push_back(b);
  }
  return bounds;
}

/// What all trajectories of a scene share.
struct Problem {
  const ExcitationOptions& config;
  const MujocoArm& arm;
  const dynamics::RobotModel& robot;
  std::vector<Bounds> bounds;
  std::vector<int> columns;  ///< of the base parameters
  TimeGrid design, check;
  Eigen::MatrixXd known;  ///< information of earlier data, per second of this period; may be empty

  Problem(const ExcitationOptions& c, const MujocoArm& m, const dynamics::RobotModel& r)
      : config(c),
        arm(m),
        robot(r),
        bounds(make_bounds(c, r)),
        columns(dynamics::base_parameters(r).columns),
        design(TimeGrid::over_period(c.base_rad_s, c.harmonics, kDesignDensity * c.harmonics)),
        check(TimeGrid::over_period(c.base_rad_s, c.harmonics, kCheckDensity * c.harmonics)) {}
};

/// What a thread needs of its own to judge trajectories.
class Judge {
 public:
  explicit Judge(const Problem& problem)
      : problem_(problem),
        C_(Transmission(problem.robot).inverse()),
        ws_(problem.robot),
        // twice the demand, so that a search sees where it goes
        clearance_(problem.arm, 2 * (problem.config.clearance_m + kClearanceGuard) + 0.05),
        Y_(problem.robot.n(), problem.robot.parameter_count()),
        Y_base_(problem.robot.n(), static_cast<Eigen::Index>(problem.columns.size())) {}

  /// Information matrix  mean_t Y_b' W Y_b  with W = diag(1 / effort^2), and what is known already.
  Eigen::MatrixXd information(const Motion& at_joints) {
    const Motion motion = at_motors(at_joints);
    const auto size = static_cast<Eigen::Index>(problem_.columns.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
    for (Eigen::Index k = 0; k < motion.q.cols(); ++k) {
      dynamics::regressor(problem_.robot, ws_, column(motion.q, k), column(motion.v, k),
                          column(motion.a, k), Y_);
      for (Eigen::Index c = 0; c < size; ++c)
        Y_base_.col(c) = Y_.col(problem_.columns[static_cast<std::size_t>(c)]);
      for (Eigen::Index j = 0; j < Y_base_.rows(); ++j) {
        const double effort = problem_.robot.joints[static_cast<std::size_t>(j)].effort;
        if (effort > 0) Y_base_.row(j) /= effort;
      }
      H.selfadjointView<Eigen::Lower>().rankUpdate(Y_base_.transpose());
    }
    H /= static_cast<double>(motion.q.cols());
    if (problem_.known.size() > 0) H += problem_.known;
    return H;
  }

  /// Largest share of the effort limit that rigid body and friction allowance take, per motor.
  Eigen::VectorXd torque_shares(const Motion& at_joints) {
    const Motion motion = at_motors(at_joints);
    const dynamics::RobotModel& robot = problem_.robot;
    Eigen::VectorXd shares = Eigen::VectorXd::Zero(robot.n());
    std::vector<double> tau(static_cast<std::size_t>(robot.n()));
    const std::span<const double> pi{robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
    for (Eigen::Index k = 0; k < motion.q.cols(); ++k) {
      dynamics::rnea<double>(robot, ws_, pi, column(motion.q, k), column(motion.v, k),
                             column(motion.a, k), tau);
      for (Eigen::Index j = 0; j < shares.size(); ++j) {
        const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
        if (joint.effort <= 0) continue;
        const double speed = joint.velocity > 0 ? std::abs(motion.v(j, k)) / joint.velocity : 0;
        const double share = std::abs(tau[static_cast<std::size_t>(j)]) / joint.effort +
                             kFrictionAtRest + kFrictionAtSpeed * speed;
        shares[j] = std::max(shares[j], share);
      }
    }
    return shares;
  }

  /// Closest approach on the whole motion.
  Clearance::Pair closest(const Motion& motion, int stride = 1) {
    Clearance::Pair best{kInfinity, -1, -1};
    for (Eigen::Index k = 0; k < motion.q.cols(); k += stride) {
      const Clearance::Pair pair = clearance_.closest(column(motion.q, k));
      if (pair.distance < best.distance) best = pair;
    }
    return best;
  }

  const Clearance& clearance() const { return clearance_; }

 private:
  static std::span<const double> column(const Eigen::MatrixXd& matrix, Eigen::Index k) {
    return {matrix.col(k).data(), static_cast<std::size_t>(matrix.rows())};
  }

  Motion at_motors(const Motion& motion) const {
    if (C_.size() == 0) return motion;
    Motion m = motion;
    for (auto* x : {&m.q, &m.v, &m.a}) *x = C_ * *x;
    return m;
  }

  const Problem& problem_;
  Eigen::MatrixXd C_;  ///< motors of joints; empty without couplings
  dynamics::Workspace<double> ws_;
  Clearance clearance_;
  Eigen::MatrixXd Y_, Y_base_;
};

double log_det(const Eigen::MatrixXd& H) {
  const Eigen::VectorXd d = H.selfadjointView<Eigen::Lower>().ldlt().vectorD();
  return (d.array() > 0).all() ? d.array().log().sum() : -kInfinity;
}

double condition(const Eigen::MatrixXd& H) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H, Eigen::EigenvaluesOnly);
  const Eigen::VectorXd& lambda = eigen.eigenvalues();
  return lambda[0] > 0 ? std::sqrt(lambda[lambda.size() - 1] / lambda[0]) : kInfinity;
}

double cost(Criterion criterion, const Eigen::MatrixXd& H) {
  return criterion == Criterion::kCondition ? std::log(condition(H)) : -log_det(H);
}

/// Per joint: share of the amplitude that its limits allow, place of the centre in the room that
/// this leaves, and angle of the mix of two random series.
constexpr int kVariables = 3;

/// Two random series at rest at both ends; a point of the search turns them into a trajectory.
struct Draw {
  Fourier first, second;
};

Fourier random_series(const ExcitationOptions& config, int n, Rng& rng) {
  Fourier series{config.base_rad_s, Eigen::VectorXd::Zero(n), Eigen::MatrixXd(n, config.harmonics),
                 Eigen::MatrixXd(n, config.harmonics)};
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < config.harmonics; ++k) {
      const double amplitude = std::pow(k + 1, config.spectrum);
      series.a(j, k) = amplitude * rng.normal();
      series.b(j, k) = amplitude * rng.normal();
    }
  }
  start_at_rest(series);
  return series;
}

// Largest factor on the amplitude of a joint that keeps its own limits; motion about q0 = 0.
double allowed_factor(const Bounds& bounds, const Motion& motion, Eigen::Index j) {
  const auto peak = [j](const Eigen::MatrixXd& m) { return m.row(j).cwiseAbs().maxCoeff(); };
  const double span = (motion.q.row(j).maxCoeff() - motion.q.row(j).minCoeff()) / 2;
  return (1 - kShareGuard) *
         std::min({bounds.half / span, bounds.velocity / peak(motion.v),
                   bounds.acceleration / peak(motion.a), bounds.jerk / peak(motion.jerk)});
}

// Scales joint j by `share` of what its limits allow and puts it at `place` in [-1, 1] of its box.
void fit_joint(const Bounds& bounds, const Motion& motion, Eigen::Index j, double share,
               double place, Fourier& series) {
  const double factor = share * allowed_factor(bounds, motion, j);
  const double low = factor * motion.q.row(j).minCoeff(),
               high = factor * motion.q.row(j).maxCoeff();
  series.a.row(j) *= factor;
  series.b.row(j) *= factor;
  series.q0[j] =
      bounds.centre - (low + high) / 2 + place * std::max(0.0, bounds.half - (high - low) / 2);
}

// A point of the search as a trajectory that keeps every joint's own limits on the grid.
Fourier make_series(const Problem& problem, const TimeGrid& grid, const Draw& draw,
                    const double* x) {
  Fourier series = draw.first;
  series.q0.setZero();
  for (Eigen::Index j = 0; j < series.q0.size(); ++j) {
    const double angle = x[kVariables * j + 2];
    series.a.row(j) =
        std::cos(angle) * draw.first.a.row(j) + std::sin(angle) * draw.second.a.row(j);
    series.b.row(j) =
        std::cos(angle) * draw.first.b.row(j) + std::sin(angle) * draw.second.b.row(j);
  }
  const Motion motion = grid.sample(series);
  for (Eigen::Index j = 0; j < series.q0.size(); ++j)
    fit_joint(problem.bounds[static_cast<std::size_t>(j)], motion, j, x[kVariables * j],
              x[kVariables * j + 1], series);
  return series;
}

// How far torque and clearance limits are broken, in shares.
double violation(const Problem& problem, Judge& judge, const Motion& motion, int stride = 1) {
  const Eigen::VectorXd shares = judge.torque_shares(motion);
  double sum = (shares.array() / problem.config.torque_share - (1 - kShareGuard)).max(0).sum();
  const double wanted = problem.config.clearance_m + kClearanceGuard;
  sum += std::max(0.0, (wanted - judge.closest(motion, stride).distance) / wanted);
  return sum;
}

/// One search: minimises cost + penalty over the variables of all joints.
struct Search {
  const Problem& problem;
  Judge& judge;
  Draw draw;
  int evaluations = 0;

  double operator()(const double* x) {
    ++evaluations;
    const Motion motion = problem.design.sample(make_series(problem, problem.design, draw, x));
    // a broken limit costs more than any gain of the criterion
    constexpr double kPenalty = 100;
    return cost(problem.config.criterion, judge.information(motion)) +
           kPenalty * violation(problem, judge, motion, 2);
  }
};

double nlopt_objective(unsigned, const double* x, double*, void* search) {
  return (*static_cast<Search*>(search))(x);
}

struct NloptDeleter {
  void operator()(nlopt_opt_s* opt) const { nlopt_destroy(opt); }
};

void improve(Search& search, std::vector<double>& x) {
  const auto size = static_cast<unsigned>(x.size());
  std::vector<double> lower(size), upper(size), step(size);
  for (std::size_t i = 0; i < size; i += kVariables) {
    const std::array<double, 3> low{0.3, -1, -std::numbers::pi}, high{1, 1, std::numbers::pi},
        first{0.1, 0.4, 0.4};
    for (std::size_t v = 0; v < kVariables; ++v) {
      lower[i + v] = low[v];
      upper[i + v] = high[v];
      step[i + v] = first[v];
    }
  }
  const std::unique_ptr<nlopt_opt_s, NloptDeleter> opt(nlopt_create(NLOPT_LN_BOBYQA, size));
  nlopt_set_lower_bounds(opt.get(), lower.data());
  nlopt_set_upper_bounds(opt.get(), upper.data());
  nlopt_set_initial_step(opt.get(), step.data());
  nlopt_set_maxeval(opt.get(), kEvaluations);
  nlopt_set_min_objective(opt.get(), nlopt_objective, &search);
  double best = 0;
  const std::vector<double> start = x;
  if (nlopt_optimize(opt.get(), x.data(), &best) < 0 && search(x.data()) > search(start.data()))
    x = start;
}

// Shrinks a trajectory about the box centres until every limit holds on the check grid.
bool make_feasible(const Problem& problem, Judge& judge, const Draw& draw, std::vector<double>& x,
                   Fourier& series) {
  for (int shrink = 0; shrink < kShrinks; ++shrink) {
    series = make_series(problem, problem.check, draw, x.data());
    // the coarse grid first: most failures show there
    if (violation(problem, judge, problem.design.sample(series)) == 0 &&
        violation(problem, judge, problem.check.sample(series)) == 0)
      return true;
    for (std::size_t i = 0; i < x.size(); i += kVariables) {
      x[i] *= kShrink;
      x[i + 1] *= kShrink;
    }
  }
  return false;
}

TrajectoryReport examine_on(const Problem& problem, Judge& judge, const Fourier& series,
                            const TimeGrid& grid) {
  TrajectoryReport report;
  const Motion motion = grid.sample(series);
  const Eigen::VectorXd torque = judge.torque_shares(motion);
  const Eigen::MatrixXd H = judge.information(problem.design.sample(series));
  report.log_det = log_det(H);
  report.condition = condition(H);
  const Clearance::Pair pair = judge.closest(motion);
  report.clearance_m = pair.distance;
  report.closest = judge.clearance().name(pair);
  report.feasible = report.clearance_m >= problem.config.clearance_m;
  for (Eigen::Index j = 0; j < motion.q.rows(); ++j) {
    const Bounds& bounds = problem.bounds[static_cast<std::size_t>(j)];
    const auto left = [j](const Eigen::MatrixXd& m, double limit) {
      return 1 - m.row(j).cwiseAbs().maxCoeff() / limit;
    };
    const double reach = (motion.q.row(j).array() - bounds.centre).abs().maxCoeff();
    const JointMargins margins{problem.robot.joints[static_cast<std::size_t>(j)].name,
                               bounds.half - reach,
                               left(motion.v, bounds.velocity),
                               left(motion.a, bounds.acceleration),
                               left(motion.jerk, bounds.jerk),
                               1 - torque[j] / problem.config.torque_share};
    report.joints.push_back(margins);
    report.feasible =
        report.feasible && std::min({margins.position_rad, margins.velocity, margins.acceleration,
                                     margins.jerk, margins.torque}) >= 0;
  }
  return report;
}

Fourier design(const Problem& problem, std::uint64_t seed, int number, TrajectoryReport& report) {
  Judge judge(problem);
  const int n = problem.robot.n();
  std::vector<double> x(static_cast<std::size_t>(kVariables * n), 0.0);
  for (std::size_t i = 0; i < x.size(); i += kVariables) x[i] = 0.95;

  // best of the random starts
  const int restarts = problem.config.criterion == Criterion::kNone ? 1 : problem.config.restarts;
  Search search{problem, judge, {}};
  Draw best_draw;
  double best = kInfinity;
  for (int r = 0; r < restarts; ++r) {
    Rng rng = make_rng(seed, Purpose::kExcitation, number, r);
    search.draw.first = random_series(problem.config, n, rng);
    search.draw.second = random_series(problem.config, n, rng);
    const double value = search(x.data());
    if (r > 0 && value >= best) continue;
    best = value;
    best_draw = search.draw;
  }
  search.draw = best_draw;
  report.log_det_start = log_det(judge.information(
      problem.design.sample(make_series(problem, problem.design, best_draw, x.data()))));

  if (problem.config.criterion != Criterion::kNone) improve(search, x);
  Fourier series;
  make_feasible(problem, judge, best_draw, x, series);

  const TrajectoryReport found = examine_on(problem, judge, series, problem.check);
  const double start = report.log_det_start;
  const std::string name = report.name;
  report = found;
  report.name = name;
  report.log_det_start = start;
  report.evaluations = search.evaluations;
  return series;
}

std::string broken_limit(const TrajectoryReport& report, const ExcitationOptions& config,
                         const dynamics::RobotModel& robot) {
  for (std::size_t j = 0; j < report.joints.size(); ++j)
    if (report.joints[j].torque < 0)
      return fmt::format("torque of {} exceeds torque_share = {}", robot.joints[j].name,
                         config.torque_share);
  if (report.clearance_m >= config.clearance_m)
    return fmt::format(
        "no random start of {} was inside the limits of position, velocity, "
        "acceleration and jerk; raise restarts or shrink half_range",
        config.restarts);
  return fmt::format("{}: {:.3f} m apart in every motion tried; allowed: clearance_m = {} or more",
                     report.closest.empty() ? "closest bodies" : report.closest, report.clearance_m,
                     config.clearance_m);
}

}  // namespace

Excitation design_excitation(const ExcitationOptions& config, const MujocoArm& arm,
                             const dynamics::RobotModel& robot, std::uint64_t seed, int jobs,
                             const Eigen::MatrixXd& known) {
  Problem problem(config, arm, robot);
  if (known.size() > 0) problem.known = known * (config.base_rad_s / (2 * std::numbers::pi));
  const int count = config.train + config.validation;
  std::vector<Fourier> series(static_cast<std::size_t>(count));
  Excitation excitation;
  excitation.reports.resize(static_cast<std::size_t>(count));
  Progress progress("excitation", count);
  parallel_for(count, jobs, [&](int i) {
    throw_if_stopped();
    TrajectoryReport& report = excitation.reports[static_cast<std::size_t>(i)];
    const bool training = i < config.train;
    report.name =
        fmt::format("{}_{}", training ? "train" : "validation", training ? i : i - config.train);
    // train and validation number their streams apart, so that adding one leaves the others alone
    const int number = training ? i : (1 << 16) + i - config.train;
    series[static_cast<std::size_t>(i)] = design(problem, seed, number, report);
    progress.advance(1);
  });
  for (const TrajectoryReport& report : excitation.reports)
    if (!report.feasible)
      throw UserError("excitation: {}: {}", report.name, broken_limit(report, config, robot));
  const auto middle = series.begin() + config.train;
  excitation.train.assign(series.begin(), middle);
  excitation.validation.assign(middle, series.end());
  return excitation;
}

TrajectoryReport examine(const Fourier& series, const ExcitationOptions& config,
                         const MujocoArm& arm, const dynamics::RobotModel& robot, int samples) {
  const Problem problem(config, arm, robot);
  Judge judge(problem);
  return examine_on(problem, judge, series,
                    TimeGrid::over_period(series.w, series.harmonics(), samples));
}

}  // namespace fricid::sim
