#include "fricid/estimate/friction_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <nlopt.h>
#include <Eigen/Cholesky>

#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"

namespace fricid::estimate {
namespace {

constexpr int kLanes = kLaneCount<PackD>;
constexpr double kSpread = 1.2;  // sd of the random starts in log coordinates: a factor of about 3
constexpr double kFirstStep = 0.4;    // of the simplex, in scaled coordinates
constexpr double kOnBound = 1e-3;     // distance in scaled coordinates that counts as on the bound
constexpr double kDifference = 1e-5;  // of the Jacobian, in scaled coordinates
constexpr double kLargestStep = 1.5;  // of one iteration in any scaled coordinate
constexpr double kSmallestGain =
    1e-7;                           // relative decrease of the objective that counts as converged
constexpr double kBadValue = 1e30;  // objective of a diverged prediction; finite for the optimiser

// Scaled search coordinates: log(theta) or theta / unit.
class Coordinates {
 public:
  Coordinates(const friction::RobotFriction& friction, std::span<const double> reference) {
    for (std::size_t i = 0; i < reference.size(); ++i) {
      const friction::ParameterInfo& info = friction.parameters()[i].info;
      log_.push_back(info.scale == friction::Scale::kLog);
      unit_.push_back(std::max(std::abs(reference[i]), 0.1 * std::abs(info.typical)));
      if (unit_.back() == 0) unit_.back() = info.upper - info.lower;
      lower_.push_back(to_scaled(i, info.lower));
      upper_.push_back(to_scaled(i, info.upper));
    }
  }

  double to_scaled(std::size_t i, double theta) const {
    return log_[i] ? std::log(std::max(theta, std::numeric_limits<double>::min()))
                   : theta / unit_[i];
  }
  double to_theta(std::size_t i, double x) const { return log_[i] ? std::exp(x) : x * unit_[i]; }

  std::vector<double> to_scaled(std::span<const double> theta) const {
    std::vector<double> x(theta.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] = std::clamp(to_scaled(i, theta[i]), lower_[i], upper_[i]);
    return x;
  }
  void to_theta(std::span<const double> x, std::span<double> theta) const {
    for (std::size_t i = 0; i < x.size(); ++i) theta[i] = to_theta(i, x[i]);
  }
  bool is_log(std::size_t i) const { return log_[i]; }
  const std::vector<double>& lower() const { return lower_; }
  const std::vector<double>& upper() const { return upper_; }

 private:
  std::vector<bool> log_;
  std::vector<double> unit_, lower_, upper_;
};

struct Search {
  const JointFrictionData& data;
  const friction::RobotFriction& friction;
  const Coordinates& coordinates;
  std::vector<double> theta;
  nlopt_opt optimiser;
  int evaluations = 0;
};

double safe_mean_square(const JointFrictionData& data, const friction::RobotFriction& friction,
                        std::span<const double> theta) {
  const double value = data.mean_square(friction, theta);
  return std::isfinite(value) ? value : kBadValue;
}

double objective(unsigned size, const double* x, double*, void* user) {
  Search& search = *static_cast<Search*>(user);
  ++search.evaluations;
  if (stop_requested()) nlopt_force_stop(search.optimiser);
  search.coordinates.to_theta({x, size}, search.theta);
  return safe_mean_square(search.data, search.friction, search.theta);
}

struct Minimum {
  std::vector<double> x;
  double value;
  bool converged;
  int evaluations;
};

Minimum nelder_mead(const JointFrictionData& data, const friction::RobotFriction& friction,
                    const Coordinates& coordinates, std::vector<double> x,
                    const FrictionFitOptions& options) {
  const auto size = static_cast<unsigned>(x.size());
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> optimiser(
      nlopt_create(NLOPT_LN_NELDERMEAD, size), &nlopt_destroy);
  Search search{data, friction, coordinates, std::vector<double>(x.size()), optimiser.get(), 0};
  nlopt_set_lower_bounds(optimiser.get(), coordinates.lower().data());
  nlopt_set_upper_bounds(optimiser.get(), coordinates.upper().data());
  nlopt_set_min_objective(optimiser.get(), &objective, &search);
  nlopt_set_initial_step1(optimiser.get(), kFirstStep);
  nlopt_set_xtol_abs1(optimiser.get(), options.tolerance);
  nlopt_set_ftol_rel(optimiser.get(), options.tolerance);
  nlopt_set_maxeval(optimiser.get(), options.evaluations);
  double value = kBadValue;
  const nlopt_result result = nlopt_optimize(optimiser.get(), x.data(), &value);
  throw_if_stopped();
  const bool converged = result == NLOPT_XTOL_REACHED || result == NLOPT_FTOL_REACHED ||
                         result == NLOPT_SUCCESS || result == NLOPT_ROUNDOFF_LIMITED;
  return {std::move(x), value, converged, search.evaluations};
}

// J'J and J'e of the residuals at x, columns by forward differences; the sum of squares goes to
// value.
struct NormalEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};
NormalEquations linearise(const JointFrictionData& data, const friction::RobotFriction& friction,
                          const Coordinates& coordinates, std::span<const double> x) {
  const auto p = static_cast<Eigen::Index>(x.size());
  // Lane 0 of every pass holds x itself, the others one shifted coordinate each.
  constexpr Eigen::Index kColumns = kLanes - 1;
  const Eigen::Index passes = (p + kColumns - 1) / kColumns;
  std::vector<double> step(x.size()), shifted(x.begin(), x.end()), theta(x.size());
  std::vector<std::vector<PackD>> lanes(static_cast<std::size_t>(passes),
                                        std::vector<PackD>(x.size()));
  for (Eigen::Index pass = 0; pass < passes; ++pass)
    for (int lane = 0; lane < kLanes; ++lane) {
      const auto i = static_cast<std::size_t>(pass * kColumns + lane - 1);
      const bool moves = lane > 0 && i < x.size();
      if (moves) {
        step[i] = x[i] + kDifference < coordinates.upper()[i] ? kDifference : -kDifference;
        shifted[i] += step[i];
      }
      coordinates.to_theta(shifted, theta);
      for (std::size_t k = 0; k < x.size(); ++k)
        lanes[static_cast<std::size_t>(pass)][k].set(lane, theta[k]);
      if (moves) shifted[i] = x[i];
    }

  NormalEquations out{Eigen::MatrixXd::Zero(p, p), Eigen::VectorXd::Zero(p)};
  std::vector<std::vector<PackD>> e(static_cast<std::size_t>(passes));
  std::vector<PackD> work;
  Eigen::VectorXd column(p);
  for (int s = 0; s < data.sequences(); ++s) {
    for (std::size_t pass = 0; pass < e.size(); ++pass)
      data.residual(friction, lanes[pass], s, e[pass], work);
    for (std::size_t k = 0; k < e[0].size(); ++k) {
      const double base = e[0][k][0];
      for (Eigen::Index i = 0; i < p; ++i) {
        const auto pass = static_cast<std::size_t>(i / kColumns);
        const int lane = static_cast<int>(i % kColumns) + 1;
        column[i] = (e[pass][k][lane] - base) / step[static_cast<std::size_t>(i)];
      }
      out.H.selfadjointView<Eigen::Lower>().rankUpdate(column);
      out.g += base * column;
    }
  }
  out.H.triangularView<Eigen::StrictlyUpper>() = out.H.transpose();
  out.H /= data.rows();
  out.g /= data.rows();
  return out;
}

// Levenberg-Marquardt inside the bounds: coordinates that press against a bound are held there.
void levenberg_marquardt(const JointFrictionData& data, const friction::RobotFriction& friction,
                         const Coordinates& coordinates, Minimum& at, int iterations) {
  const auto p = static_cast<Eigen::Index>(at.x.size());
  std::vector<double> theta(at.x.size()), trial(at.x.size());
  double damping = 1e-3;
  at.converged = false;
  for (int iteration = 0; iteration < iterations && at.value < kBadValue; ++iteration) {
    throw_if_stopped();
    const NormalEquations normal = linearise(data, friction, coordinates, at.x);
    const int passes = (static_cast<int>(p) + kLanes - 2) / (kLanes - 1);
    at.evaluations += passes * data.sequences();
    if (!normal.H.allFinite()) return;

    double lowered = 0;
    while (damping < 1e8) {
      Eigen::MatrixXd H = normal.H;
      Eigen::VectorXd g = normal.g;
      for (Eigen::Index i = 0; i < p; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const bool held = (at.x[k] <= coordinates.lower()[k] && g[i] > 0) ||
                          (at.x[k] >= coordinates.upper()[k] && g[i] < 0);
        if (held || H(i, i) <= 0) {
          H.row(i).setZero();
          H.col(i).setZero();
          H(i, i) = 1;
          g[i] = 0;
        } else {
          H(i, i) *= 1 + damping;
        }
      }
      const Eigen::VectorXd step = -H.ldlt().solve(g);
      for (std::size_t k = 0; k < trial.size(); ++k)
        trial[k] = std::clamp(
            at.x[k] + std::clamp(step[static_cast<Eigen::Index>(k)], -kLargestStep, kLargestStep),
            coordinates.lower()[k], coordinates.upper()[k]);
      coordinates.to_theta(trial, theta);
      const double value = safe_mean_square(data, friction, theta);
      ++at.evaluations;
      if (value < at.value) {
        lowered = (at.value - value) / at.value;
        at.value = value;
        at.x = trial;
        damping = std::max(damping / 10, 1e-12);
        break;
      }
      damping *= 10;
    }
    if (lowered < kSmallestGain) {
      at.converged = true;
      return;
    }
  }
}

}  // namespace

JointFrictionData::JointFrictionData(std::span<const Filtered> sequences,
                                     std::span<const data::RowMatrix> target, int joint,
                                     double cutoff_hz)
    : dt_(sequences.front().dt), low_pass_(cutoff_hz, 1 / sequences.front().dt) {
  double sum = 0;
  for (std::size_t first = 0; first < sequences.size(); first += kLanes) {
    const auto last = std::min(sequences.size(), first + kLanes);
    int longest = 0;
    for (std::size_t s = first; s < last; ++s) longest = std::max(longest, sequences[s].length());
    const auto T = static_cast<std::size_t>(longest);

    // Shorter sequences stand still at their last position; empty lanes repeat the first sequence.
    Group group;
    group.at.resize(T);
    group.over.resize(T);
    group.target.assign(T, PackD(0));
    group.weight.assign(T, PackD(0));
    for (int lane = 0; lane < kLanes; ++lane) {
      const bool present = first + static_cast<std::size_t>(lane) < last;
      const std::size_t index = present ? first + static_cast<std::size_t>(lane) : first;
      const Filtered& s = sequences[index];
      const int length = s.length();
      if (present) lengths_.push_back(length);
      for (int k = 0; k < longest; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const int row = std::min(k, length - 1);
        const bool moving = k + 1 < length;
        const double q = s.q_wide(row, joint), next = moving ? s.q_wide(row + 1, joint) : q;
        friction::Input<PackD>& at = group.at[i];
        friction::Input<PackD>& over = group.over[i];
        at.q.set(lane, q);
        at.v.set(lane, k < length ? s.v_wide(row, joint) : 0.0);
        at.load.set(lane, s.tau(row, joint));
        at.temperature.set(lane, s.temperature(row, joint));
        over.q.set(lane, next);
        over.v.set(lane, (next - q) / dt_);
        over.load.set(lane, s.tau(row, joint));
        over.temperature.set(lane, s.temperature(row, joint));
        if (!present || k >= length || !s.use(k, joint)) continue;
        const double value = target[index](row, joint);
        group.target[i].set(lane, value);
        group.weight[i].set(lane, 1);
        ++rows_;
        sum += value * value;
        largest_target_ = std::max(largest_target_, std::abs(value));
      }
    }
    groups_.push_back(std::move(group));
  }
  target_mean_square_ = rows_ > 0 ? sum / rows_ : 0;
}

void JointFrictionData::predict(const friction::RobotFriction& friction,
                                std::span<const double> theta,
                                std::vector<std::vector<PackD>>& out) const {
  std::vector<PackD> parameters(theta.begin(), theta.end());
  std::vector<PackD> z(static_cast<std::size_t>(friction.state_size())), work;
  out.resize(groups_.size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    out[g].resize(group.at.size());
    std::fill(z.begin(), z.end(), PackD(0));
    for (std::size_t k = 0; k < group.at.size(); ++k) {
      friction.torque<PackD>(parameters, {&group.at[k], 1}, z, {&out[g][k], 1});
      friction.step<PackD>(parameters, {&group.over[k], 1}, dt_, z);
    }
    low_pass_.apply(std::span<PackD>(out[g]), work);
  }
}

void JointFrictionData::residual(const friction::RobotFriction& friction,
                                 std::span<const PackD> theta, int sequence,
                                 std::vector<PackD>& out, std::vector<PackD>& work) const {
  const Group& group = groups_[static_cast<std::size_t>(sequence / kLanes)];
  const int from = sequence % kLanes;
  const auto spread = [from](const friction::Input<PackD>& in) {
    return friction::Input<PackD>{PackD(in.q[from]), PackD(in.v[from]), PackD(in.load[from]),
                                  PackD(in.temperature[from])};
  };
  std::vector<PackD> z(static_cast<std::size_t>(friction.state_size()), PackD(0));
  out.resize(static_cast<std::size_t>(lengths_[static_cast<std::size_t>(sequence)]));
  for (std::size_t k = 0; k < out.size(); ++k) {
    const friction::Input<PackD> at = spread(group.at[k]), over = spread(group.over[k]);
    friction.torque<PackD>(theta, {&at, 1}, z, {&out[k], 1});
    friction.step<PackD>(theta, {&over, 1}, dt_, z);
  }
  low_pass_.apply(std::span<PackD>(out), work);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = PackD(group.weight[k][from]) * (out[k] - PackD(group.target[k][from]));
}

double JointFrictionData::mean_square(const friction::RobotFriction& friction,
                                      std::span<const double> theta) const {
  std::vector<std::vector<PackD>> predicted;
  predict(friction, theta, predicted);
  PackD sum = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (std::size_t k = 0; k < predicted[g].size(); ++k) {
      const PackD e = groups_[g].weight[k] * (predicted[g][k] - groups_[g].target[k]);
      sum += e * e;
    }
  double total = 0;
  for (int lane = 0; lane < kLanes; ++lane) total += sum[lane];
  return std::isfinite(total) ? total / std::max(1, rows_)
                              : std::numeric_limits<double>::infinity();
}

Eigen::VectorXd JointFrictionData::predicted(const friction::RobotFriction& friction,
                                             std::span<const double> theta, int sequence) const {
  std::vector<std::vector<PackD>> all;
  predict(friction, theta, all);
  const auto group = static_cast<std::size_t>(sequence / kLanes);
  Eigen::VectorXd out(lengths_[static_cast<std::size_t>(sequence)]);
  for (Eigen::Index k = 0; k < out.size(); ++k)
    out[k] = all[group][static_cast<std::size_t>(k)][sequence % kLanes];
  return out;
}

std::vector<double> initial_theta(const friction::RobotFriction& friction,
                                  const FrictionGuess& guess) {
  // Size of this joint against the typical one of the table.
  double typical = 0;
  for (const auto& parameter : friction.parameters())
    if (parameter.symbol == "Fc" && typical == 0) typical = parameter.info.typical;
  const double size = typical > 0 ? guess.Fc / typical : 1;
  std::vector<double> theta;
  for (const auto& parameter : friction.parameters()) {
    const friction::ParameterInfo& info = parameter.info;
    const bool viscous = parameter.symbol == "Fv" || parameter.symbol == "sigma2";
    const bool torque = info.unit.starts_with("N m");
    const double value = viscous ? guess.Fv : torque ? info.typical * size : info.typical;
    theta.push_back(std::clamp(value, info.lower, info.upper));
  }
  return theta;
}

JointFrictionFit fit_joint_friction(const JointFrictionData& data,
                                    const friction::RobotFriction& friction,
                                    std::vector<double> start, const FrictionFitOptions& options) {
  JointFrictionFit fit;
  fit.theta = start;
  if (start.empty() || data.rows() == 0) {
    fit.message = start.empty() ? "no parameters to fit" : "no usable rows";
    fit.outcome = start.empty() ? Outcome::kConverged : Outcome::kFailed;
    fit.rms = std::sqrt(data.target_mean_square());
    return fit;
  }
  const Coordinates coordinates(friction, start);
  const std::vector<double> centre = coordinates.to_scaled(start);

  Rng rng(options.seed, options.stream);
  Minimum best{centre, kBadValue, false, 0};
  for (int s = 0; s < options.starts; ++s) {
    std::vector<double> x = centre;
    if (s > 0)
      for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] = coordinates.is_log(i) ? x[i] + kSpread * rng.normal()
                                     : x[i] * std::exp(kSpread * rng.normal());
        x[i] = std::clamp(x[i], coordinates.lower()[i], coordinates.upper()[i]);
      }
    Minimum found = nelder_mead(data, friction, coordinates, std::move(x), options);
    levenberg_marquardt(data, friction, coordinates, found, options.iterations);
    fit.evaluations += found.evaluations;
    fit.start_rms.push_back(std::sqrt(found.value));
    if (found.value < best.value) best = std::move(found);
  }

  coordinates.to_theta(best.x, fit.theta);
  for (std::size_t i = 0; i < fit.theta.size(); ++i) {
    const auto& parameter = friction.parameters()[i];
    fit.theta[i] = std::clamp(fit.theta[i], parameter.info.lower, parameter.info.upper);
    if (best.x[i] - coordinates.lower()[i] < kOnBound ||
        coordinates.upper()[i] - best.x[i] < kOnBound)
      fit.at_bound.push_back(parameter.symbol);
  }
  fit.rms = std::sqrt(best.value);
  fit.explained = data.target_mean_square() > 0 ? 1 - best.value / data.target_mean_square() : 0;
  if (best.value >= kBadValue) {
    fit.outcome = Outcome::kFailed;
    fit.message = "no start gave a finite prediction";
  } else {
    fit.outcome = best.converged ? Outcome::kConverged : Outcome::kIterationLimit;
    fit.message = fmt::format("rms {:.4g} N m of {:.4g} after {} evaluations", fit.rms,
                              std::sqrt(data.target_mean_square()), fit.evaluations);
  }
  return fit;
}

}  // namespace fricid::estimate
