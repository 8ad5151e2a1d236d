// The table of all laws and modifiers. A new one is a header and one row here; the scene reader,
// the model file, the fits, the tests and docs/friction_laws.md follow.
#pragma once

#include <concepts>
#include <cstddef>
#include <tuple>
#include <utility>

#include "fricid/base/rng.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/laws/coulomb_viscous.hpp"
#include "fricid/friction/laws/dahl.hpp"
#include "fricid/friction/laws/gms.hpp"
#include "fricid/friction/laws/lagged_stribeck.hpp"
#include "fricid/friction/laws/load_dependent.hpp"
#include "fricid/friction/laws/lugre.hpp"
#include "fricid/friction/laws/lvm.hpp"
#include "fricid/friction/laws/maxwell_slip.hpp"
#include "fricid/friction/laws/memory_network.hpp"
#include "fricid/friction/laws/neural.hpp"
#include "fricid/friction/laws/none.hpp"
#include "fricid/friction/laws/prandtl_ishlinskii.hpp"
#include "fricid/friction/laws/preisach.hpp"
#include "fricid/friction/laws/stribeck.hpp"
#include "fricid/friction/laws/stribeck_peak.hpp"
#include "fricid/friction/laws/viscous.hpp"
#include "fricid/friction/laws/viscous_power.hpp"
#include "fricid/friction/modifiers/asymmetry.hpp"
#include "fricid/friction/modifiers/backlash.hpp"
#include "fricid/friction/modifiers/gear_load.hpp"
#include "fricid/friction/modifiers/load.hpp"
#include "fricid/friction/modifiers/ripple.hpp"
#include "fricid/friction/modifiers/temperature.hpp"
#include "fricid/friction/modifiers/viscosity.hpp"

namespace fricid::friction {

using Laws = std::tuple<  //
    None,                 //
    CoulombViscous,       //
    Stribeck,             //
    StribeckPeak,         //
    LoadDependent,        //
    Viscous,              //
    ViscousPower,         //
    Dahl,                 //
    LuGre,                //
    LuGreClassic,         //
    Gms,                  //
    MaxwellSlip,          //
    PrandtlIshlinskii,    //
    Preisach,             //
    LaggedStribeck,       //
    Neural,               //
    MemoryNetwork,        //
    Lvm1,                 //
    Lvm,                  //
    Lvm4>;

using Modifiers = std::tuple<  //
    LoadModifier,              //
    GearLoad,                  //
    Ripple,                    //
    Temperature,               //
    Viscosity,                 //
    Asymmetry,                 //
    Backlash>;

/// What every law has, see law.hpp.
template <class Law>
concept FrictionLaw = std::copyable<Law> &&
    requires(const Law law, const double* theta, double* z, const Input<double>& in,
             Input<double>& in_bar, double dt, double* bar) {
  { Law::kName } -> std::convertible_to<std::string_view>;
  { Law::kEquation } -> std::convertible_to<std::string_view>;
  { Law::kSource } -> std::convertible_to<std::string_view>;
  { Law::kLook } -> std::convertible_to<PlotLook>;
  { Law::kClaims } -> std::convertible_to<Claims>;
  { Law::kReads } -> std::convertible_to<Reads>;
  { Law::kMostElements } -> std::convertible_to<int>;
  { law.state_size() } -> std::same_as<int>;
  { law.parameters() } -> std::same_as<std::span<const ParameterInfo>>;
  { law.template torque<double>(theta, in, z) } -> std::same_as<double>;
  { law.template step<double>(theta, in, dt, z) } -> std::same_as<void>;
  law.template torque_pullback<double>(theta, in, z, dt, bar, in_bar, bar);
  law.template step_pullback<double>(theta, in, dt, z, z, bar, in_bar, bar);
  { law.template steady_torque<double>(theta, in) } -> std::same_as<double>;
};

/// Laws with networks, whose weights start as random numbers.
template <class Law>
concept LearnedLaw = requires(const Law law, double* theta, Rng& rng) {
  { law.initialise(theta, rng) } -> std::same_as<void>;
};

/// Modifiers of the torque, tau' = apply(tau); the other kind, Backlash, modifies the motion.
template <class Modifier>
concept TorqueModifier = requires(const Modifier m, const double* theta, const Input<double>& in,
                                  double tau) {
  { m.template apply<double>(theta, in, tau) } -> std::same_as<double>;
};

/// A law or modifier with its run-time number of elements or terms.
template <class T>
constexpr T make_entry(int elements) {
  if constexpr (T::kMostElements > 0)
    return T(elements);
  else
    return T{};
}

/// Calls f(entry) with entry `index` of the list (Laws or Modifiers); one comparison per row.
template <class List, class F>
void visit_entry(int index, int elements, F&& f) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (void)((index == static_cast<int>(I) &&
            (f(make_entry<std::tuple_element_t<I, List>>(elements)), true)) ||
           ...);
  }
  (std::make_index_sequence<std::tuple_size_v<List>>{});
}

static_assert([]<class... L>(std::tuple<L...>*) {
  return (FrictionLaw<L> && ...);
}(static_cast<Laws*>(nullptr)));

}  // namespace fricid::friction
