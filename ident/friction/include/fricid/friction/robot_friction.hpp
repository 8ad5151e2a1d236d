// Friction of a whole robot: per joint a sum of laws, each seen through its modifiers, and at most
// one law that sees all joints at once. Chosen at run time, evaluated without virtual calls: one
// dispatch per joint and law for all lanes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// A modifier of a law by name ("load", "ripple", "temperature", "backlash", "asymmetry").
struct ModifierSpec {
  std::string name;
  int order = 1;  ///< number of terms for modifiers that have several (ripple harmonics)
};

/// One law of a joint by name, with the modifiers that apply to it, innermost first, each at most
/// once. Backlash acts on the motion, the others on the torque, so its place among them is free.
struct LawSpec {
  std::string law;
  int elements = 0;  ///< number of elements or network width if LawInfo::has_elements; else 0
  std::vector<ModifierSpec> modifiers;
};

/// The friction of a joint is the sum of its laws; no law means no friction.
struct JointSpec {
  std::vector<LawSpec> laws;
};

/// A law of the whole robot by name; empty name: none.
struct RobotLawSpec {
  std::string law;
  int elements = 0;  ///< width of its networks
  int latents =
      RobotLawSize{}.latents;  ///< number of states if LawInfo::most_latents > 0; else unused
};

/// ParameterRef::joint of the parameters of the law of the whole robot.
inline constexpr int kWholeRobot = -1;

/// Meaning of one entry of theta.
struct ParameterRef {
  int joint;           ///< index of the joint, or kWholeRobot
  int law;             ///< index of the law within the joint
  std::string owner;   ///< name of the law or modifier
  std::string symbol;  ///< symbol within the owner, e.g. "k3" of a 4-element gms
  ParameterInfo info;
};

/// Scales of the signals of every joint, see SignalScales. All (n).
struct SignalSizes {
  std::vector<double> q_mean, q_sd, v_sd, tau_sd;  ///< [rad] [rad] [rad/s] [N m]
};

/// Structure of the friction of n joints. `theta` stacks joints, then laws, then (law parameters,
/// modifier parameters in order), and last the law of the whole robot; `z` likewise. Both belong to
/// the caller.
class RobotFriction {
 public:
  RobotFriction() = default;
  /// @throws UserError on an unknown law or modifier, naming the known ones
  explicit RobotFriction(std::vector<JointSpec> joints, RobotLawSpec whole = {});

  int joint_count() const { return static_cast<int>(joints_.size()); }
  int parameter_count() const { return static_cast<int>(parameters_.size()); }
  int state_size() const { return state_size_; }
  const std::vector<JointSpec>& joints() const { return joints_; }
  const RobotLawSpec& whole() const { return whole_; }
  bool has_whole() const { return !whole_.law.empty(); }
  const std::vector<ParameterRef>& parameters() const { return parameters_; }
  int parameter_begin(int joint) const;  ///< theta of joint j: [begin(j), begin(j + 1))
  int state_begin(int joint) const;      ///< z of joint j: [begin(j), begin(j + 1))
  bool reads_load() const;
  bool reads_temperature() const;

  /// tau_f (n) [N m] from theta (parameter_count), in (n), z (state_size).
  template <class S>
  void torque(std::span<const S> theta, std::span<const Input<S>> in, std::span<const S> z,
              std::span<S> tau_f) const;

  /// Advances z by dt [s] with the inputs held.
  template <class S>
  void step(std::span<const S> theta, std::span<const Input<S>> in, double dt,
            std::span<S> z) const;

  /// `step`, then `torque` at the new z and the same inputs, to the last bit; cheaper.
  template <class S>
  void step_torque(std::span<const S> theta, std::span<const Input<S>> in, double dt,
                   std::span<S> z, std::span<S> tau_f) const;

  /// Limit of `torque` (n) at constant v, load and temperature [N m], from any state: the curve of
  /// friction against speed. Hysteretic laws give 0 at v = 0.
  template <class S>
  void steady_torque(std::span<const S> theta, std::span<const Input<S>> in,
                     std::span<S> tau_f) const;

  /// Accumulates the vector-Jacobian product of `torque` into theta_bar, in_bar, z_bar.
  template <class S>
  void torque_pullback(std::span<const S> theta, std::span<const Input<S>> in, std::span<const S> z,
                       std::span<const S> tau_f_bar, std::span<S> theta_bar,
                       std::span<Input<S>> in_bar, std::span<S> z_bar) const;

  /// The same for `step`; z is the state before the step.
  template <class S>
  void step_pullback(std::span<const S> theta, std::span<const Input<S>> in, double dt,
                     std::span<const S> z, std::span<const S> z_next_bar, std::span<S> theta_bar,
                     std::span<Input<S>> in_bar, std::span<S> z_bar) const;

 private:
  struct ModifierSlot {
    int kind;  // row of Modifiers
    int order;
    int theta, z;  // where its parameters and state begin
  };
  struct LawSlot {
    int joint, law;  // as in ParameterRef
    int kind;        // row of Laws
    int elements;
    int theta, z;
    std::vector<ModifierSlot> torque_modifiers;  // innermost first
    ModifierSlot backlash;                       // kind < 0: none
  };
  /// Slots of several joints with the same law and the same modifiers.
  struct Run {
    int kind, elements;
    std::size_t begin, size;
  };
  static constexpr std::size_t kLongestRun = 6;
  static bool is_alike(const LawSlot& a, const LawSlot& b);
  void sort_slots();
  struct RobotLawSlot {
    int kind = -1;  // row of RobotLaws; < 0: none
    RobotLawSize size;
    int theta = 0, z = 0;
  };
  template <class S>
  friend struct Kernels;
  friend void initialise_weights(const RobotFriction&, std::uint64_t, std::span<double>);
  friend std::vector<double> training_rates(const RobotFriction&, std::span<const double>);
  friend void set_signal_sizes(const RobotFriction&, const SignalSizes&, std::span<double>);

  std::vector<JointSpec> joints_;
  RobotLawSpec whole_;
  std::vector<ParameterRef> parameters_;
  std::vector<LawSlot> slots_;  // by law, then joint
  std::vector<Run> runs_;
  RobotLawSlot whole_slot_;
  std::vector<int> parameter_begin_{0}, state_begin_{0};
  int state_size_ = 0;
};

/// A friction with its parameters: what a scene injects and a model file holds.
struct Friction {
  RobotFriction model;
  std::vector<double> theta;  ///< (model.parameter_count())
};

/// The friction of one joint without a law of the whole robot.
Friction friction_of_joint(const Friction& friction, int joint);

/// Typical value of every parameter: theta of a middle-sized robot, the start of a search.
std::vector<double> default_theta(const RobotFriction& model);

/// Coulomb and viscous friction of a joint, from which a search starts.
struct FrictionGuess {
  double Fc = 1;  ///< Coulomb torque [N m]
  double Fv = 1;  ///< viscous coefficient [N m s/rad]
};

/// First guess of every parameter by its role, within bounds: typical values, of which torques and
/// torques per unit of something are scaled by guess.Fc over the typical Coulomb torque; viscous
/// coefficients are guess.Fv.
std::vector<double> start_from(const RobotFriction& model, const FrictionGuess& guess);

/// Index in theta of the first parameter of a joint with that role; -1 without one.
int find_parameter(const RobotFriction& model, int joint, Role role);

/// Index in theta of a parameter of a joint by name; -1 without one.
/// @param owner  law or modifier; empty: the first that has the symbol
int find_parameter(const RobotFriction& model, int joint, std::string_view owner,
                   std::string_view symbol);

/// Whether two models have the same parameter there: of the same joint, law, owner and symbol.
bool is_same(const ParameterRef& a, const ParameterRef& b);

/// Indices in theta of the shares (`Role::kShare`) of every law that has some: only their ratios
/// matter.
std::vector<std::vector<std::size_t>> shares(const RobotFriction& model);

/// Per parameter, the sum of its law's shares if it is one of them, else 1: theta divided by it
/// has shares that sum to one.
std::vector<double> sums_of_shares(const Friction& friction);

/// Writes random initial values of all network weights into theta and leaves the rest: the weights
/// of law l of joint j are drawn from (seed, j, l), independent of other joints; those of the law
/// of the whole robot from (seed, n), and may depend on its scales, which must be set before. An
/// untrained network hardly changes the torque.
void initialise_weights(const RobotFriction& model, std::uint64_t seed, std::span<double> theta);

/// Writes the scales of the law of the whole robot, if there is one, into theta, within their
/// bounds.
void set_signal_sizes(const RobotFriction& model, const SignalSizes& sizes,
                      std::span<double> theta);

/// Relative step length of every parameter in gradient training that starts at theta: 1, but a law
/// of the whole robot may scale those of its weights, or hold a weight by 0.
std::vector<double> training_rates(const RobotFriction& model, std::span<const double> theta);

/// How many parameters a fit may move: all that are neither Scale::kFixed nor held in training.
int free_parameter_count(const Friction& friction);

/// Whether a law of either table contains a network, whose weights need random initial values.
bool is_learned(std::string_view law);

/// Whether the law is one of the whole robot.
bool is_robot_law(std::string_view law);

/// Throws UserError when a parameter is outside its bounds; `where` starts the message.
void check_bounds(const Friction& friction, const std::vector<std::string>& joint_names,
                  std::string_view where);

/// One row of the table of all laws (or modifiers): the scene reader, the model file, the fits, the
/// templates and docs/friction_laws.md are made from it.
struct LawInfo {
  std::string_view name;
  std::string_view equation;
  std::string_view source;
  bool has_elements;  ///< a run-time number of elements or width (laws) or terms (modifiers)
  Claims claims;
  int most_elements;            ///< largest such number; 0 where has_elements is false
  std::string_view state_unit;  ///< of its states; empty: no states
  PlotLook look;                ///< of laws; unused for modifiers
  int most_latents = 0;         ///< largest number of states where it can be chosen; else 0
};
std::span<const LawInfo> law_table();
std::span<const LawInfo> modifier_table();
std::span<const LawInfo> robot_law_table();  ///< of the whole robot; without claims

/// Row of a law of the whole robot. @throws UserError when unknown
const LawInfo& find_robot_law(std::string_view name);

/// Parameters of one law or modifier by name, in the order of theta. @throws UserError when unknown
std::vector<ParameterInfo> parameters_of_law(std::string_view name, int elements);
std::vector<ParameterInfo> parameters_of_modifier(std::string_view name, int order);
std::vector<ParameterInfo> parameters_of_robot_law(std::string_view name, RobotLawSize size);

}  // namespace fricid::friction
