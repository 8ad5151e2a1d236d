#include "fricid/friction/robot_friction.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/laws.hpp"
#include "fricid/friction/robot_laws.hpp"

namespace fricid::friction {
namespace {

// Row of a name in law_table() or modifier_table().
int find_row(std::span<const LawInfo> table, std::string_view what, std::string_view name) {
  const auto row = std::ranges::find(table, name, &LawInfo::name);
  if (row != table.end()) return static_cast<int>(row - table.begin());
  std::string known;
  for (const LawInfo& info : table) known += (known.empty() ? "" : ", ") + std::string(info.name);
  throw UserError("unknown {} '{}'; known: {}", what, name, known);
}

int checked_elements(const LawInfo& info, std::string_view word, int n) {
  if (!info.has_elements) return 0;
  if (n < 1 || n > info.most_elements)
    throw UserError("{}: {} = {}, allowed 1 .. {}", info.name, word, n, info.most_elements);
  return n;
}

template <class List>
std::vector<ParameterInfo> parameters_of(int row, int elements) {
  std::vector<ParameterInfo> result;
  visit_entry<List>(row, elements, [&](const auto entry) {
    const auto p = entry.parameters();
    result.assign(p.begin(), p.end());
  });
  return result;
}

template <class List>
int state_size_of(int row, int elements) {
  int size = 0;
  visit_entry<List>(row, elements, [&](const auto entry) { size = entry.state_size(); });
  return size;
}

template <class List>
Reads reads_of(int row, int elements) {
  Reads reads;
  visit_entry<List>(row, elements, [&](const auto entry) { reads = decltype(entry)::kReads; });
  return reads;
}

}  // namespace

RobotFriction::RobotFriction(std::vector<JointSpec> joints, RobotLawSpec whole)
    : joints_(std::move(joints)), whole_(std::move(whole)) {
  const auto add_parameters = [this](int joint, int law, std::string_view owner,
                                     const std::vector<ParameterInfo>& infos) {
    const int begin = parameter_count();
    for (const ParameterInfo& info : infos)
      parameters_.push_back({joint, law, std::string(owner), std::string(info.symbol), info});
    return begin;
  };
  const auto add_state = [this](int size) {
    return std::exchange(state_size_, state_size_ + size);
  };

  for (int j = 0; j < joint_count(); ++j) {
    const auto& laws = joints_[static_cast<std::size_t>(j)].laws;
    for (int l = 0; l < static_cast<int>(laws.size()); ++l) {
      const LawSpec& spec = laws[static_cast<std::size_t>(l)];
      LawSlot slot{};
      slot.joint = j;
      slot.law = l;
      slot.kind = find_row(law_table(), "friction law", spec.law);
      slot.elements = checked_elements(law_table()[static_cast<std::size_t>(slot.kind)], "elements",
                                       spec.elements);
      slot.theta = add_parameters(j, l, spec.law, parameters_of<Laws>(slot.kind, slot.elements));
      slot.z = add_state(state_size_of<Laws>(slot.kind, slot.elements));
      slot.backlash.kind = -1;

      for (const ModifierSpec& modifier : spec.modifiers) {
        ModifierSlot m{};
        m.kind = find_row(modifier_table(), "friction modifier", modifier.name);
        if (std::ranges::count(spec.modifiers, modifier.name, &ModifierSpec::name) > 1)
          throw UserError("{}: modifier '{}' is given more than once", spec.law, modifier.name);
        m.order = checked_elements(modifier_table()[static_cast<std::size_t>(m.kind)], "order",
                                   modifier.order);
        m.theta = add_parameters(j, l, modifier.name, parameters_of<Modifiers>(m.kind, m.order));
        m.z = add_state(state_size_of<Modifiers>(m.kind, m.order));
        if (modifier.name == Backlash::kName)
          slot.backlash = m;
        else
          slot.torque_modifiers.push_back(m);
      }
      slots_.push_back(std::move(slot));
    }
    parameter_begin_.push_back(parameter_count());
    state_begin_.push_back(state_size_);
  }

  sort_slots();
  if (!has_whole()) return;
  whole_slot_.kind = find_row(robot_law_table(), "law of the whole robot", whole_.law);
  whole_slot_.size = {joint_count(), whole_.elements, whole_.latents};
  whole_slot_.theta = add_parameters(kWholeRobot, 0, whole_.law,
                                     parameters_of_robot_law(whole_.law, whole_slot_.size));
  visit_robot_law(whole_slot_.kind, whole_slot_.size,
                  [&](const auto law) { whole_slot_.z = add_state(law.state_size()); });
}

bool RobotFriction::is_alike(const LawSlot& a, const LawSlot& b) {
  const auto same = [](const ModifierSlot& x, const ModifierSlot& y) {
    return x.kind == y.kind && x.order == y.order;
  };
  return a.kind == b.kind && a.elements == b.elements && a.backlash.kind == b.backlash.kind &&
         std::ranges::equal(a.torque_modifiers, b.torque_modifiers, same);
}

/// The laws of a joint keep their order.
void RobotFriction::sort_slots() {
  std::ranges::sort(slots_, {},
                    [](const LawSlot& slot) { return std::pair(slot.law, slot.joint); });
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const LawSlot& slot = slots_[i];
    if (runs_.empty() || runs_.back().size == kLongestRun ||
        !is_alike(slots_[runs_.back().begin], slot))
      runs_.push_back({slot.kind, slot.elements, i, 0});
    ++runs_.back().size;
  }
}

int RobotFriction::parameter_begin(int joint) const {
  return parameter_begin_[static_cast<std::size_t>(joint)];
}

int RobotFriction::state_begin(int joint) const {
  return state_begin_[static_cast<std::size_t>(joint)];
}

bool RobotFriction::reads_load() const {
  return std::ranges::any_of(slots_, [](const LawSlot& slot) {
    return reads_of<Laws>(slot.kind, slot.elements).load ||
           std::ranges::any_of(slot.torque_modifiers, [](const ModifierSlot& m) {
             return reads_of<Modifiers>(m.kind, m.order).load;
           });
  });
}

bool RobotFriction::reads_temperature() const {
  return std::ranges::any_of(slots_, [](const LawSlot& slot) {
    return reads_of<Laws>(slot.kind, slot.elements).temperature ||
           std::ranges::any_of(slot.torque_modifiers, [](const ModifierSlot& m) {
             return reads_of<Modifiers>(m.kind, m.order).temperature;
           });
  });
}

std::vector<double> default_theta(const RobotFriction& model) {
  std::vector<double> theta;
  for (const ParameterRef& p : model.parameters()) theta.push_back(p.info.typical);
  return theta;
}

std::vector<double> start_from(const RobotFriction& model, const FrictionGuess& guess) {
  const auto& parameters = model.parameters();
  const auto first = std::ranges::find_if(parameters, [](const ParameterRef& p) {
    return p.info.role == Role::kCoulomb || p.info.role == Role::kNetworkTorque;
  });
  const double size = first == parameters.end() ? 1 : guess.Fc / first->info.typical;
  std::vector<double> theta;
  for (const ParameterRef& p : parameters) {
    const double value = p.info.role == Role::kViscous ? guess.Fv
                         : is_torque(p.info.role)      ? p.info.typical * size
                                                       : p.info.typical;
    theta.push_back(std::clamp(value, p.info.lower, p.info.upper));
  }
  return theta;
}

namespace {

template <class Predicate>
int find_index(const std::vector<ParameterRef>& parameters, Predicate is_it) {
  const auto found = std::ranges::find_if(parameters, is_it);
  return found == parameters.end() ? -1 : static_cast<int>(found - parameters.begin());
}

}  // namespace

int find_parameter(const RobotFriction& model, int joint, Role role) {
  return find_index(model.parameters(),
                    [&](const ParameterRef& p) { return p.joint == joint && p.info.role == role; });
}

int find_parameter(const RobotFriction& model, int joint, std::string_view owner,
                   std::string_view symbol) {
  return find_index(model.parameters(), [&](const ParameterRef& p) {
    return p.joint == joint && (owner.empty() || p.owner == owner) && p.symbol == symbol;
  });
}

bool is_same(const ParameterRef& a, const ParameterRef& b) {
  return a.joint == b.joint && a.law == b.law && a.owner == b.owner && a.symbol == b.symbol;
}

std::vector<std::vector<std::size_t>> shares(const RobotFriction& model) {
  std::vector<std::vector<std::size_t>> laws;
  const std::vector<ParameterRef>& all = model.parameters();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].info.role != Role::kShare) continue;
    const bool begins = laws.empty() || all[laws.back().front()].joint != all[i].joint ||
                        all[laws.back().front()].law != all[i].law;
    if (begins) laws.emplace_back();
    laws.back().push_back(i);
  }
  return laws;
}

std::vector<double> sums_of_shares(const Friction& friction) {
  std::vector<double> sums(friction.theta.size(), 1);
  for (const std::vector<std::size_t>& law : shares(friction.model)) {
    double sum = 0;
    for (const std::size_t i : law) sum += friction.theta[i];
    for (const std::size_t i : law) sums[i] = sum;
  }
  return sums;
}

void initialise_weights(const RobotFriction& model, std::uint64_t seed, std::span<double> theta) {
  for (const auto& slot : model.slots_) {
    Rng rng(seed,
            static_cast<std::uint64_t>(slot.joint) << 32 | static_cast<std::uint64_t>(slot.law));
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto entry) {
      if constexpr (LearnedLaw<std::remove_cvref_t<decltype(entry)>>)
        entry.initialise(theta.data() + slot.theta, rng);
    });
  }
  const auto& whole = model.whole_slot_;
  if (whole.kind < 0) return;
  Rng rng(seed, static_cast<std::uint64_t>(whole.size.joints) << 32);
  visit_robot_law(whole.kind, whole.size,
                  [&](const auto net) { net.initialise(theta.data() + whole.theta, rng); });
}

void set_signal_sizes(const RobotFriction& model, const SignalSizes& sizes,
                      std::span<double> theta) {
  const auto& whole = model.whole_slot_;
  if (whole.kind < 0) return;
  const SignalScales scales(whole.size.joints);
  const auto set = [&](int index, double value) {
    const auto p = static_cast<std::size_t>(whole.theta + index);
    const ParameterInfo& info = model.parameters()[p].info;
    theta[p] = std::clamp(value, info.lower, info.upper);
  };
  for (int j = 0; j < whole.size.joints; ++j) {
    const auto i = static_cast<std::size_t>(j);
    set(scales.q_mean(j), sizes.q_mean[i]);
    set(scales.q_sd(j), sizes.q_sd[i]);
    set(scales.v_sd(j), sizes.v_sd[i]);
    set(scales.tau_sd(j), sizes.tau_sd[i]);
  }
}

std::vector<double> training_rates(const RobotFriction& model, std::span<const double> theta) {
  std::vector<double> rates(theta.size(), 1);
  const auto& whole = model.whole_slot_;
  if (whole.kind < 0) return rates;
  visit_robot_law(whole.kind, whole.size, [&](const auto law) {
    if constexpr (requires { law.training_rates(theta.data(), rates.data()); })
      law.training_rates(theta.data() + whole.theta, rates.data() + whole.theta);
  });
  return rates;
}

Friction friction_of_joint(const Friction& friction, int joint) {
  const RobotFriction& model = friction.model;
  const double* theta = friction.theta.data();
  return {RobotFriction({model.joints()[static_cast<std::size_t>(joint)]}),
          {theta + model.parameter_begin(joint), theta + model.parameter_begin(joint + 1)}};
}

int free_parameter_count(const Friction& friction) {
  const std::vector<double> rates = training_rates(friction.model, friction.theta);
  int count = 0;
  for (std::size_t p = 0; p < rates.size(); ++p)
    count += friction.model.parameters()[p].info.scale != Scale::kFixed && rates[p] > 0;
  return count;
}

bool is_robot_law(std::string_view law) {
  return std::ranges::count(robot_law_table(), law, &LawInfo::name) > 0;
}

bool is_learned(std::string_view law) {
  if (is_robot_law(law)) return true;
  bool learned = false;
  visit_entry<Laws>(find_row(law_table(), "friction law", law), 1, [&](const auto entry) {
    learned = LearnedLaw<std::remove_cvref_t<decltype(entry)>>;
  });
  return learned;
}

void check_bounds(const Friction& friction, const std::vector<std::string>& joint_names,
                  std::string_view where) {
  const auto& parameters = friction.model.parameters();
  if (friction.theta.size() != parameters.size())
    throw UserError("{}: friction has {} parameters, expected {}", where, friction.theta.size(),
                    parameters.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterRef& p = parameters[i];
    const double value = friction.theta[i];
    if (value >= p.info.lower && value <= p.info.upper) continue;
    const std::string owner = p.joint == kWholeRobot
                                  ? "whole robot"
                                  : "joint " + joint_names.at(static_cast<std::size_t>(p.joint));
    throw UserError("{}: {}: {}.{} = {} {}, allowed {} .. {}", where, owner, p.owner, p.symbol,
                    value, p.info.unit, p.info.lower, p.info.upper);
  }
}

namespace {

template <class Entry>
constexpr std::string_view state_unit() {
  if constexpr (requires { Entry::kStateUnit; }) return Entry::kStateUnit;
  return "";
}

template <class Entry>
constexpr PlotLook look() {
  if constexpr (requires { Entry::kLook; }) return Entry::kLook;
  return {};
}

template <class Entry>
constexpr LawInfo row() {
  return {Entry::kName,   Entry::kEquation,     Entry::kSource,      Entry::kMostElements > 0,
          Entry::kClaims, Entry::kMostElements, state_unit<Entry>(), look<Entry>()};
}
template <class... Entries>
constexpr auto rows(std::tuple<Entries...>*) {
  return std::array<LawInfo, sizeof...(Entries)>{row<Entries>()...};
}
constexpr auto kLawTable = rows(static_cast<Laws*>(nullptr));
constexpr auto kModifierTable = rows(static_cast<Modifiers*>(nullptr));

template <class Law>
constexpr int most_latents() {
  if constexpr (requires { Law::kMostLatents; }) return Law::kMostLatents;
  return 0;
}

template <class Law>
constexpr LawInfo robot_row() {
  return {Law::kName,
          Law::kEquation,
          Law::kSource,
          true,
          Claims{false, false, false, false, false},
          Law::kMostElements,
          state_unit<Law>(),
          Law::kLook,
          most_latents<Law>()};
}
template <class... L>
constexpr auto robot_rows(std::tuple<L...>*) {
  return std::array<LawInfo, sizeof...(L)>{robot_row<L>()...};
}
constexpr auto kRobotLawTable = robot_rows(static_cast<RobotLaws*>(nullptr));

}  // namespace

std::span<const LawInfo> law_table() { return kLawTable; }
std::span<const LawInfo> modifier_table() { return kModifierTable; }
std::span<const LawInfo> robot_law_table() { return kRobotLawTable; }

const LawInfo& find_robot_law(std::string_view name) {
  return kRobotLawTable[static_cast<std::size_t>(
      find_row(robot_law_table(), "law of the whole robot", name))];
}

std::vector<ParameterInfo> parameters_of_law(std::string_view name, int elements) {
  const int row = find_row(law_table(), "friction law", name);
  return parameters_of<Laws>(
      row, checked_elements(law_table()[static_cast<std::size_t>(row)], "elements", elements));
}

std::vector<ParameterInfo> parameters_of_modifier(std::string_view name, int order) {
  const int row = find_row(modifier_table(), "friction modifier", name);
  return parameters_of<Modifiers>(
      row, checked_elements(modifier_table()[static_cast<std::size_t>(row)], "order", order));
}

std::vector<ParameterInfo> parameters_of_robot_law(std::string_view name, RobotLawSize size) {
  const LawInfo& info = find_robot_law(name);
  if (size.joints < 1 || size.joints > kMostJoints)
    throw UserError("{}: {} joints, allowed 1 .. {}", name, size.joints, kMostJoints);
  if (info.most_latents > 0 && (size.latents < 1 || size.latents > info.most_latents))
    throw UserError("{}: n_z = {}, allowed 1 .. {}", name, size.latents, info.most_latents);
  size.elements = checked_elements(info, "elements", size.elements);
  std::vector<ParameterInfo> parameters;
  visit_robot_law(static_cast<int>(&info - kRobotLawTable.data()), size,
                  [&](const auto law) { parameters = law.parameters(); });
  return parameters;
}

}  // namespace fricid::friction
