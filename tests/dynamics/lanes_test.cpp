// Every lane of a pack is the scalar algorithm, single precision is close, nothing allocates.
#include <gtest/gtest.h>

#include "allocation_counter.hpp"
#include "robots.hpp"

namespace fricid::dynamics::test {
namespace {

/// All outputs of the algorithms for one value type, one after the other.
template <class S>
struct Outputs {
  std::vector<S> tau, a, M, x, q_bar, v_bar, a_bar, pi_bar;

  explicit Outputs(const RobotModel& model) {
    const auto n = static_cast<size_t>(model.n());
    for (auto* out : {&tau, &a, &x, &q_bar, &v_bar, &a_bar}) out->assign(n, S(0));
    M.assign(n * n, S(0));
    pi_bar.assign(static_cast<size_t>(model.parameter_count()), S(0));
  }
  std::vector<S> all() const {
    std::vector<S> values;
    for (const auto* part : {&tau, &a, &M, &x, &q_bar, &v_bar, &a_bar, &pi_bar})
      values.insert(values.end(), part->begin(), part->end());
    return values;
  }
};

template <class S>
struct Inputs {
  std::vector<S> pi, q, v, a, tau;
};

template <class S>
void run(const RobotModel& model, Workspace<S>& ws, const Inputs<S>& in, Outputs<S>& out) {
  rnea<S>(model, ws, in.pi, in.q, in.v, in.a, out.tau);
  crba<S>(model, ws, in.pi, in.q, out.M);
  forward_dynamics<S>(model, ws, in.pi, in.q, in.v, in.tau, out.a);
  solve_with_last_factor<S>(model, ws, in.a, out.x);
  rnea_pullback<S>(model, ws, in.pi, in.q, in.v, in.a, in.tau, out.q_bar, out.v_bar, out.a_bar,
                   out.pi_bar);
}

/// Lane l of the pack gets state first + l; masses differ by lane too.
template <class S>
Inputs<S> inputs(const RobotModel& model, int first) {
  Inputs<S> in;
  in.pi.resize(static_cast<size_t>(model.parameter_count()));
  for (auto* part : {&in.q, &in.v, &in.a, &in.tau}) part->resize(model.joints.size());
  for (int l = 0; l < kLaneCount<S>; ++l) {
    const State s = random_state(model, first + l);
    const auto put = [l](std::vector<S>& to, const VectorXd& from, double factor) {
      for (size_t i = 0; i < to.size(); ++i) {
        using Real = decltype(lane(S(0), 0));
        set_lane(to[i], l, static_cast<Real>(from(static_cast<int>(i)) * factor));
      }
    };
    put(in.pi, model.pi, 1 + 0.05 * (first + l));
    put(in.q, s.q, 1);
    put(in.v, s.v, 1);
    put(in.a, s.a, 1);
    put(in.tau, s.tau, 1);
  }
  return in;
}

TEST(Lanes, EqualTheScalarToTheLastBit) {
  for (const RobotModel& model : all_robots()) {
    SCOPED_TRACE(model.name);
    Workspace<double> scalar_ws(model);
    Workspace<PackD> ws(model);
    for (int first = 0; first < 40; first += kLaneCount<PackD>) {
      Outputs<PackD> packed(model);
      run(model, ws, inputs<PackD>(model, first), packed);
      const auto lanes = packed.all();
      for (int l = 0; l < kLaneCount<PackD>; ++l) {
        Outputs<double> scalar(model);
        run(model, scalar_ws, inputs<double>(model, first + l), scalar);
        const auto expected = scalar.all();
        for (size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(lane(lanes[i], l), expected[i]) << i;
      }
    }
  }
}

TEST(Lanes, SinglePrecisionIsClose) {
  for (const RobotModel& model : all_robots()) {
    SCOPED_TRACE(model.name);
    Workspace<double> scalar_ws(model);
    Workspace<PackF> ws(model);
    const auto in = inputs<PackF>(model, 0);
    Outputs<PackF> packed(model);
    run(model, ws, in, packed);
    for (int l = 0; l < kLaneCount<PackF>; ++l) {
      Inputs<double> same;
      const auto widen = [l](const std::vector<PackF>& from) {
        std::vector<double> to;
        for (const PackF& x : from) to.push_back(lane(x, l));
        return to;
      };
      same = {widen(in.pi), widen(in.q), widen(in.v), widen(in.a), widen(in.tau)};
      Outputs<double> scalar(model);
      run(model, scalar_ws, same, scalar);
      const auto check = [&](const std::vector<PackF>& x, const std::vector<double>& y) {
        const auto wide = widen(x);
        const auto size = static_cast<Eigen::Index>(y.size());
        EXPECT_TRUE(close(VectorXd::Map(wide.data(), size), VectorXd::Map(y.data(), size), 5e-4));
      };
      check(packed.tau, scalar.tau);
      check(packed.a, scalar.a);
      check(packed.M, scalar.M);
      check(packed.x, scalar.x);
      check(packed.q_bar, scalar.q_bar);
      check(packed.v_bar, scalar.v_bar);
      check(packed.a_bar, scalar.a_bar);
      check(packed.pi_bar, scalar.pi_bar);
    }
  }
}

template <class S>
void expect_no_allocation(const RobotModel& model) {
  Workspace<S> ws(model);
  const Inputs<S> in = inputs<S>(model, 1);
  Outputs<S> out(model);
  const long before = fricid::test::allocation_count();
  for (int k = 0; k < 10; ++k) run(model, ws, in, out);
  EXPECT_EQ(fricid::test::allocation_count(), before) << model.name;
}

TEST(Lanes, NothingAllocates) {
  for (const RobotModel& model : all_robots()) {
    expect_no_allocation<double>(model);
    expect_no_allocation<PackD>(model);
    expect_no_allocation<PackF>(model);
    Workspace<double> ws(model);
    MatrixXd Y(model.n(), model.parameter_count());
    const Inputs<double> in = inputs<double>(model, 1);
    const long before = fricid::test::allocation_count();
    regressor(model, ws, in.q, in.v, in.a, Y);
    kinetic_energy(model, ws, in.pi, in.q, in.v);
    potential_energy(model, ws, in.pi, in.q);
    EXPECT_EQ(fricid::test::allocation_count(), before) << model.name;
  }
}

}  // namespace
}  // namespace fricid::dynamics::test
