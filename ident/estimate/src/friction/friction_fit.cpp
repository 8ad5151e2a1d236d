#include "fricid/estimate/friction/friction_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "fricid/base/rng.hpp"
#include "friction/friction_search.hpp"
#include "friction/ripple_search.hpp"

namespace fricid::estimate {
namespace {

constexpr double kSpread = 1.2;   // sd of the random starts in log coordinates: a factor of about 3
constexpr double kUnseen = 0.01;  // gain in mean square that a parameter needs to be its own
constexpr double kUsualStatic = 2;    // static friction over that of sliding
constexpr double kAboutAsMuch = 0.2;  // more of the mean square
constexpr double kOnBound = 1e-3;     // distance in scaled coordinates that counts as on the bound

bool on_bound(const SearchCoordinates& coordinates, std::span<const double> x, std::size_t i) {
  return x[i] - coordinates.lower()[i] < kOnBound || coordinates.upper()[i] - x[i] < kOnBound;
}

/// Static friction that the motion hardly shows may be anything: it is then that of sliding.
void level_unseen_static_friction(const JointFrictionData& data,
                                  const friction::RobotFriction& friction,
                                  const SearchCoordinates& coordinates, SearchMinimum& best) {
  const int Fc = friction::find_parameter(friction, 0, friction::Role::kCoulomb),
            Fs = friction::find_parameter(friction, 0, friction::Role::kStatic);
  if (Fc < 0 || Fs < 0 || coordinates.is_held(static_cast<std::size_t>(Fs))) return;
  std::vector<double> theta(best.x.size());
  coordinates.to_theta(best.x, theta);
  theta[static_cast<std::size_t>(Fs)] = theta[static_cast<std::size_t>(Fc)];
  const double value = data.mean_square(friction, theta);
  if (!(value < (1 + kUnseen) * best.value)) return;
  best.x = coordinates.to_scaled(theta);
  best.value = value;
}

/// Static friction above all torque that friction had to explain is a spike about v = 0 that stands
/// for something else, and no law to simulate with: then it is twice that of sliding, if that
/// explains about as much.
/// @return index of it in theta; -1: it is not
int bound_static_friction(const JointFrictionData& data, const friction::RobotFriction& friction,
                          const SearchCoordinates& coordinates, FrictionFitOptions options,
                          SearchMinimum& best) {
  const int Fc = friction::find_parameter(friction, 0, friction::Role::kCoulomb),
            Fs = friction::find_parameter(friction, 0, friction::Role::kStatic);
  if (Fc < 0 || Fs < 0 || coordinates.is_held(static_cast<std::size_t>(Fs))) return -1;
  std::vector<double> theta(best.x.size());
  coordinates.to_theta(best.x, theta);
  const auto at = [&](int i) -> double& { return theta[static_cast<std::size_t>(i)]; };
  if (at(Fs) < data.largest_target()) return -1;
  for (std::size_t i = 0; i < theta.size(); ++i)
    if (coordinates.is_held(i)) options.held.push_back(i);
  options.held.push_back(static_cast<std::size_t>(Fs));
  SearchMinimum found{{}, kBadValue, false, 0};
  for (int pass = 0; pass < 2; ++pass) {  // Fc moves as well
    at(Fs) = kUsualStatic * at(Fc);
    const SearchCoordinates bounded(friction, theta, options.held);
    found = search(data, friction, bounded, bounded.to_scaled(theta), options);
    bounded.to_theta(found.x, theta);
  }
  if (!(found.value < (1 + kAboutAsMuch) * best.value)) return -1;
  best.x = coordinates.to_scaled(theta);
  best.value = found.value;
  best.converged = found.converged;
  return Fs;
}

/// Growth with the load that the motion hardly shows may be anything, where a joint's torque is
/// mostly friction: then friction does not grow.
void leave_out_unseen_growth(const JointFrictionData& data, const friction::RobotFriction& friction,
                             const SearchCoordinates& coordinates, std::vector<double> start,
                             FrictionFitOptions options, SearchMinimum& best) {
  bool any = false;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const friction::Role role = friction.parameters()[i].info.role;
    if (coordinates.is_held(i)) {
      options.held.push_back(i);
    } else if (role == friction::Role::kLoadGrowth || role == friction::Role::kLoadCoefficient) {
      start[i] = 0;
      options.held.push_back(i);
      any = true;
    }
  }
  if (!any) return;
  const SearchCoordinates without(friction, start, options.held);
  const SearchMinimum found = search(data, friction, without, without.to_scaled(start), options);
  if (!(found.value < (1 + kUnseen) * best.value)) return;
  std::vector<double> theta(start.size());
  without.to_theta(found.x, theta);
  best.x = coordinates.to_scaled(theta);
  best.value = found.value;
  best.converged = found.converged;
}

// Standard errors and correlation of what was free at the end.
void set_uncertainty(const JointFrictionData& data, const friction::RobotFriction& friction,
                     const SearchCoordinates& coordinates, std::span<const double> x,
                     const FrictionFitOptions& options, JointFrictionFit& fit) {
  const auto p = static_cast<Eigen::Index>(x.size());
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  fit.standard_error.assign(x.size(), kNone);
  fit.motion_error.assign(x.size(), kNone);
  fit.correlation = Eigen::MatrixXd::Constant(p, p, kNone);
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!coordinates.is_held(i) && !on_bound(coordinates, x, i)) free.push_back(i);
  const Eigen::VectorXd of_motion =
      options.motion_error ? options.motion_error(fit.theta) : Eigen::VectorXd();
  const SearchErrors errors = search_errors(data, friction, coordinates, x, free, of_motion);
  const Eigen::MatrixXd& covariance = errors.covariance;
  for (Eigen::Index a = 0; a < covariance.rows(); ++a) {
    const std::size_t i = free[static_cast<std::size_t>(a)];
    const double slope = std::abs(coordinates.slope(i, fit.theta[i]));
    fit.standard_error[i] = slope * std::sqrt(covariance(a, a));
    if (of_motion.size() > 0) fit.motion_error[i] = slope * errors.of_motion[a];
    for (Eigen::Index b = 0; b < covariance.cols(); ++b)
      fit.correlation(static_cast<Eigen::Index>(i),
                      static_cast<Eigen::Index>(free[static_cast<std::size_t>(b)])) =
          covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
  }
}

}  // namespace

JointFrictionFit fit_joint_friction(const JointFrictionData& data,
                                    const friction::RobotFriction& friction,
                                    std::vector<double> start, const FrictionFitOptions& options) {
  JointFrictionFit fit;
  fit.theta = start;
  if (start.empty() || data.rows() == 0) {
    fit.message = start.empty() ? "no parameters to fit" : "no usable rows";
    fit.outcome = start.empty() ? Outcome::kConverged : Outcome::kFailed;
    fit.rms = std::sqrt(data.target_mean_square());
    if (data.rows() > 0) fit.offset = data.offset(friction, fit.theta);
    return fit;
  }
  // a ripple has its own search, see seed_ripples: first the law without it
  const std::vector<std::size_t> ripples = ripple_terms(friction);
  std::vector<std::size_t> held = options.held;
  for (const std::size_t i : ripples) {
    start[i + 1] = 0;
    for (std::size_t k = 0; k < 3; ++k) held.push_back(i + k);
  }
  SearchCoordinates coordinates(friction, start, held);
  const std::vector<double> centre = coordinates.to_scaled(start);

  Rng rng(options.seed, options.stream);
  SearchMinimum best{centre, kBadValue, false, 0};
  for (int s = 0; s < options.starts; ++s) {
    std::vector<double> x = centre;
    if (s > 0)
      for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] = coordinates.is_log(i) ? x[i] + kSpread * rng.normal()
                                     : x[i] * std::exp(kSpread * rng.normal());
        x[i] = std::clamp(x[i], coordinates.lower()[i], coordinates.upper()[i]);
      }
    SearchMinimum found = search(data, friction, coordinates, x, options);
    fit.evaluations += found.evaluations;
    fit.start_rms.push_back(std::sqrt(found.value));
    if (found.value < best.value) best = std::move(found);
  }
  if (!ripples.empty() && best.value < kBadValue) {
    coordinates.to_theta(best.x, fit.theta);
    seed_ripples(data, friction, ripples, false, fit.theta);
    coordinates = SearchCoordinates(friction, fit.theta, options.held);
    best.x = coordinates.to_scaled(fit.theta);
    best.value = std::min(kBadValue, data.mean_square(friction, fit.theta));
    best.evaluations = 0;
    refine(data, friction, coordinates, best, options.iterations);
    fit.evaluations += best.evaluations;
  }

  if (best.value < kBadValue) {
    // ripples start where their search found them
    if (!ripples.empty()) coordinates.to_theta(best.x, start);
    if (!options.grows) leave_out_unseen_growth(data, friction, coordinates, start, options, best);
    if (const int Fs = bound_static_friction(data, friction, coordinates, options, best); Fs >= 0)
      fit.guessed.push_back(friction.parameters()[static_cast<std::size_t>(Fs)].symbol);
    level_unseen_static_friction(data, friction, coordinates, best);
  }
  coordinates.to_theta(best.x, fit.theta);
  for (std::size_t i = 0; i < fit.theta.size(); ++i) {
    const auto& parameter = friction.parameters()[i];
    fit.theta[i] = std::clamp(fit.theta[i], parameter.info.lower, parameter.info.upper);
    if (!coordinates.is_held(i) && on_bound(coordinates, best.x, i))
      fit.at_bound.push_back(parameter.symbol);
  }
  set_uncertainty(data, friction, coordinates, best.x, options, fit);
  fit.offset = data.offset(friction, fit.theta);
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
