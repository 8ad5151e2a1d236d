// Laws of the whole robot: pullbacks, lanes, precision, what a recurrent memory does with time, and
// the same networks written out by hand.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "allocation_counter.hpp"
#include "dual.hpp"
#include "fricid/base/error.hpp"
#include "fricid/friction/detail/kernels.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/friction/robot_laws.hpp"

namespace fricid::friction::test {
namespace {

using fricid::test::Dual;

constexpr int kJoints = 3;

/// A law of the whole robot, beside Dahl friction in the first joint.
RobotFriction robot(const std::string& law, int elements) {
  std::vector<JointSpec> joints(kJoints);
  joints[0] = {{{"dahl", 0, {}}}};
  return RobotFriction(joints, {law, elements});
}

/// Parameters, inputs and states of one moment, stacked: theta, (q, v, load, temperature) per
/// joint, z.
struct Moment {
  std::vector<double> x;
  std::size_t n_theta, n_z;

  Moment(const RobotFriction& model, Rng& rng)
      : n_theta(static_cast<std::size_t>(model.parameter_count())),
        n_z(static_cast<std::size_t>(model.state_size())) {
    x = default_theta(model);
    initialise_weights(model, 7, x);
    for (std::size_t p = 3; p < x.size(); ++p) {
      const ParameterRef& ref = model.parameters()[p];
      if (ref.info.scale == Scale::kFixed && ref.symbol != "sample")
        x[p] = ref.info.typical == 0 ? 0.3 * rng.normal() : x[p] * std::exp(0.3 * rng.normal());
      if (ref.info.scale == Scale::kLinear) x[p] += 0.1 * rng.normal();
      if (ref.info.role == Role::kCrossWeights) x[p] = 1;
    }
    for (int j = 0; j < kJoints; ++j)
      for (const double size : {1.0, 1.0, 10.0, 20.0}) x.push_back(size * rng.normal());
    x.push_back(1e-4 * rng.normal());  // Dahl's bristle
    for (std::size_t k = 1; k < n_z; ++k) x.push_back(rng.uniform());
  }
};

template <class S>
std::vector<Input<S>> inputs_of(const Moment& m, const std::vector<S>& x) {
  std::vector<Input<S>> in;
  for (std::size_t j = 0, at = m.n_theta; j < kJoints; ++j, at += 4)
    in.push_back({x[at], x[at + 1], x[at + 2], x[at + 3]});
  return in;
}

/// tau_bar . torque + z_bar . step
template <class S>
S objective(const RobotFriction& model, const Moment& m, const std::vector<S>& x, double dt,
            const std::vector<double>& bar) {
  const std::vector<Input<S>> in = inputs_of(m, x);
  const std::span<const S> theta(x.data(), m.n_theta);
  std::vector<S> z(x.end() - static_cast<std::ptrdiff_t>(m.n_z), x.end()), tau(kJoints);
  model.torque<S>(theta, in, z, tau);
  model.step<S>(theta, in, dt, z);
  S value(0);
  for (std::size_t j = 0; j < kJoints; ++j) value += S(bar[j]) * tau[j];
  for (std::size_t k = 0; k < m.n_z; ++k) value += S(bar[kJoints + k]) * z[k];
  return value;
}

std::vector<double> gradient(const RobotFriction& model, const Moment& m, double dt,
                             const std::vector<double>& bar) {
  const std::vector<Input<double>> in = inputs_of(m, m.x);
  const std::span<const double> theta(m.x.data(), m.n_theta),
      z = std::span(m.x).last(m.n_z), tau_bar = std::span(bar).first(kJoints),
      z_next_bar = std::span(bar).subspan(kJoints);
  std::vector<double> theta_bar(m.n_theta), z_bar(m.n_z);
  std::vector<Input<double>> in_bar(kJoints);
  model.torque_pullback<double>(theta, in, z, tau_bar, theta_bar, in_bar, z_bar);
  model.step_pullback<double>(theta, in, dt, z, z_next_bar, theta_bar, in_bar, z_bar);
  for (const Input<double>& j : in_bar)
    theta_bar.insert(theta_bar.end(), {j.q, j.v, j.load, j.temperature});
  theta_bar.insert(theta_bar.end(), z_bar.begin(), z_bar.end());
  return theta_bar;
}

class RobotLaws : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Table, RobotLaws, ::testing::Values("nn", "rnn", "lvm_paper"));

// A random direction sees an error in any entry; small ones are also looked at entry by entry.
TEST_P(RobotLaws, PullbackEqualsDualNumbers) {
  for (const int elements : {2, 32}) {
    const RobotFriction model = robot(GetParam(), elements);
    Rng rng(1, 0);
    for (const double dt : {0.0, 1e-3, 4e-3, 5e-3}) {
      Moment m(model, rng);
      std::vector<double> bar;
      for (std::size_t i = 0; i < kJoints + m.n_z; ++i) bar.push_back(rng.normal());
      const std::vector<double> slope = gradient(model, m, dt, bar);
      const auto compare = [&](const std::vector<Dual>& x) {
        double expected = 0, size = 1;
        for (std::size_t i = 0; i < slope.size(); ++i) {
          expected += slope[i] * x[i].d;
          size += std::abs(slope[i] * x[i].d);
        }
        EXPECT_NEAR(objective(model, m, x, dt, bar).d, expected, 1e-11 * size);
      };
      std::vector<Dual> x(m.x.begin(), m.x.end());
      for (Dual& entry : x) entry.d = rng.normal();
      compare(x);
      for (std::size_t i = 0; i < (elements == 2 ? x.size() : 0); ++i) {
        SCOPED_TRACE(i);
        for (Dual& entry : x) entry.d = 0;
        x[i].d = 1;
        compare(x);
      }
    }
  }
}

TEST_P(RobotLaws, LaneEqualsScalarToTheLastBitAndSinglePrecisionIsClose) {
  const RobotFriction model = robot(GetParam(), 16);
  Rng rng(2, 0);
  std::vector<Moment> moments;
  for (int k = 0; k < PackF::kLanes; ++k) moments.emplace_back(model, rng);
  const auto run = [&]<class S>(S) {
    std::vector<S> x(moments[0].x.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      for (int k = 0; k < kLaneCount<S>; ++k)
        set_lane(x[i], k,
                 static_cast<decltype(lane(S(), 0))>(moments[static_cast<std::size_t>(k)].x[i]));
    const std::span<const S> theta(x.data(), moments[0].n_theta);
    std::vector<S> z(x.end() - static_cast<std::ptrdiff_t>(moments[0].n_z), x.end());
    std::vector<S> out(kJoints);
    const std::vector<Input<S>> in = inputs_of(moments[0], x);
    model.torque<S>(theta, in, z, out);
    model.step<S>(theta, in, 4e-3, z);
    out.insert(out.end(), z.begin(), z.end());
    return out;
  };
  const std::vector<PackD> wide = run(PackD());
  const std::vector<PackF> narrow = run(PackF());
  for (int k = 0; k < PackF::kLanes; ++k) {
    std::swap(moments[0], moments[static_cast<std::size_t>(k)]);
    const std::vector<double> one = run(0.0);
    std::swap(moments[0], moments[static_cast<std::size_t>(k)]);
    for (std::size_t i = 0; i < one.size(); ++i) {
      if (k < PackD::kLanes) {
        EXPECT_EQ(wide[i][k], one[i]) << i;
      }
      EXPECT_NEAR(narrow[i][k], one[i], 1e-4 * (1 + std::abs(one[i]))) << i;
    }
  }
}

TEST_P(RobotLaws, StaysFiniteUnderAnyMotion) {
  const RobotFriction model = robot(GetParam(), 32);
  Rng rng(3, 0);
  Moment m(model, rng);
  const std::vector<PackF> theta(m.x.begin(), m.x.begin() + static_cast<std::ptrdiff_t>(m.n_theta));
  std::vector<PackF> z(m.n_z, PackF(0)), tau(kJoints);
  std::vector<Input<PackF>> in(kJoints);
  for (int k = 0; k < 5000; ++k) {
    for (Input<PackF>& j : in)
      j = {float(100 * rng.normal()), float(1000 * rng.normal()), 0.f, 293.f};
    model.step<PackF>(theta, in, 4e-3, z);
    model.torque<PackF>(theta, in, z, tau);
  }
  for (const auto& x : {z, tau})
    for (const PackF& value : x) EXPECT_LT(std::abs(value[0]), 1e9);
}

TEST_P(RobotLaws, StartsAsNextToNoFriction) {
  const RobotFriction model(std::vector<JointSpec>(kJoints), {GetParam(), 32});
  std::vector<double> theta = default_theta(model), tau(kJoints);
  initialise_weights(model, 1, theta);
  const std::vector<double> z(static_cast<std::size_t>(model.state_size()));
  const std::vector<Input<double>> in(kJoints, {0.5, 1, 0, 293});
  model.torque<double>(theta, in, z, tau);
  double largest = 0;
  for (const double t : tau) largest = std::max(largest, std::abs(t));
  EXPECT_NE(theta, default_theta(model));
  EXPECT_LT(largest, 0.2 * 5) << "of 5 N m";
}

TEST_P(RobotLaws, DoesNotAllocate) {
  const RobotFriction model = robot(GetParam(), 8);
  Rng rng(4, 0);
  const Moment m(model, rng);
  const std::vector<Input<double>> in = inputs_of(m, m.x);
  const std::span<const double> theta(m.x.data(), m.n_theta);
  std::vector<double> z(m.n_z), z_bar(m.n_z), z_next_bar(m.n_z, 1), tau(kJoints);
  std::vector<double> theta_bar(m.n_theta);
  std::vector<Input<double>> in_bar(kJoints);
  const long before = fricid::test::allocation_count();
  model.torque<double>(theta, in, z, tau);
  model.step<double>(theta, in, 4e-3, z);
  model.steady_torque<double>(theta, in, tau);
  model.torque_pullback<double>(theta, in, z, tau, theta_bar, in_bar, z_bar);
  model.step_pullback<double>(theta, in, 4e-3, z, z_next_bar, theta_bar, in_bar, z_bar);
  EXPECT_EQ(fricid::test::allocation_count() - before, 0);
}

/// A recurrent network of one unit per layer, its weights all `w` but for the biases.
struct OneUnit {
  RobotFriction model{std::vector<JointSpec>(1), {"rnn", 1}};
  std::vector<double> theta = default_theta(model);
  double q_sd = 2, v_sd = 0.5, tau_sd = 3, w = 0.7;

  OneUnit() {
    theta[1] = q_sd;
    theta[2] = v_sd;
    theta[3] = tau_sd;
    for (std::size_t p = 5; p < theta.size(); ++p) theta[p] = w;
    for (const std::size_t bias : {8, 11, 14, 16}) theta[bias] = 0;
  }
  /// What the three units remember next.
  std::vector<double> next(const Input<double>& in, std::vector<double> h) const {
    double below = in.q / q_sd + in.v / v_sd;
    for (double& unit : h) below = unit = std::max(0.0, w * below + w * unit);
    return h;
  }
};

TEST(Rnn, IsTheRecurrentNetworkWrittenOut) {
  const OneUnit net;
  std::vector<double> z(4), h(3), tau(1);
  for (int k = 0; k < 20; ++k) {
    const Input<double> in{0.1 * k, std::sin(0.7 * k), 0, 293};
    net.model.step<double>(net.theta, {&in, 1}, 4e-3, z);
    h = net.next(in, h);
    net.model.torque<double>(net.theta, {&in, 1}, z, tau);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(z[i], h[i], 1e-12);
    EXPECT_NEAR(tau[0], net.tau_sd * net.w * net.next(in, h)[2], 1e-12);
  }
  EXPECT_GT(h[2], 0.1);
}

TEST(Rnn, RemembersOncePerSampleHoweverTheSampleIsStepped) {
  const OneUnit net;
  const auto after = [&](int substeps) {
    std::vector<double> z(4);
    for (int k = 0; k < 50; ++k)
      for (int i = 1; i <= substeps; ++i) {
        // the motion within the sample does not matter, only that at its end
        const Input<double> in{0.2, i < substeps ? 9.0 : 0.1 * k, 0, 293};
        net.model.step<double>(net.theta, {&in, 1}, 4e-3 / substeps, z);
      }
    return z;
  };
  const std::vector<double> whole = after(1);
  EXPECT_GT(whole[2], 1);
  for (const int substeps : {2, 7, 8}) EXPECT_EQ(after(substeps), whole) << substeps;
}

TEST(LvmPaper, MovesItsStatesByEulerStepsUpToTheClamp) {
  const RobotFriction model(std::vector<JointSpec>(2), {"lvm_paper", 4});
  std::vector<double> theta = default_theta(model);
  theta[theta.size() - 2] = 0.1;  // the biases of eta: what it says without other weights
  theta[theta.size() - 1] = -0.2;
  const std::vector<Input<double>> in(2);
  std::vector<double> z(2);
  model.step<double>(theta, in, 0.01, z);
  EXPECT_DOUBLE_EQ(z[0], 0.1 * LvmPaper::kRate * 0.01);
  EXPECT_DOUBLE_EQ(z[1], -0.6);
  for (int k = 0; k < 50; ++k) model.step<double>(theta, in, 0.01, z);
  EXPECT_EQ(z[1], -LvmPaper::kMost);
}

// Half way to the stop, at it, and back from it: each after travel at .1 rad/s.
TEST(LvmPaper, LatentsStartBetweenStopsOfTheirOwnJoint) {
  for (const int latents : {2, 3, 6, 12}) {
    const RobotFriction model(std::vector<JointSpec>(6), {"lvm_paper", 32, latents});
    std::vector<double> theta = default_theta(model);
    initialise_weights(model, 1, theta);
    for (int i = 0; i < latents; ++i) {
      SCOPED_TRACE(testing::Message() << latents << " latents, " << i);
      std::vector<double> z(static_cast<std::size_t>(latents));
      std::vector<Input<double>> in(6, {0.3, 0, 0, 293});
      const auto travel = [&](double way, double speed) {
        in[static_cast<std::size_t>(i % 6)].v = speed;
        const double dt = 5e-4;
        for (double t = 0; t < way / std::abs(speed); t += dt) model.step<double>(theta, in, dt, z);
        return z[static_cast<std::size_t>(i)];
      };
      const double way = i < 6 ? 2e-3 : 6e-3;
      EXPECT_NEAR(travel(0.5 * way, 0.1), 0.5, 0.15);
      EXPECT_NEAR(travel(3 * way, 0.1), 1, 0.15);
      EXPECT_LT(travel(1.5 * way, -0.1), 0);
      EXPECT_NEAR(travel(3 * way, -0.1), -1, 0.15);
      for (int other = 0; other < std::min(latents, 6); ++other)
        EXPECT_TRUE(other == i % 6 || std::abs(z[static_cast<std::size_t>(other)]) < 0.05) << other;
    }
  }
}

// Twice the length, twice the way.
TEST(LvmPaper, LatentsChangeOverTheirLength) {
  const RobotFriction model(std::vector<JointSpec>(2), {"lvm_paper", 32, 1});
  std::vector<double> theta = default_theta(model);
  initialise_weights(model, 1, theta);
  const auto z_after = [&](double way) {
    const std::vector<Input<double>> in{{0.3, 0.1, 0, 293}, {0, 0, 0, 293}};
    std::vector<double> z(1);
    for (double t = 0; t < way / 0.1; t += 1e-4) model.step<double>(theta, in, 1e-4, z);
    return z[0];
  };
  const double half = z_after(1e-3);
  EXPECT_NEAR(half, 0.5, 0.1);
  const auto& parameters = model.parameters();
  std::vector<std::string> moved;
  for (std::size_t p = 0; p < parameters.size(); ++p)
    if (parameters[p].info.role == Role::kLength) {
      if (parameters[p].info.scale != Scale::kFixed) moved.push_back(parameters[p].symbol);
      theta[p] *= 2;
    }
  EXPECT_THAT(moved, testing::ElementsAre("l1"));  // joint 2 has no latent
  EXPECT_NEAR(z_after(2e-3), half, 0.1);
}

// What is held in training couples no joint with another: torque of joint 1 says nothing of
// joint 2.
TEST(LvmPaper, TrainsWithinJointsAlone) {
  const RobotFriction model(std::vector<JointSpec>(2), {"lvm_paper", 32, 2});
  std::vector<double> theta = default_theta(model);
  initialise_weights(model, 1, theta);
  const std::vector<double> rates = training_rates(model, theta);
  Rng rng(6, 0);
  for (std::size_t p = 10; p < theta.size(); ++p) theta[p] += 0.3 * rates[p] * rng.normal();
  std::vector<Input<double>> in(2, {0.3, 0.5, 0, 293});
  const auto say = [&] {
    std::vector<double> z{0.2, -0.3}, tau(2);
    model.step<double>(theta, in, 1e-3, z);
    model.torque<double>(theta, in, z, tau);
    tau.insert(tau.end(), z.begin(), z.end());
    return tau;
  };
  const std::vector<double> before = say();
  in[0].v = -0.2;
  in[1].q = 1;
  const std::vector<double> after = say();
  EXPECT_NE(after[0], before[0]);
  EXPECT_NE(after[2], before[2]);
  EXPECT_EQ(after[1], before[1]);
  EXPECT_EQ(after[3], before[3]);
  EXPECT_EQ(training_rates(robot("nn", 4), default_theta(robot("nn", 4))),
            std::vector<double>(static_cast<std::size_t>(robot("nn", 4).parameter_count()), 1));
}

// Weights of zero that act, and weights that do not: the same torques, states and gradients, to the
// last bit, but those by the weights that do not act.
TEST(LvmPaper, WithoutCrossWeightsIsTheNetworkInWhichTheyAreZero) {
  for (const auto& [joints, elements, latents] :
       {std::tuple{2, 3, 1}, {3, 2, 2}, {3, 32, 3}, {6, 32, 2}, {6, 32, 12}, {8, 32, 9}}) {
    SCOPED_TRACE(testing::Message() << joints << " joints, " << latents << " latents");
    const RobotFriction model(std::vector<JointSpec>(static_cast<std::size_t>(joints)),
                              {"lvm_paper", elements, latents});
    Rng rng(8, 0);
    std::vector<double> theta = default_theta(model);
    initialise_weights(model, 3, theta);
    const std::vector<double> rates = training_rates(model, theta);
    for (std::size_t p = 0; p < theta.size(); ++p)
      if (is_weight(model.parameters()[p].info.role)) theta[p] += 0.3 * rates[p] * rng.normal();
    std::vector<Input<double>> in(static_cast<std::size_t>(joints));
    for (Input<double>& of_joint : in) of_joint = {rng.normal(), rng.normal(), 0, 293};
    std::vector<double> z, bar, z_bar;
    for (int i = 0; i < latents; ++i) {
      z.push_back(rng.normal());
      z_bar.push_back(rng.normal());
    }
    for (int j = 0; j < joints; ++j) bar.push_back(rng.normal());
    const std::size_t cross = std::ranges::find(model.parameters(), Role::kCrossWeights,
                                                [](const auto& p) { return p.info.role; }) -
                              model.parameters().begin();
    // values, then adjoints of in and z, then of theta
    const auto run = [&](double acts) {
      theta[cross] = acts;
      std::vector<double> out(in.size()), theta_bar(theta.size()), z_out = z, z_sum(z.size());
      std::vector<Input<double>> in_bar(in.size());
      model.torque<double>(theta, in, z, out);
      model.step<double>(theta, in, 1e-3, z_out);
      model.torque_pullback<double>(theta, in, z, bar, theta_bar, in_bar, z_sum);
      model.step_pullback<double>(theta, in, 1e-3, z, z_bar, theta_bar, in_bar, z_sum);
      out.insert(out.end(), z_out.begin(), z_out.end());
      out.insert(out.end(), z_sum.begin(), z_sum.end());
      for (const Input<double>& of_joint : in_bar) out.push_back(of_joint.v);
      return std::pair{out, theta_bar};
    };
    const auto [values, gradient] = run(0);
    const auto [dense_values, dense_gradient] = run(1);
    EXPECT_EQ(values, dense_values);
    int held = 0;
    for (std::size_t p = 0; p < theta.size(); ++p) {
      held += rates[p] == 0;
      EXPECT_EQ(gradient[p], rates[p] == 0 ? 0 : dense_gradient[p]) << p;
    }
    theta[cross] = 0;
    const int within = free_parameter_count({model, theta});
    theta[cross] = 1;
    EXPECT_GT(held, 0);
    EXPECT_EQ(free_parameter_count({model, theta}) - within, held);
    for (const double rate : training_rates(model, theta)) EXPECT_GT(rate, 0);
  }
}

TEST(RobotLaws, TakeTheirScalesFromTheData) {
  const RobotFriction model = robot("nn", 4);
  std::vector<double> theta = default_theta(model);
  const std::size_t begin = 3;  // after dahl
  set_signal_sizes(model, {{1, 2, 3}, {4, 5, 6}, {7, 8, 0}, {10, 11, 12}}, theta);
  EXPECT_THAT(std::vector<double>(theta.begin() + begin, theta.begin() + begin + 12),
              testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 1e-6, 10, 11, 12));
  EXPECT_EQ(free_parameter_count({model, theta}), model.parameter_count() - 12);
}

TEST(RobotLaws, AddToTheLawsOfTheJoints) {
  const RobotFriction both = robot("nn", 4), alone(std::vector<JointSpec>(kJoints), {"nn", 4});
  Rng rng(5, 0);
  const Moment m(both, rng);
  const std::vector<Input<double>> in = inputs_of(m, m.x);
  const std::span<const double> theta(m.x.data(), m.n_theta);
  std::vector<double> sum(kJoints), part(kJoints);
  both.torque<double>(theta, in, std::span(m.x).last(1), sum);
  alone.torque<double>(theta.subspan(3), in, {}, part);
  EXPECT_NEAR(sum[0] - part[0], m.x[1] * m.x.back() + m.x[2] * in[0].v, 1e-12);  // sigma0 z + Fv v
  EXPECT_EQ(sum[2], part[2]);
}

TEST(RobotLaws, NameWhatIsWrong) {
  const auto message_of = [](const std::string& law, int joints, int elements) -> std::string {
    try {
      RobotFriction(std::vector<JointSpec>(static_cast<std::size_t>(joints)), {law, elements});
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message_of("dahl", 3, 4),
            "unknown law of the whole robot 'dahl'; known: nn, rnn, lvm_paper");
  EXPECT_EQ(message_of("nn", 3, 33), "nn: elements = 33, allowed 1 .. 32");
  EXPECT_EQ(message_of("nn", 9, 3), "nn: 9 joints, allowed 1 .. 8");
  EXPECT_EQ(message_of("nn", 8, 32), "");
  EXPECT_THROW(RobotFriction(std::vector<JointSpec>(2), {"lvm_paper", 32, 13}), UserError);
  EXPECT_THROW(RobotFriction(std::vector<JointSpec>(2), {"lvm_paper", 32, 0}), UserError);
}

}  // namespace
}  // namespace fricid::friction::test
