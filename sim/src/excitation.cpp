#include "fricid/sim/excitation.hpp"

#include <fmt/format.h>
#include <nlopt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "excitation_judge.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/sim/streams.hpp"

namespace fricid::sim {
namespace {

using Problem = ExcitationProblem;
using Judge = ExcitationJudge;

// Criterion evaluations of the optimiser; 400 gain less than 0.4 in log det.
constexpr int kEvaluations = 120;
// Most shrinking steps; if limits are still violated, the box centre itself is not feasible.
constexpr int kShrinks = 60;
constexpr double kShrink = 0.95;

double cost(Criterion criterion, const Eigen::MatrixXd& H) {
  return criterion == Criterion::kCondition ? std::log(condition(H)) : -log_det(H);
}

/// Per joint: share of the amplitude that its limits allow, place of the centre in the remaining
/// range, and mixing angle of two random series.
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

/// One search: minimises cost + penalty over the variables of all joints.
struct Search {
  const Problem& problem;
  Judge& judge;
  Draw draw;
  int evaluations = 0;

  double operator()(const double* x) {
    ++evaluations;
    const Motion motion = problem.design.sample(make_series(problem, problem.design, draw, x));
    // a violated limit costs more than any gain of the criterion
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
    // the coarse grid first, since it shows most violations
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
  std::vector<double> at_start = x;
  Fourier start_series;
  make_feasible(problem, judge, best_draw, at_start, start_series);
  report.log_det_start = log_det(judge.information(problem.design.sample(start_series)));

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
      return fmt::format(
          "torque of {} exceeds torque_share = {} of its effort limit {}; allowed: other "
          "excitation.half_range, centre or torque_share, or a higher limit in the URDF",
          robot.joints[j].name, config.torque_share, robot.joints[j].effort);
  for (const JointMargins& joint : report.joints) {
    const std::array<std::pair<const char*, double>, 4> margins{
        {{"position", joint.position_rad},
         {"velocity", joint.velocity},
         {"acceleration", joint.acceleration},
         {"jerk", joint.jerk}}};
    for (const auto& [name, left] : margins)
      if (left < 0)
        return fmt::format(
            "{} of {} exceeds its limit by {:.2g} in the best motion of {} random starts; raise "
            "restarts or shrink half_range",
            name, joint.joint, -left, config.restarts);
  }
  return fmt::format(
      "{}: {:.3f} m apart at their nearest in the best motion found; allowed: clearance_m = {} or "
      "more; lower it, or shrink half_range",
      report.closest.empty() ? "closest bodies" : report.closest, report.clearance_m,
      config.clearance_m);
}

}  // namespace

Eigen::MatrixXd per_period(const Eigen::MatrixXd& known, const ExcitationOptions& config) {
  return known * (config.base_rad_s / (2 * std::numbers::pi));
}

Excitation design_excitation(const ExcitationOptions& config, const MujocoArm& arm,
                             const dynamics::RobotModel& robot, std::uint64_t seed, int jobs,
                             const Eigen::MatrixXd& known) {
  Problem problem(config, arm, robot);
  if (known.size() > 0) problem.known = per_period(known, config);
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
    // separate streams for train and validation, so that adding a trajectory changes no other
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
