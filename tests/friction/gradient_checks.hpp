// Pullbacks of one subject against dual numbers and against central differences, and the whole
// suite.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "dual.hpp"
#include "law_checks.hpp"

namespace fricid::friction::test {

using fricid::test::Dual;

/// All that a scalar objective may depend on, in one vector: theta, q, v, load, temperature, z.
template <class Subject, class S>
S objective(const Subject& subject, const std::vector<S>& x, double dt, double tau_bar,
            const std::vector<double>& z_next_bar) {
  const std::size_t n_theta = subject.parameters().size();
  const Input<S> in{x[n_theta], x[n_theta + 1], x[n_theta + 2], x[n_theta + 3]};
  std::vector<S> z(x.begin() + static_cast<std::ptrdiff_t>(n_theta) + 4, x.end());
  S value = S(tau_bar) * subject.torque(x.data(), in, static_cast<const S*>(z.data()));
  subject.step(x.data(), in, dt, z.data());
  for (std::size_t k = 0; k < z.size(); ++k) value += S(z_next_bar[k]) * z[k];
  return value;
}

/// The gradient of `objective` by the pullbacks.
template <class Subject>
std::vector<double> pullback_gradient(const Subject& subject, const std::vector<double>& x,
                                      double dt, double tau_bar,
                                      const std::vector<double>& z_next_bar) {
  const std::size_t n_theta = subject.parameters().size();
  const Input<double> in{x[n_theta], x[n_theta + 1], x[n_theta + 2], x[n_theta + 3]};
  const double* z = x.data() + n_theta + 4;
  std::vector<double> theta_bar(n_theta), z_bar(x.size() - n_theta - 4);
  Input<double> in_bar{};
  subject.torque_pullback(x.data(), in, z, tau_bar, theta_bar.data(), in_bar, z_bar.data());
  subject.step_pullback(x.data(), in, dt, z, z_next_bar.data(), theta_bar.data(), in_bar,
                        z_bar.data());
  std::vector<double> gradient = theta_bar;
  gradient.insert(gradient.end(), {in_bar.q, in_bar.v, in_bar.load, in_bar.temperature});
  gradient.insert(gradient.end(), z_bar.begin(), z_bar.end());
  return gradient;
}

/// A random objective: tau and each z' count about equally when measured by their own size.
struct Objective {
  std::vector<double> x;     // theta, q, v, load, temperature, z
  std::vector<double> size;  // typical size of each entry of x
  double dt, tau_bar;
  std::vector<double> z_next_bar;
};
template <class Subject>
Objective draw_objective(const Subject& subject, Draw& draw) {
  const Trial<double> trial = draw_trial<double>(subject, draw, 3);
  Objective o;
  o.x = trial.theta;
  o.x.insert(o.x.end(), {trial.in.q, trial.in.v, trial.in.load, trial.in.temperature});
  o.size = o.x;
  for (double& s : o.size) s = std::max(std::abs(s), 1e-6);
  o.dt = draw.log_uniform(1e-5, 1e-1);
  o.tau_bar = draw.uniform(-1, 1);
  for (std::size_t k = 0; k < trial.z.size(); ++k) {
    o.x.push_back(trial.z[k]);
    o.size.push_back(trial.bound[0][k]);
    o.z_next_bar.push_back(draw.uniform(-1, 1) / trial.bound[0][k]);
  }
  return o;
}

/// Pullback = dual numbers within 1e-10, relative to the entry or, where terms cancel, to the size
/// of the objective (about 1 to 100) over the size of the entry. About 4000 entries, at least 20
/// points: a network's direction costs as much as its number of weights.
template <class Subject>
void check_pullback_against_dual(const Subject& subject) {
  Draw draw(10);
  const std::size_t i_v = subject.parameters().size() + 1;
  const int trials = std::max(20, 4000 / static_cast<int>(i_v + 3));
  for (int n = 0; n < trials; ++n) {
    Objective o = draw_objective(subject, draw);
    if (n % 10 == 0) o.x[i_v] = 0;
    if (n % 10 == 1) o.dt = 0;
    const auto gradient = pullback_gradient(subject, o.x, o.dt, o.tau_bar, o.z_next_bar);
    for (std::size_t i = 0; i < o.x.size(); ++i) {
      std::vector<Dual> x(o.x.begin(), o.x.end());
      x[i].d = 1;
      const Dual y = objective(subject, x, o.dt, o.tau_bar, o.z_next_bar);
      EXPECT_NEAR(gradient[i], y.d, 1e-10 * (std::abs(y.d) + 1 / o.size[i]))
          << "entry " << i << " v = " << o.x[i_v] << " dt = " << o.dt;
    }
  }
}

/// Pullback = central difference within 1e-6. An entry whose difference quotient changes with its
/// width sits on a kink (stick to slip, contact) and is passed over; few may be.
template <class Subject>
void check_pullback_against_differences(const Subject& subject, int trials = 40) {
  Draw draw(11);
  int compared = 0, passed_over = 0;
  for (int n = 0; n < trials; ++n) {
    const Objective o = draw_objective(subject, draw);
    const auto gradient = pullback_gradient(subject, o.x, o.dt, o.tau_bar, o.z_next_bar);
    for (std::size_t i = 0; i < o.x.size(); ++i) {
      const auto quotient = [&](double h) {
        std::vector<double> up = o.x, down = o.x;
        up[i] += h;
        down[i] -= h;
        return (objective(subject, up, o.dt, o.tau_bar, o.z_next_bar) -
                objective(subject, down, o.dt, o.tau_bar, o.z_next_bar)) /
               (up[i] - down[i]);
      };
      const double h = 1e-5 * o.size[i];
      const double wide = quotient(h), narrow = quotient(h / 2);
      const double extrapolated = (4 * narrow - wide) / 3;
      const double tolerance = 1e-6 * (std::abs(gradient[i]) + 1 / o.size[i]);
      if (std::abs(wide - narrow) > 1e2 * tolerance) {
        ++passed_over;
        continue;
      }
      ++compared;
      EXPECT_NEAR(gradient[i], extrapolated, tolerance) << "entry " << i;
    }
  }
  EXPECT_LE(passed_over, compared / 20);
}

/// The whole suite for one subject.
template <class Subject>
void check_all(const Subject& subject) {
  check_odd(subject);
  check_bound_and_contraction(subject);
  check_dissipates(subject);
  check_semigroup(subject);
  check_steady_state(subject);
  check_stuck(subject);
  check_extremes<PackD>(subject);
  check_extremes<PackF>(subject);
  check_lanes(subject);
  check_single_precision(subject);
  check_pullback_against_dual(subject);
  check_pullback_against_differences(subject);
}

}  // namespace fricid::friction::test
