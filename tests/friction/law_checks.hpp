// What the law suite demands of one subject (see subjects.hpp). A new law is put through all of it
// by check_all(LawSubject<NewLaw>(NewLaw{})).
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "subjects.hpp"

namespace fricid::friction::test {

template <class S>
using ScalarOf = decltype(lane(S(), 0));

/// Numbers of one trial, one per lane: parameters, input, state.
template <class S>
struct Trial {
  std::vector<S> theta, z;
  Input<S> in;
  std::vector<std::vector<double>> bound;  // per lane
};

template <class S, class Subject>
Trial<S> draw_trial(const Subject& subject, Draw& draw, double fastest) {
  using T = ScalarOf<S>;
  Trial<S> trial;
  const auto parameters = subject.parameters();
  trial.theta.resize(parameters.size());
  trial.z.resize(static_cast<std::size_t>(subject.state_size()));
  for (int i = 0; i < kLaneCount<S>; ++i) {
    // rounded to the lane's precision first, so that every precision gets the same numbers
    std::vector<double> theta = draw.theta(parameters);
    for (double& x : theta) x = static_cast<double>(static_cast<T>(x));
    trial.bound.push_back(subject.bound(theta.data()));
    const std::vector<double> z = draw.state(trial.bound.back());
    const Input<double> in = draw.input(fastest);
    for (std::size_t k = 0; k < theta.size(); ++k)
      set_lane(trial.theta[k], i, static_cast<T>(theta[k]));
    for (std::size_t k = 0; k < z.size(); ++k) set_lane(trial.z[k], i, static_cast<T>(z[k]));
    set_lane(trial.in.q, i, static_cast<T>(in.q));
    set_lane(trial.in.v, i, static_cast<T>(in.v));
    set_lane(trial.in.load, i, static_cast<T>(in.load));
    set_lane(trial.in.temperature, i, static_cast<T>(in.temperature));
  }
  return trial;
}

template <class S>
Trial<double> lane_of(const Trial<S>& trial, int i) {
  Trial<double> one;
  for (const S& x : trial.theta) one.theta.push_back(lane(x, i));
  for (const S& x : trial.z) one.z.push_back(lane(x, i));
  one.in = {lane(trial.in.q, i), lane(trial.in.v, i), lane(trial.in.load, i),
            lane(trial.in.temperature, i)};
  one.bound = {trial.bound[static_cast<std::size_t>(i)]};
  return one;
}

/// tau_f(-v, -z) = -tau_f(v, z) and z'(-v, -z) = -z'(v, z), to the last bit, where claimed.
template <class Subject>
void check_odd(const Subject& subject, int trials = 300) {
  if (!subject.claims.odd) return;
  Draw draw(1);
  for (int n = 0; n < trials; ++n) {
    Trial<double> x = draw_trial<double>(subject, draw, 1e3);
    x.in.q = x.in.load = 0;
    x.in.temperature = 293.15;
    Trial<double> y = x;
    y.in.v = -x.in.v;
    for (double& z : y.z) z = -z;
    EXPECT_EQ(subject.torque(y.theta.data(), y.in, y.z.data()),
              -subject.torque(x.theta.data(), x.in, x.z.data()));
    const double dt = draw.log_uniform(1e-5, 1e-1);
    subject.step(x.theta.data(), x.in, dt, x.z.data());
    subject.step(y.theta.data(), y.in, dt, y.z.data());
    for (std::size_t k = 0; k < x.z.size(); ++k) EXPECT_EQ(y.z[k], -x.z[k]);
  }
}

/// |z'| stays in its bound, and two states do not move apart (|dz'/dz| <= 1), for `inputs` inputs.
template <class Subject>
void check_bound_and_contraction(const Subject& subject, int inputs = 20000) {
  if (subject.state_size() == 0) return;
  constexpr int kInputsPerTrial = 64;
  Draw draw(2);
  for (int n = 0; n < inputs; n += kLaneCount<PackD> * kInputsPerTrial) {
    Trial<PackD> x = draw_trial<PackD>(subject, draw, 1e3);
    Trial<PackD> y = x;
    for (int k = 0; k < kInputsPerTrial; ++k) {
      for (int i = 0; i < kLaneCount<PackD>; ++i) {
        const auto& bound = x.bound[static_cast<std::size_t>(i)];
        const auto zx = draw.state(bound), zy = draw.state(bound);
        for (std::size_t s = 0; s < zx.size(); ++s) {
          x.z[s].set(i, zx[s]);
          y.z[s].set(i, zy[s]);
        }
        x.in.v.set(i, draw.speed());
      }
      y.in = x.in;
      const double dt = draw.log_uniform(1e-6, 10);
      const std::vector<PackD> zx = x.z, zy = y.z;
      subject.step(x.theta.data(), x.in, dt, x.z.data());
      subject.step(y.theta.data(), y.in, dt, y.z.data());
      for (int i = 0; i < kLaneCount<PackD>; ++i)
        for (std::size_t s = 0; s < zx.size(); ++s) {
          const double bound = x.bound[static_cast<std::size_t>(i)][s];
          ASSERT_LE(std::abs(x.z[s][i]), bound * (1 + 1e-12)) << "v = " << x.in.v[i];
          if (!subject.claims.contracts) continue;
          ASSERT_LE(std::abs(x.z[s][i] - y.z[s][i]), std::abs(zx[s][i] - zy[s][i]) + 1e-12 * bound)
              << "v = " << x.in.v[i] << " dt = " << dt;
        }
    }
  }
}

/// No energy comes out: the work that the joint puts in, from rest and over closed velocity cycles,
/// is never negative. Load and temperature are held.
template <class Subject>
void check_dissipates(const Subject& subject, int trials = 20) {
  if (!subject.claims.dissipative) return;
  constexpr double kTravel = 2e-6;  // per step; short against every bristle drawn [rad]
  constexpr int kSegments = 8, kCycles = 3;
  Draw draw(3);
  for (int n = 0; n < trials; ++n) {
    Trial<double> x = draw_trial<double>(subject, draw, 1.0);
    std::fill(x.z.begin(), x.z.end(), 0.0);
    std::vector<std::pair<double, int>> cycle;  // velocity, steps
    int position = 0;
    for (int k = 0; k < kSegments; ++k) {
      const int steps = static_cast<int>(draw.log_uniform(10, 2000));
      const double v = draw.sign() * draw.log_uniform(1e-4, 1.0);
      cycle.emplace_back(v, steps);
      position += v < 0 ? -steps : steps;
    }
    cycle.emplace_back(position < 0 ? 0.02 : -0.02, std::abs(position));

    double work = 0, turnover = 0;
    for (int c = 0; c < kCycles; ++c) {
      const double work_before = work;
      for (const auto& [v, steps] : cycle) {
        x.in.v = v;
        const double dt = kTravel / std::abs(v);
        for (int k = 0; k < steps; ++k) {
          const double before = subject.torque(x.theta.data(), x.in, x.z.data());
          subject.step(x.theta.data(), x.in, dt, x.z.data());
          x.in.q += v * dt;
          const double after = subject.torque(x.theta.data(), x.in, x.z.data());
          work += 0.5 * (before + after) * v * dt;
          turnover += 0.5 * std::abs(before + after) * kTravel;
          ASSERT_GE(work, -1e-4 * turnover) << "from rest";
        }
      }
      if (c == 0) continue;  // z has not closed yet
      EXPECT_GE(work - work_before, -1e-4 * turnover) << "over a closed cycle";
    }
  }
}

/// Two half steps at the same v equal one, where claimed.
template <class Subject>
void check_semigroup(const Subject& subject, int trials = 300) {
  if (!subject.claims.semigroup) return;
  Draw draw(4);
  for (int n = 0; n < trials; ++n) {
    Trial<double> x = draw_trial<double>(subject, draw, 10);
    std::vector<double> twice = x.z;
    const double dt = draw.log_uniform(1e-6, 1e-1);
    subject.step(x.theta.data(), x.in, dt, x.z.data());
    subject.step(x.theta.data(), x.in, dt / 2, twice.data());
    subject.step(x.theta.data(), x.in, dt / 2, twice.data());
    for (std::size_t k = 0; k < x.z.size(); ++k)
      EXPECT_NEAR(x.z[k], twice[k], 1e-12 * x.bound[0][k]) << "v = " << x.in.v << " dt = " << dt;
  }
}

/// Torque after a long time at constant v, where claimed.
template <class Subject>
void check_steady_state(const Subject& subject, int trials = 200) {
  if (!subject.claims.settles) return;
  Draw draw(5);
  for (int n = 0; n < trials; ++n) {
    Trial<double> x = draw_trial<double>(subject, draw, 10);
    for (int k = 0; k < 4; ++k) subject.step(x.theta.data(), x.in, 1e7, x.z.data());
    const double tau = subject.torque(x.theta.data(), x.in, x.z.data());
    const double expected = subject.steady_torque(x.theta.data(), x.in);
    EXPECT_NEAR(tau, expected, 1e-10 * (1 + std::abs(expected))) << "v = " << x.in.v;
  }
}

/// dt = 0 and v = 0 keep the state to the last bit, and the torque at rest stays.
template <class Subject>
void check_stuck(const Subject& subject, int trials = 100) {
  Draw draw(6);
  for (int n = 0; n < trials; ++n) {
    Trial<double> x = draw_trial<double>(subject, draw, 1e3);
    std::vector<double> z = x.z;
    subject.step(x.theta.data(), x.in, 0.0, z.data());
    EXPECT_EQ(z, x.z) << "dt = 0";
    x.in.v = 0;
    const double tau = subject.torque(x.theta.data(), x.in, z.data());
    for (int k = 0; k < 100; ++k) subject.step(x.theta.data(), x.in, 0.01, z.data());
    EXPECT_EQ(z, x.z) << "v = 0";
    EXPECT_EQ(subject.torque(x.theta.data(), x.in, z.data()), tau);
  }
}

template <class S, class Subject>
void expect_finite_pullback(const Subject& subject, const Trial<S>& x, double dt) {
  std::vector<S> theta_bar(x.theta.size(), S(0)), z_bar(x.z.size(), S(0));
  const std::vector<S> z_next_bar(x.z.size(), S(1));
  Input<S> in_bar{S(0), S(0), S(0), S(0)};
  subject.torque_pullback(x.theta.data(), x.in, x.z.data(), S(1), theta_bar.data(), in_bar,
                          z_bar.data());
  subject.step_pullback(x.theta.data(), x.in, dt, x.z.data(), z_next_bar.data(), theta_bar.data(),
                        in_bar, z_bar.data());
  S sum = in_bar.q + in_bar.v + in_bar.load + in_bar.temperature;
  for (const S& bar : theta_bar) sum += bar;
  for (const S& bar : z_bar) sum += bar;
  for (int i = 0; i < kLaneCount<S>; ++i)
    ASSERT_TRUE(std::isfinite(lane(sum, i))) << "v = " << lane(x.in.v, i) << " dt = " << dt;
}

/// No NaN and no state beyond its bound at speeds from 0 to 1e3, steps from 0 to 1e6 s and
/// parameters at the corners of their bounds, with all of them side by side in the lanes.
template <class S, class Subject>
void check_extremes(const Subject& subject, int trials = 200) {
  using T = ScalarOf<S>;
  const T speeds[] = {0, T(1e-37), T(-1e-12), T(1e-3), T(-0.1), 1, -1000, 1000};
  const double steps[] = {0, 1e-9, 4e-3, 1, 1e6};
  const double slack = 4 * static_cast<double>(std::numeric_limits<T>::epsilon());
  const auto parameters = subject.parameters();
  Draw draw(7);
  for (int n = 0; n < trials; ++n) {
    Trial<S> x = draw_trial<S>(subject, draw, 1e3);
    if (n % 2 == 0) {
      std::vector<double> theta(parameters.size());
      for (std::size_t k = 0; k < theta.size(); ++k) {
        const double corner = draw.sign() < 0 ? parameters[k].lower : parameters[k].upper;
        theta[k] = static_cast<double>(static_cast<T>(corner));
        x.theta[k] = S(theta[k]);
      }
      for (auto& bound : x.bound) bound = subject.bound(theta.data());
    }
    for (int i = 0; i < kLaneCount<S>; ++i) {
      set_lane(x.in.v, i, speeds[(n + i) % 8]);
      for (std::size_t k = 0; k < x.z.size(); ++k)
        set_lane(x.z[k], i,
                 static_cast<T>(x.bound[static_cast<std::size_t>(i)][k] * ((n + i) % 3 - 1)));
    }
    for (const double dt : steps) {
      subject.step(x.theta.data(), x.in, dt, x.z.data());
      const S tau = subject.torque(x.theta.data(), x.in, x.z.data());
      for (int i = 0; i < kLaneCount<S>; ++i) {
        ASSERT_TRUE(std::isfinite(lane(tau, i))) << "v = " << lane(x.in.v, i) << " dt = " << dt;
        for (std::size_t k = 0; k < x.z.size(); ++k)
          ASSERT_LE(std::abs(static_cast<double>(lane(x.z[k], i))),
                    x.bound[static_cast<std::size_t>(i)][k] * (1 + slack))
              << "v = " << lane(x.in.v, i) << " dt = " << dt;
      }
      if (sizeof(T) == sizeof(double)) expect_finite_pullback(subject, x, dt);
    }
  }
}

/// Lane k of a pack equals the scalar, bit for bit, in all operations.
template <class Subject>
void check_lanes(const Subject& subject, int trials = 30) {
  const std::size_t n_theta = subject.parameters().size();
  const auto n_z = static_cast<std::size_t>(subject.state_size());
  const auto same = [](double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; };
  Draw draw(8);
  for (int n = 0; n < trials; ++n) {
    const Trial<PackD> x = draw_trial<PackD>(subject, draw, 10);
    const double dt = draw.log_uniform(1e-5, 1e-1);
    const PackD tau = subject.torque(x.theta.data(), x.in, x.z.data());
    const PackD steady = subject.steady_torque(x.theta.data(), x.in);
    std::vector<PackD> z = x.z, theta_bar(n_theta, PackD(0)), z_bar(n_z, PackD(0));
    subject.step(x.theta.data(), x.in, dt, z.data());
    Input<PackD> in_bar{0, 0, 0, 0};
    subject.torque_pullback(x.theta.data(), x.in, x.z.data(), tau, theta_bar.data(), in_bar,
                            z_bar.data());
    subject.step_pullback(x.theta.data(), x.in, dt, x.z.data(), z.data(), theta_bar.data(), in_bar,
                          z_bar.data());

    for (int i = 0; i < kLaneCount<PackD>; ++i) {
      const Trial<double> one = lane_of(x, i);
      const double tau1 = subject.torque(one.theta.data(), one.in, one.z.data());
      EXPECT_PRED2(same, tau[i], tau1);
      EXPECT_PRED2(same, steady[i], subject.steady_torque(one.theta.data(), one.in));
      std::vector<double> z1 = one.z, theta_bar1(n_theta), z_bar1(n_z);
      subject.step(one.theta.data(), one.in, dt, z1.data());
      Input<double> in_bar1{};
      subject.torque_pullback(one.theta.data(), one.in, one.z.data(), tau1, theta_bar1.data(),
                              in_bar1, z_bar1.data());
      subject.step_pullback(one.theta.data(), one.in, dt, one.z.data(), z1.data(),
                            theta_bar1.data(), in_bar1, z_bar1.data());
      for (std::size_t k = 0; k < n_z; ++k) EXPECT_PRED2(same, z[k][i], z1[k]);
      for (std::size_t k = 0; k < n_z; ++k) EXPECT_PRED2(same, z_bar[k][i], z_bar1[k]);
      for (std::size_t k = 0; k < n_theta; ++k) EXPECT_PRED2(same, theta_bar[k][i], theta_bar1[k]);
      EXPECT_PRED2(same, in_bar.q[i], in_bar1.q);
      EXPECT_PRED2(same, in_bar.v[i], in_bar1.v);
      EXPECT_PRED2(same, in_bar.load[i], in_bar1.load);
      EXPECT_PRED2(same, in_bar.temperature[i], in_bar1.temperature);
    }
  }
}

/// Single precision stays within 5e-4 of double, relative to the torque and to the bound of the
/// state.
template <class Subject>
void check_single_precision(const Subject& subject, int trials = 30) {
  Draw draw(9);
  for (int n = 0; n < trials; ++n) {
    Trial<PackF> x = draw_trial<PackF>(subject, draw, 10);
    const double dt = draw.log_uniform(1e-5, 1e-1);
    const PackF tau = subject.torque(x.theta.data(), x.in, x.z.data());
    const Trial<PackF> before = x;
    subject.step(x.theta.data(), x.in, dt, x.z.data());
    for (int i = 0; i < kLaneCount<PackF>; ++i) {
      Trial<double> one = lane_of(before, i);
      const double tau1 = subject.torque(one.theta.data(), one.in, one.z.data());
      EXPECT_NEAR(tau[i], tau1, 5e-4 * (1 + std::abs(tau1))) << "v = " << one.in.v;
      subject.step(one.theta.data(), one.in, dt, one.z.data());
      for (std::size_t k = 0; k < one.z.size(); ++k)
        EXPECT_NEAR(x.z[k][i], one.z[k], 5e-4 * one.bound[0][k]) << "v = " << one.in.v;
    }
  }
}

}  // namespace fricid::friction::test
