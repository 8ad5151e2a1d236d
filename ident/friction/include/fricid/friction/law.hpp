// The one friction abstraction, joint level. The simulator, identification, evaluation, the online
// estimator and the plots all call these functions and no others.
#pragma once

#include <span>
#include <string_view>

#include "fricid/base/pack.hpp"
#include "fricid/friction/role.hpp"

namespace fricid::friction {

/// Inputs of the friction of one joint, held over a step.
template <class S>
struct Input {
  S q;            ///< joint position [rad or m]
  S v;            ///< joint velocity [rad/s or m/s]
  S load;         ///< torque through the gear: the motor torque unless a scene says otherwise [N m]
  S temperature;  ///< [K]
};

/// How a parameter is searched: on its logarithm (positive, orders of magnitude), linearly, or not
/// at all (a constant of the data that belongs to the model, as the scales of a network's inputs).
enum class Scale { kLog, kLinear, kFixed };

/// One entry of a parameter vector theta: what a scene, a model file, a fit and the documentation
/// need to know about it. Bounds are closed and in `unit`.
struct ParameterInfo {
  std::string_view symbol;  ///< as in papers and files, e.g. "sigma0"
  std::string_view unit;    ///< SI, e.g. "N m/rad"; "1" if dimensionless
  Role role;                ///< what it is; its unit is that of the role
  double lower, upper;      ///< bounds in scenes and fits
  double typical;           ///< of a medium-sized joint; start of a search and default in templates
  Scale scale;
  std::string_view meaning;  ///< one phrase
  int element = 0;  ///< 1, 2, ... of a numbered family ("k3": 3); 0: the only one of its kind

  constexpr bool has_unit() const { return unit != "1"; }
  /// The symbol without the number of its element: "k" of "k3".
  constexpr std::string_view stem() const {
    return element > 0 ? symbol.substr(0, symbol.find_last_not_of("0123456789") + 1) : symbol;
  }
};

/// Properties that the law suite checks beyond those of every law.
struct Claims {
  bool odd = true;          ///< tau_f(-v, -z) = -tau_f(v, z) at q = load = 0, T = 293.15 K
  bool dissipative = true;  ///< no energy gain over closed cycles of z
  bool contracts = true;    ///< |dz'/dz| <= 1
  bool semigroup = true;    ///< two half steps at the same v equal one
  bool settles = true;      ///< at constant v every state ends at steady_torque
};

/// Colour and marker of a law in plots.
struct PlotLook {
  std::string_view colour;  ///< "#rrggbb", unique to the law
  int marker;               ///< point type of gnuplot
};

/// Sizes of a law of the whole robot.
struct RobotLawSize {
  int joints = 1;
  int elements = 1;  ///< width of its networks
  int latents = 2;   ///< number of states, for laws where it can be chosen
};

/// Which inputs beside v a law or modifier uses.
struct Reads {
  bool q = false, load = false, temperature = false;
};

// A LAW is a small value of pure structure: no parameters, no memory, no clock. Parameters theta
// and state z belong to the caller. With v held over [t_k, t_k + dt):
//
//     tau_k   = torque(theta, in, z_k)       [N m], > 0 resists v > 0
//     z_{k+1} = step(theta, in, dt, z_k)     in place, exact or exponential, stable at any dt >= 0
//
// so that  M(q) a + h(q, v) + tau_f = tau. Torque is read at k, then the state moves to k + 1; a
// host that integrates semi-implicitly moves z with the new velocity, as it does q.
//
// Every law has the members (S = double, a Pack, or a dual number):
//
//     static constexpr std::string_view kName;      name in scenes and model files
//     static constexpr std::string_view kEquation;  one line for the tables
//     static constexpr std::string_view kSource;    paper
//     static constexpr PlotLook kLook;              colour and marker in plots
//     static constexpr Claims kClaims;  static constexpr Reads kReads;
//     static constexpr int kMostElements;      constructed from 1 .. this; 0: without arguments
//     int  state_size() const;                 a law without states has the base Stateless
//     std::span<const ParameterInfo> parameters() const;
//     S    torque(const S* theta, const Input<S>& in, const S* z) const;
//     void step(const S* theta, const Input<S>& in, double dt, S* z) const;
//     // vector-Jacobian products, hand-written; all *_bar are accumulated into
//     void torque_pullback(const S* theta, const Input<S>& in, const S* z, S tau_bar,
//                          S* theta_bar, Input<S>& in_bar, S* z_bar) const;
//     void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z,
//                        const S* z_next_bar, S* theta_bar, Input<S>& in_bar, S* z_bar) const;
//     S    steady_torque(const S* theta, const Input<S>& in) const;   limit of torque at constant v
//
// if it has states,
//
//     static constexpr std::string_view kStateUnit;
//     void state_bound(const double* theta, double fastest, double* bound) const;
//                                                   largest |z_i| reached from 0 at |v| <= fastest
//
// if it contains networks,
//
//     void initialise(double* theta, Rng& rng) const;   writes the weights only
//
// and, if step and torque share work at one velocity,
//
//     S step_torque(const S* theta, const Input<S>& in, double dt, S* z) const;
//                                                       step, then torque, to the last bit
//
// Such a law of one state without networks is also called with S = Group<Pack, N> (group.hpp), N
// joints at a time.

/// Base of the laws whose torque depends on the present input alone.
struct Stateless {
  static constexpr int state_size() { return 0; }

  template <class S>
  void step(const S*, const Input<S>&, double, S*) const {}

  template <class S>
  void step_pullback(const S*, const Input<S>&, double, const S*, const S*, S*, Input<S>&,
                     S*) const {}
};

template <class Law, class S>
concept SharedStepLaw = requires(const Law law, const S* theta, const Input<S>& in, S* z) {
  law.step_torque(theta, in, 0.0, z);
};

}  // namespace fricid::friction
