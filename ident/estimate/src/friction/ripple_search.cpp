#include "friction/ripple_search.hpp"

#include <algorithm>
#include <numbers>

namespace fricid::estimate {
namespace {

// Orders of a gear; slower waves, as of a gear that is eccentric, are looked for in what these
// leave: beside them load, which goes with the joint angle too, would look like one.
constexpr double kFewestRipples = 20, kFewestOfFurther = 1, kMostRipples = 1000;
constexpr double kRippleGrid = 0.25;    // of the orders, in periods over the travel
constexpr double kFinestOfGrid = 0.05;  // joints that turn on and on

}  // namespace

std::vector<std::size_t> ripple_terms(const friction::RobotFriction& friction) {
  std::vector<std::size_t> begin;
  for (std::size_t i = 0; i < friction.parameters().size(); ++i)
    if (friction.parameters()[i].info.role == friction::Role::kWaveNumber) begin.push_back(i);
  return begin;
}

void seed_ripples(const JointFrictionData& data, const friction::RobotFriction& friction,
                  std::span<const std::size_t> terms, bool slow, std::span<double> theta) {
  const double step = std::max(kRippleGrid * 2 * std::numbers::pi / data.travel(), kFinestOfGrid);
  const std::size_t first = ripple_terms(friction).front();
  for (const std::size_t i : terms) {
    theta[ripple_amplitude(i)] = 0;
    const double fewest = i == first && !slow ? kFewestRipples : kFewestOfFurther;
    const RippleTerm term = data.strongest_ripple(
        friction, theta, {fewest, step, static_cast<int>((kMostRipples - fewest) / step) + 1});
    const double values[kRippleSize] = {term.n, term.A, term.phi};
    for (std::size_t k = 0; k < kRippleSize; ++k) {
      const friction::ParameterInfo& info = friction.parameters()[i + k].info;
      theta[i + k] = std::clamp(values[k], info.lower, info.upper);
    }
  }
}

}  // namespace fricid::estimate
