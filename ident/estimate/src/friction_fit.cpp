#include "fricid/estimate/friction_fit.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/rng.hpp"
#include "friction_search.hpp"

namespace fricid::estimate {
namespace {

constexpr double kSpread = 1.2;  // sd of the random starts in log coordinates: a factor of about 3
constexpr double kOnBound = 1e-3;  // distance in scaled coordinates that counts as on the bound

}  // namespace

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
    if (data.rows() > 0) fit.offset = data.offset(friction, fit.theta);
    return fit;
  }
  const SearchCoordinates coordinates(friction, start, options.held);
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
    if (!coordinates.is_held(i) && (best.x[i] - coordinates.lower()[i] < kOnBound ||
                                    coordinates.upper()[i] - best.x[i] < kOnBound))
      fit.at_bound.push_back(parameter.symbol);
  }
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
