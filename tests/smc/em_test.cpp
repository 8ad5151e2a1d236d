// Scores and EM steps from smoothed states against the Kalman likelihood.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "fricid/smc/backward_sampling.hpp"
#include "fricid/smc/noise_moments.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "linear_gaussian.hpp"
#include "moments.hpp"

namespace fricid::smc {
namespace {

double log_likelihood(LinearModel& model, const RowMatrix& y) {
  GaussianPath path;
  gaussian_filter(model, y, path);
  return path.log_likelihood;
}

/// First and second central difference of the likelihood along a change of the model.
struct Differences {
  double first, second;
};
Differences differences(const LinearModel& model, const RowMatrix& y, double h,
                        const std::function<void(LinearModel&, double)>& change) {
  const auto at = [&](double step) {
    LinearModel changed = model;
    change(changed, step);
    return log_likelihood(changed, y);
  };
  const double up = at(h), down = at(-h);
  return {(up - down) / (2 * h), (up - 2 * at(0) + down) / (h * h)};
}

/// Linear surrogate of a joint with a bristle: q, v, z; z' = z + dt (v - a z), torque k z.
LinearModel surrogate() {
  const double dt = 4e-3, a = 30, k = 200, inertia = 0.1;
  LinearModel model;
  model.A = Eigen::MatrixXd{{1, dt, 0}, {0, 1 - dt, -dt * k / inertia}, {0, dt, 1 - dt * a}};
  model.b = Eigen::Vector3d::Zero();
  model.start = {Eigen::Vector3d::Zero(), Eigen::Vector3d(1e-8, 1e-2, 1e-8).asDiagonal()};
  model.noise = Eigen::Vector3d(1e-10, 1e-4, 1e-10).asDiagonal();
  model.observe = Eigen::MatrixXd{{1, 0, 0}};
  model.error = Eigen::MatrixXd{{1e-8}};
  return model;
}

// Fisher's identity, grad log p(y) = E[grad log p(x, y) | y].
TEST(Score, OfSampledPathsIsThatOfTheLikelihood) {
  constexpr int T = 40, N = 1000, M = 40, B = 100;
  LinearModel model = test::tracking_model();
  const RowMatrix y = test::simulate(model, T, 8).y;
  const double R = model.error(0, 0);
  const double expected[] = {
      differences(model, y, 1e-5, [](LinearModel& m, double h) { m.error(0, 0) += h; }).first,
      differences(model, y, 1e-5, [](LinearModel& m, double h) { m.A(1, 0) += h; }).first,
      differences(model, y, 1e-5, [](LinearModel& m, double h) { m.noise *= 1 + h; }).first};

  test::Mean score[3];
  AdaptedGuide<PackD> guide(model, y);
  auto history = History<PackD>::full(2, N, T);
  BackwardWorkspace<PackD> ws(model.Q(), N, M);
  std::vector<RowMatrix> paths(M);
  Report report;
  FilterOptions options;
  BackwardOptions backward;
  options.particles = N;
  const Eigen::Matrix2d W = model.noise.inverse();
  for (std::uint32_t b = 0; b < B; ++b) {
    options.sequence = backward.sequence = b;
    ParticleFilter filter(model, guide, options);
    filter.run(report, &history);
    sample_paths(filter, history, backward, ws, paths, report);
    double sum[3] = {};
    for (const RowMatrix& x : paths) {
      for (int t = 0; t < T; ++t) {
        const double e = y(t, 0) - x(t, 0);
        sum[0] += 0.5 * (e * e / R - 1) / R;
        if (t + 1 == T) break;
        const Eigen::Vector2d w =
            x.row(t + 1).transpose() - model.A * x.row(t).transpose() - model.b;
        sum[1] += (W * w)(1) * x(t, 0);
        sum[2] += 0.5 * (w.dot(W * w) - 2);
      }
    }
    for (int k = 0; k < 3; ++k) score[k].add(sum[k] / M);
  }
  for (int k = 0; k < 3; ++k) EXPECT_LT(std::abs(score[k].z(expected[k])), 4.5) << k;
}

/// One EM step on Q and R; only what `update` takes over changes.
double em_step(LinearModel& model, const RowMatrix& y,
               const std::function<void(LinearModel&, const NoiseMoments&)>& update) {
  GaussianPath path;
  gaussian_smoother(model, y, path);
  NoiseMoments moments(model.state_size(), model.observation_size());
  moments.add(path, y, model.C());
  update(model, moments);
  return path.log_likelihood;
}

// Monotone, its fixed point is the optimum, and the truth lies within 3 posterior sd.
TEST(GaussianEm, RisesToTheOptimumNearTheTruth) {
  LinearModel model = test::tracking_model();
  model.observe = Eigen::MatrixXd::Identity(2, 2);
  model.error = Eigen::Vector2d(0.02, 0.04).asDiagonal();
  const LinearModel truth = model;
  RowMatrix y = test::simulate(model, 300, 2).y;
  y.row(7).setConstant(std::numeric_limits<double>::quiet_NaN());
  model.noise = Eigen::MatrixXd{{0.1, 0}, {0, 0.01}};
  model.error *= 3;
  double last = -1e300;
  for (int i = 0; i < 1500; ++i) {
    const double ell = em_step(model, y, [](LinearModel& m, const NoiseMoments& moments) {
      m.noise = moments.Q();
      m.error = moments.R();
    });
    ASSERT_GT(ell, last - 1e-9 * std::abs(ell)) << "iteration " << i;
    last = ell;
  }
  LinearModel at_truth = truth;
  EXPECT_GT(last, log_likelihood(at_truth, y));
  const auto check = [&](double found, double expected,
                         const std::function<void(LinearModel&, double)>& change) {
    const Differences d = differences(model, y, 1e-3 * found, change);
    const double sd = 1 / std::sqrt(-d.second);
    // in units of the posterior sd: the optimum, and the truth near it
    EXPECT_LT(std::abs(d.first) * sd, 1e-4);
    EXPECT_LT(std::abs(found - expected) / sd, 3);
  };
  check(model.error(0, 0), truth.error(0, 0), [](LinearModel& m, double h) { m.error(0, 0) += h; });
  check(model.noise(1, 1), truth.noise(1, 1), [](LinearModel& m, double h) { m.noise(1, 1) += h; });
}

// A7 for the bristle's rate a and stiffness k of the linear joint, together with Q and R: each row
// of A is a regression on the smoothed moments, sum E[x' z] / sum E[z^2] for its last column.
TEST(GaussianEm, FindsRateAndStiffnessOfTheBristle) {
  constexpr int T = 2000;
  LinearModel model = surrogate();
  model.noise = Eigen::Vector3d(1e-10, 1e-3, 1e-5).asDiagonal();
  const LinearModel truth = model;
  const RowMatrix y = test::simulate(model, T, 5).y;
  model.A(1, 2) *= 0.7;            // k
  model.A(2, 2) = 1 - 1.3 * 0.12;  // a
  model.noise(1, 1) *= 2;
  model.error *= 1.5;
  double last = -1e300;
  for (int i = 0; i < 400; ++i) {
    GaussianPath path;
    gaussian_smoother(model, y, path);
    ASSERT_GT(path.log_likelihood, last - 1e-9 * std::abs(path.log_likelihood)) << i;
    last = path.log_likelihood;
    NoiseMoments moments(3, 1);
    moments.add(path, y, model.C());
    model.noise(1, 1) = moments.Q()(1, 1);
    model.error = moments.R();
    double product[2] = {}, square = 0;
    for (std::size_t t = 0; t + 1 < path.smoothed.size(); ++t) {
      const Gaussian &x = path.smoothed[t], &next = path.smoothed[t + 1];
      const Eigen::Matrix3d P = x.covariance + x.mean * x.mean.transpose();
      const Eigen::Matrix3d N = path.lag_one[t] + next.mean * x.mean.transpose();
      square += P(2, 2);
      for (const int row : {1, 2})
        product[row - 1] += N(row, 2) - model.A(row, 0) * P(0, 2) - model.A(row, 1) * P(1, 2);
    }
    model.A(1, 2) = product[0] / square;
    model.A(2, 2) = product[1] / square;
  }
  for (const int row : {1, 2}) {
    const auto change = [row](LinearModel& m, double h) { m.A(row, 2) += h; };
    const Differences d = differences(model, y, 1e-3 * std::abs(truth.A(row, 2)), change);
    const double sd = 1 / std::sqrt(-d.second);
    EXPECT_LT(std::abs(d.first) * sd, 0.05) << "not at the optimum of row " << row;
    EXPECT_LT(std::abs(model.A(row, 2) - truth.A(row, 2)) / sd, 3) << "row " << row;
  }
  EXPECT_NEAR(model.noise(1, 1) / truth.noise(1, 1), 1, 0.3);
  EXPECT_NEAR(model.error(0, 0) / truth.error(0, 0), 1, 0.3);
}

// Near the fixed point the error shrinks by 1 - I_obs / I_complete per step (Dempster et al.).
TEST(GaussianEm, ErrorShrinksByTheShareOfMissingInformation) {
  constexpr int T = 400;
  LinearModel model = surrogate();
  const RowMatrix y = test::simulate(model, T, 2).y;
  struct Case {
    std::function<double&(LinearModel&)> parameter;
    std::function<double(const NoiseMoments&)> value;
    double count;
  };
  const Case cases[] = {{[](LinearModel& m) -> double& { return m.error(0, 0); },
                         [](const NoiseMoments& s) { return s.R()(0, 0); }, T},
                        {[](LinearModel& m) -> double& { return m.noise(1, 1); },
                         [](const NoiseMoments& s) { return s.Q()(1, 1); }, T - 1}};
  for (const Case& c : cases) {
    LinearModel m = model;
    const auto step = [&] {
      em_step(m, y, [&](LinearModel& changed, const NoiseMoments& moments) {
        c.parameter(changed) = c.value(moments);
      });
    };
    c.parameter(m) *= 1.2;
    std::vector<double> trace;
    for (int i = 0; i < 1500; ++i) {
      trace.push_back(c.parameter(m));
      step();
    }
    const double fixed = c.parameter(m);
    // the rate where the error is a few per cent
    std::size_t k = 0;
    while (std::abs(trace[k] / fixed - 1) > 0.01) ++k;
    const double rate = (trace[k + 1] - fixed) / (trace[k] - fixed);
    const Differences d =
        differences(m, y, 0.01 * fixed, [&](LinearModel& x, double h) { c.parameter(x) += h; });
    const double complete = c.count / (2 * fixed * fixed);
    EXPECT_NEAR(rate / (1 + d.second / complete), 1, 0.05);
  }
}

// Claim: the moments of many sampled paths are the expectations, missing channels included.
TEST(NoiseMoments, OfPathsAreThoseOfTheSmoother) {
  LinearModel model = test::random_model(6, 4);
  model.error = Eigen::MatrixXd(model.error.diagonal().asDiagonal());
  RowMatrix y = test::simulate(model, 30, 2).y;
  test::punch_holes(y);
  GaussianPath path;
  gaussian_smoother(model, y, path);
  NoiseMoments exact(6, 2);
  exact.add(path, y, model.C());
  test::Mean q[6], r[2];
  for (std::uint32_t b = 0; b < 100; ++b) {
    std::vector<RowMatrix> paths(10);
    sample_gaussian_paths(model.Q(), path, 1, b, paths);
    NoiseMoments sampled(6, 2);
    sampled.add(model, y, paths);
    for (int i = 0; i < 6; ++i) q[i].add(sampled.Q()(i, (i + 1) % 6));
    for (int i = 0; i < 2; ++i) r[i].add(sampled.R()(i, i));
  }
  for (int i = 0; i < 6; ++i) EXPECT_LT(std::abs(q[i].z(exact.Q()(i, (i + 1) % 6))), 4.5);
  for (int i = 0; i < 2; ++i) EXPECT_LT(std::abs(r[i].z(exact.R()(i, i))), 4.5);
}

}  // namespace
}  // namespace fricid::smc
