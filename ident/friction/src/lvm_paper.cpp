// Initial weights of the networks of lvm_paper, and which of them are trained.
#include "fricid/friction/robot_laws/lvm_paper.hpp"

#include <algorithm>
#include <cmath>

namespace fricid::friction {
namespace {

constexpr double kLonger = 3;      // way from rest to stop of every next latent of a joint
constexpr double kSharpness = 10;  // of the stops
constexpr double kWide = 30;       // half the range of u over which a single unit is straight
constexpr double kFinest = 0.03, kCoarse = 0.4,
                 kStep = 0.1;  // velocity scales of the units [rad/s]
constexpr double kLatentGain = 1.5, kSpeedGain = 0.7;
constexpr double kSpareOutput = 1e-4;
constexpr double kLeastRate = 0.05, kMostRate = 3;
constexpr double kMostWeight = 99;  // within the bounds of the table

/// Weights of a layer: W (rows x columns, row-major), then b (rows).
struct Layer {
  double* begin;
  int rows, columns;

  double& W(int row, int column) const { return begin[row * columns + column]; }
  double& b(int row) const { return begin[rows * columns + row]; }
  double* end() const { return begin + rows * (columns + 1); }
};

/// Input weights of a unit: speed [s/rad], one latent of its joint, bias.
struct Look {
  double v, z, bias;
  int latent;  // index among all latents; 0 if z = 0
};

/// Input weights of the `count` units of a joint with these latents.
std::vector<Look> looks(int count, const std::vector<int>& own, double v_sd) {
  std::vector<Look> units;
  const auto see_latents = [&](double sign) {
    for (const int i : own) units.push_back({0, sign * kLatentGain, kLatentGain, i});
  };
  const auto see_speed = [&] {
    for (const double sign : {1.0, -1.0}) units.push_back({sign / kCoarse, 0, 0, 0});
    units.push_back({kSpeedGain / v_sd, 0, kLatentGain, 0});
  };
  if (own.empty())
    for (const double bias : {1.0, -1.0}) units.push_back({1 / kFinest, 0, bias, 0});
  see_latents(1);
  if (own.size() < 2) see_latents(-1);
  see_speed();
  if (own.size() >= 2) see_latents(-1);
  for (int k = 1; std::ssize(units) < count; ++k)
    for (const double sign : {1.0, -1.0})
      units.push_back({sign / (kStep * k), own.empty() ? 0 : sign, 0, own.empty() ? 0 : own[0]});
  units.resize(static_cast<std::size_t>(count));
  return units;
}

}  // namespace

void LvmPaper::start_torque(double* theta, Rng& rng) const {
  const int n = scales_.joints(), width = net_.width(), inputs = scales_.inputs() + latents_;
  const Layer first{theta + net_begin(), width, inputs}, second{first.end(), width, width},
      output{second.end(), n, width};
  std::fill(first.begin, output.end(), 0.0);

  std::vector<double> size(static_cast<std::size_t>(width));
  for (int j = 0; j < n; ++j) {
    std::vector<int> own;
    for (int i = j; i < latents_; i += n) own.push_back(i);
    const double v_sd = theta[scales_.v_sd(j)];
    const int count = (width - j + n - 1) / n;
    const std::vector<Look> units = looks(std::max(0, count), own, v_sd);
    for (int k = 0; k < std::ssize(units); ++k) {
      const Look& look = units[static_cast<std::size_t>(k)];
      const int u = j + k * n;
      first.W(u, n + j) = std::clamp(look.v * v_sd, -kMostWeight, kMostWeight);
      if (look.z != 0) first.W(u, 2 * n + look.latent) = look.z;
      first.b(u) = look.bias;
      for (const double sign : {1.0, -1.0}) {
        const double value = mish(look.bias + sign * (look.v * v_sd + look.z));
        size[static_cast<std::size_t>(u)] =
            std::max({size[static_cast<std::size_t>(u)], std::abs(value), 0.5});
      }
    }
    for (int u = j; u < width; u += n) {
      second.b(u) = 0.5 + 0.5 * rng.normal();
      for (int below = j; below < width; below += n)
        second.W(u, below) = (rng.normal() / std::sqrt(count) + (u == below ? 1 : 0)) /
                             size[static_cast<std::size_t>(below)];
    }
  }
}

void LvmPaper::start_rate(double* theta, Rng& rng) const {
  const int n = scales_.joints(), width = eta_.width(), inputs = scales_.inputs() + latents_;
  const Layer hidden{theta + eta_begin(), width, inputs}, output{hidden.end(), latents_, width};
  std::fill(hidden.begin, output.end(), 0.0);
  const RateUnits units = rate_units();
  const UnitJoints joint_of_unit = eta_units();
  const auto shorter = [&](int i) {
    return std::pow(kLonger, -(i / n));
  };  // u_i per u of its joint

  int unit = 0;
  for (int j = 0; j < units.joints; ++j)
    for (int k = 0; k < units.per_joint; ++k, ++unit) {
      const bool single = units.per_joint == 1;
      const double gain = single ? 1 : k == 0 ? kSharpness : -kSharpness;
      hidden.W(unit, n + j) = gain;
      hidden.b(unit) = single ? kWide : 0;
      for (int i = j; i < units.stopped; i += n) {
        const double weight = shorter(i) / gain;
        output.W(i, unit) = weight;
        if (single) output.b(i) -= weight * kWide;
      }
    }
  for (int i = 0; i < units.stopped; ++i)
    for (const double side : {1.0, -1.0}) {
      hidden.W(unit, n + joint_of(i)) = side * kSharpness * shorter(i);
      hidden.W(unit, 2 * n + i) = side * kSharpness;
      hidden.b(unit) = -kSharpness;
      output.W(i, unit++) = -side / kSharpness;
    }
  for (; unit < width; ++unit) {
    const int j = joint_of_unit[static_cast<std::size_t>(unit)];
    hidden.W(unit, n + j) = rng.normal();
    hidden.b(unit) = rng.normal();
    for (int i = j; i < latents_; i += n) {
      hidden.W(unit, 2 * n + i) = rng.normal();
      output.W(i, unit) = kSpareOutput * rng.normal();
    }
  }
}

void LvmPaper::initialise(double* theta, Rng& rng) const {
  start_torque(theta, rng);
  start_rate(theta, rng);
}

void LvmPaper::training_rates(const double* theta, double* rate) const {
  const double between_joints = theta[cross()] > 0 ? kLeastRate : 0;
  const UnitJoints of_net = net_units(), of_eta = eta_units();
  const auto of = [](const UnitJoints& units, int u) { return units[static_cast<std::size_t>(u)]; };
  // theirs(row, column): whether a weight stays within a joint
  const auto set = [&](int begin, int rows, int columns, auto theirs) {
    const auto rate_of = [&](int at) {
      const double size = std::abs(theta[at]);
      return size == 0 ? 1 : std::clamp(size, kLeastRate, kMostRate);
    };
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const int at = begin + r * columns + c;
        rate[at] = theirs(r, c) ? rate_of(at) : between_joints;
      }
      rate[begin + rows * columns + r] = rate_of(begin + rows * columns + r);
    }
    return begin + rows * (columns + 1);
  };
  const int n = scales_.joints(), width = net_.width(), inputs = scales_.inputs() + latents_;
  int at = set(net_begin(), width, inputs,
               [&](int unit, int input) { return of(of_net, unit) == joint_seen(input); });
  at = set(at, width, width,
           [&](int unit, int below) { return of(of_net, unit) == of(of_net, below); });
  at = set(at, n, width, [&](int joint, int unit) { return joint == of(of_net, unit); });
  at = set(at, width, inputs,
           [&](int unit, int input) { return of(of_eta, unit) == joint_seen(input); });
  set(at, latents_, width,
      [&](int latent, int unit) { return joint_of(latent) == of(of_eta, unit); });
}

}  // namespace fricid::friction
