// Cost of one joint's friction, torque and step, per state: items are lanes.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "fricid/friction/robot_friction.hpp"

namespace {

using namespace fricid;
using namespace fricid::friction;

// Every lane moves on its own phase through reversals, presliding and sliding.
template <class S>
struct Drive {
  static constexpr std::size_t kInputs = 64;
  std::array<Input<S>, kInputs> in;

  Drive() {
    for (std::size_t k = 0; k < kInputs; ++k)
      for (int i = 0; i < kLaneCount<S>; ++i) {
        using T = decltype(lane(S(), 0));
        const double phase = 6.283185307179586 * (static_cast<double>(k) / kInputs + 0.13 * i);
        set_lane(in[k].q, i, static_cast<T>(0.3 * std::cos(phase)));
        set_lane(in[k].v, i, static_cast<T>(0.5 * std::sin(phase)));
        set_lane(in[k].load, i, static_cast<T>(30 * std::sin(2 * phase)));
        set_lane(in[k].temperature, i, static_cast<T>(305));
      }
  }
};

template <class S>
void torque_and_step(benchmark::State& state, const JointSpec& joint) {
  const RobotFriction model({joint});
  const std::vector<double> typical = default_theta(model);
  const std::vector<S> theta(typical.begin(), typical.end());
  std::vector<S> z(static_cast<std::size_t>(model.state_size()), S(0)), tau(1);
  const Drive<S> drive;
  std::size_t k = 0;
  for (auto _ : state) {
    const Input<S>& in = drive.in[k++ % Drive<S>::kInputs];
    model.torque<S>(theta, {&in, 1}, z, tau);
    model.step<S>(theta, {&in, 1}, 5e-4, z);
    benchmark::DoNotOptimize(tau.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kLaneCount<S>);
}

template <class S>
void pullbacks(benchmark::State& state, const JointSpec& joint) {
  const RobotFriction model({joint});
  const std::vector<double> typical = default_theta(model);
  const std::vector<S> theta(typical.begin(), typical.end());
  const auto n_z = static_cast<std::size_t>(model.state_size());
  std::vector<S> z(n_z, S(1e-4)), z_next_bar(n_z, S(1)), z_bar(n_z), theta_bar(theta.size());
  const S tau_bar = S(1);
  Input<S> in_bar{S(0), S(0), S(0), S(0)};
  const Drive<S> drive;
  std::size_t k = 0;
  for (auto _ : state) {
    const Input<S>& in = drive.in[k++ % Drive<S>::kInputs];
    model.torque_pullback<S>(theta, {&in, 1}, z, {&tau_bar, 1}, theta_bar, {&in_bar, 1}, z_bar);
    model.step_pullback<S>(theta, {&in, 1}, 5e-4, z, z_next_bar, theta_bar, {&in_bar, 1}, z_bar);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kLaneCount<S>);
}

// The joints that are timed: every law alone, and what the richest ground truth injects.
[[maybe_unused]] const bool kRegistered = [] {
  std::vector<std::pair<std::string, JointSpec>> joints;
  for (const LawInfo& law : law_table())
    joints.push_back(
        {std::string(law.name), {{{std::string(law.name), law.has_elements ? 4 : 0, {}}}}});
  const std::vector<ModifierSpec> modifiers = {{"load"}, {"ripple", 3}, {"asymmetry"}};
  joints.push_back(
      {"kr6_full_joint", {{{"maxwell_slip", 10, modifiers}, {"viscous_power", 0, {{"load"}}}}}});
  for (const char* law : {"neural", "lvm1", "lvm_bristles", "lvm4"})
    joints.push_back({std::string(law) + "_16", {{{law, 16, {}}}}});
  joints.push_back({"lugre_backlash", {{{"lugre", 0, {{"backlash"}}}}}});
  for (const auto& [name, joint] : joints) {
    const auto add = [&joint = joint](const std::string& title, auto function) {
      benchmark::RegisterBenchmark(title.c_str(), function, joint);
    };
    add("BM_Friction/" + name + "/f64", torque_and_step<PackD>);
    add("BM_Friction/" + name + "/f32", torque_and_step<PackF>);
    add("BM_Friction/" + name + "/scalar", torque_and_step<double>);
    add("BM_FrictionPullback/" + name + "/f64", pullbacks<PackD>);
  }
  return true;
}();

}  // namespace
