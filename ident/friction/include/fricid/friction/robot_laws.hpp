// The table of the laws of a whole robot: networks that see all joints at once. A new one is a
// header and one row here.
#pragma once

#include <concepts>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/robot_laws/lvm_paper.hpp"
#include "fricid/friction/robot_laws/nn.hpp"
#include "fricid/friction/robot_laws/rnn.hpp"

namespace fricid::friction {

using RobotLaws = std::tuple<  //
    Nn,                        //
    Rnn,                       //
    LvmPaper>;

/// A law of a whole robot has the members of a law of a joint (law.hpp), but is constructed from
/// its sizes and takes `in` (n), tau_f (n) and their adjoints. Torques are added to tau_f. The
/// first parameters are those of SignalScales. A law whose number of states can be chosen has
/// kMostLatents; one whose weights train at different rates has
///
///     void training_rates(const double* theta, double* rate) const;   writes those of the weights
template <class Law>
concept RobotLaw = std::copyable<Law> && std::constructible_from<Law, RobotLawSize> &&
    requires(const Law law, const double* theta, double* z, const Input<double>* in,
             Input<double>* in_bar, double dt, double* bar, Rng& rng) {
  { Law::kName } -> std::convertible_to<std::string_view>;
  { Law::kEquation } -> std::convertible_to<std::string_view>;
  { Law::kSource } -> std::convertible_to<std::string_view>;
  { Law::kLook } -> std::convertible_to<PlotLook>;
  { Law::kMostElements } -> std::convertible_to<int>;
  { law.state_size() } -> std::same_as<int>;
  { law.parameters() } -> std::same_as<std::vector<ParameterInfo>>;
  law.initialise(bar, rng);
  law.template add_torque<double>(theta, in, z, bar);
  law.template step<double>(theta, in, dt, z);
  law.template torque_pullback<double>(theta, in, z, bar, bar, in_bar, bar);
  law.template step_pullback<double>(theta, in, dt, z, z, bar, in_bar, bar);
  law.template add_steady_torque<double>(theta, in, bar);
};

/// Calls f(law) for row `index` of RobotLaws.
template <class F>
void visit_robot_law(int index, RobotLawSize size, F&& f) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (void)((index == static_cast<int>(I) && (f(std::tuple_element_t<I, RobotLaws>(size)), true)) ||
           ...);
  }
  (std::make_index_sequence<std::tuple_size_v<RobotLaws>>{});
}

static_assert([]<class... L>(std::tuple<L...>*) {
  return (RobotLaw<L> && ...);
}(static_cast<RobotLaws*>(nullptr)));

}  // namespace fricid::friction
