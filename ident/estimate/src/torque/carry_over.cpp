#include "fricid/estimate/torque/carry_over.hpp"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <utility>

#include <fmt/format.h>

#include "fricid/friction/laws/gms.hpp"
#include "fricid/friction/laws/load_dependent.hpp"
#include "fricid/friction/laws/maxwell_slip.hpp"
#include "fricid/friction/laws/stribeck_peak.hpp"
#include "friction/ripple_search.hpp"

namespace fricid::estimate {
namespace {

// A Stribeck curve in the memory beside another Stribeck torque: its speed over that of the other
// at a start, and what it is where it says nothing.
constexpr double kNarrower = 0.3, kWide = 0.5;  // vs over that of the other
constexpr double kDead = 1.05, kRisen = 1.2;    // Fs over Fc
constexpr double kSmoother = 4;                 // vs and v0 of a start over those of a first one

/// A parameter of a joint's first law; nothing: it has none.
double* of_first_law(Arm& arm, int joint, friction::Role role) {
  const int p = friction::find_parameter(arm.friction.model, joint, role);
  const bool is_first =
      p >= 0 && arm.friction.model.parameters()[static_cast<std::size_t>(p)].law == 0;
  return is_first ? &arm.friction.theta[static_cast<std::size_t>(p)] : nullptr;
}

/// Index in theta of the growth of the memory's friction with load, whatever the load is; -1: there
/// is none.
int load_growth(const friction::RobotFriction& model, int j) {
  for (const char* load : {"load", "gear_load"})
    if (const int mu = friction::find_parameter(model, j, load, "mu");
        mu >= 0 && model.parameters()[static_cast<std::size_t>(mu)].law == 0)
      return mu;
  return -1;
}

/// A spring of a bank: its share of the force, its stiffness, and where they are in theta.
struct BankSpring {
  double alpha, k;
  std::size_t at_alpha, at_k;
  double length() const { return alpha / k; }  // over the force of the bank
};
std::vector<BankSpring> bank_of(const friction::Friction& friction, int joint) {
  std::vector<BankSpring> springs;
  const auto find = [&](const char* symbol) {
    return friction::find_parameter(friction.model, joint, friction::Gms::kName,
                                    fmt::format("{}{}", symbol, springs.size() + 1));
  };
  for (int k = find("k"); k >= 0; k = find("k")) {
    const auto at_k = static_cast<std::size_t>(k),
               at_alpha = static_cast<std::size_t>(find("alpha"));
    springs.push_back({friction.theta[at_alpha], friction.theta[at_k], at_alpha, at_k});
  }
  return springs;
}

/// Springs in the order of their lengths, of which neighbours are joined until so many are left:
/// always the two that change the curve of force over travel least (Ward's criterion on the
/// logarithm of the length, weighed by force).
std::vector<BankSpring> joined_springs(std::vector<BankSpring> springs, std::size_t left) {
  std::ranges::sort(springs, {}, &BankSpring::length);
  while (springs.size() > left) {
    const auto cost = [&](std::size_t i) {
      const BankSpring &a = springs[i], &b = springs[i + 1];
      const double ratio = std::log(b.length() / a.length());
      return a.alpha * b.alpha / (a.alpha + b.alpha) * ratio * ratio;
    };
    const auto pairs = std::views::iota(std::size_t{0}, springs.size() - 1);
    const std::size_t least = *std::ranges::min_element(pairs, {}, cost);
    springs[least].alpha += springs[least + 1].alpha;
    springs[least].k += springs[least + 1].k;
    springs.erase(springs.begin() + static_cast<std::ptrdiff_t>(least) + 1);
  }
  return springs;
}

/// Parameter `wanted` of `to` becomes `given` of `from`; -1: there is none.
void take_over(const Arm& from, int given, Arm& to, int wanted) {
  if (given >= 0 && wanted >= 0)
    to.friction.theta[static_cast<std::size_t>(wanted)] =
        from.friction.theta[static_cast<std::size_t>(given)];
}

/// The Stribeck curve of a joint's memory and the Stribeck torque beside it, in theta.
struct TwoCurves {
  double &Fc, &Fs, &vs, &Ts_beside, &vs_beside;
  const friction::ParameterInfo& of_vs;
};
std::optional<TwoCurves> two_curves(Arm& arm, int joint) {
  using enum friction::Role;
  const friction::RobotFriction& model = arm.friction.model;
  const auto at = [&](int p) -> double& { return arm.friction.theta[static_cast<std::size_t>(p)]; };
  const auto beside = [&](const char* symbol) {
    return friction::find_parameter(model, joint, friction::StribeckPeak::kName, symbol);
  };
  if (beside("Ts") < 0) return std::nullopt;
  const int vs = friction::find_parameter(model, joint, kStribeckVelocity);
  return TwoCurves{at(friction::find_parameter(model, joint, kCoulomb)),
                   at(friction::find_parameter(model, joint, kStatic)),
                   at(vs),
                   at(beside("Ts")),
                   at(beside("vs")),
                   model.parameters()[static_cast<std::size_t>(vs)].info};
}

}  // namespace

int linear_viscous(const friction::RobotFriction& model, int joint) {
  const int beside = friction::find_parameter(model, joint, "viscous", "Fv");
  return beside >= 0 ? beside : friction::find_parameter(model, joint, friction::Role::kViscous);
}

std::optional<SpringIndices> single_spring(const friction::RobotFriction& friction, int joint) {
  const auto index = [&](const char* symbol) {
    return friction::find_parameter(friction, joint, friction::MaxwellSlip::kName, symbol);
  };
  if (index("K1") < 0 || index("K2") >= 0) return {};
  return SpringIndices{static_cast<std::size_t>(index("K1")),
                       static_cast<std::size_t>(index("W1"))};
}

bool start_cables(std::span<const Cable> cables, friction::Friction& friction) {
  bool any = false;
  for (std::size_t j = 0; j < cables.size(); ++j) {
    const std::optional<SpringIndices> at = single_spring(friction.model, static_cast<int>(j));
    if (cables[j].K == 0 || !at) continue;
    friction.theta[at->K] = cables[j].K;
    friction.theta[at->W] = cables[j].K * cables[j].length;
    any = true;
  }
  return any;
}

std::optional<Arm> with_springs_in_place(Arm arm) {
  using enum friction::Role;
  bool any = false;
  for (int j = 0; j < arm.robot.n(); ++j) {
    double *const Fc = of_first_law(arm, j, kCoulomb), *const Fs = of_first_law(arm, j, kStatic),
                  *const sigma0 = of_first_law(arm, j, kStiffness);
    const std::optional<SpringIndices> spring = single_spring(arm.friction.model, j);
    if (!spring || !Fc || !sigma0) continue;
    double &K = arm.friction.theta[spring->K], &W = arm.friction.theta[spring->W];
    if (K <= *sigma0) continue;
    if (Fs) *Fs = kRisen * W;
    std::swap(K, *sigma0);
    std::swap(W, *Fc);
    any = true;
  }
  return any ? std::optional<Arm>(std::move(arm)) : std::nullopt;
}

Arm with_stribeck_curves(const Arm& from, Arm to) {
  using enum friction::Role;
  Arm given = from;
  for (int j = 0; j < to.robot.n(); ++j) {
    if (const std::optional<TwoCurves> curves = two_curves(given, j);
        curves && !two_curves(to, j)) {
      curves->Fs = curves->Fc + curves->Ts_beside;
      curves->vs = curves->vs_beside;
    }
    for (const friction::Role role : {kCoulomb, kStatic, kStribeckVelocity})
      take_over(given, find_parameter(given.friction.model, j, role), to,
                find_parameter(to.friction.model, j, role));
  }
  return to;
}

Arm with_curves_without_memory(const Arm& from, Arm to) {
  using enum friction::Role;
  Arm carried = with_stribeck_curves(from, to);
  for (int j = 0; j < to.robot.n(); ++j) {
    const auto at = [&](Arm& arm, friction::Role role) -> double& {
      return arm.friction
          .theta[static_cast<std::size_t>(find_parameter(arm.friction.model, j, role))];
    };
    const double Fc = at(carried, kCoulomb);
    if (find_parameter(to.friction.model, j, kStiffness) >= 0 || at(carried, kStatic) > Fc)
      continue;
    at(carried, kStatic) = kDead * Fc;
    at(carried, kStribeckVelocity) = at(to, kStribeckVelocity);
  }
  return carried;
}

Arm with_springs_joined(const Arm& from, Arm to) {
  for (int j = 0; j < to.robot.n(); ++j) {
    const std::vector<BankSpring> wanted = bank_of(to.friction, j),
                                  given = bank_of(from.friction, j);
    if (wanted.size() >= given.size() || wanted.empty()) continue;
    const std::vector<BankSpring> joined = joined_springs(given, wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      to.friction.theta[wanted[i].at_alpha] = joined[i].alpha;
      to.friction.theta[wanted[i].at_k] = joined[i].k;
    }
  }
  return to;
}

Arm with_load_growth(const Arm& from, Arm to) {
  for (int j = 0; j < to.robot.n(); ++j)
    take_over(from, load_growth(from.friction.model, j), to, load_growth(to.friction.model, j));
  return to;
}

Arm with_parts_handed_over(const Arm& from, Arm to) {
  constexpr double kLinear = 0.1;  // p from 1
  for (int j = 0; j < to.robot.n(); ++j) {
    const auto find = [j](const Arm& arm, std::string_view law, std::string_view symbol) {
      return friction::find_parameter(arm.friction.model, j, law, symbol);
    };
    const auto value = [](auto& arm, int p) -> auto& {
      return arm.friction.theta[static_cast<std::size_t>(p)];
    };
    const int motor = find(from, friction::LoadDependent::kName, "mu_m"),
              mu = load_growth(to.friction.model, j);
    if (motor >= 0 && mu >= 0 && find(to, friction::LoadDependent::kName, "mu_m") < 0) {
      const int back = find(from, friction::LoadDependent::kName, "mu_b"),
                Fc = find_parameter(to.friction.model, j, friction::Role::kCoulomb);
      const friction::ParameterInfo& info =
          to.friction.model.parameters()[static_cast<std::size_t>(mu)].info;
      const double mean = (value(from, motor) + value(from, back)) / 2;
      value(to, mu) = std::clamp(value(to, mu) + mean / value(to, Fc), info.lower, info.upper);
    }
    const int Fv = find(from, "viscous", "Fv"), p = find(to, "viscous_power", "p");
    if (Fv >= 0 && p >= 0 && find(to, "viscous", "Fv") < 0 &&
        std::abs(value(to, p) - 1) < kLinear) {
      value(to, find(to, "viscous_power", "c")) += value(from, Fv);
      value(to, p) = 1;
    }
  }
  return to;
}

Arm with_viscous_friction(const Arm& from, Arm to) {
  for (int j = 0; j < to.robot.n(); ++j)
    take_over(from, linear_viscous(from.friction.model, j), to,
              linear_viscous(to.friction.model, j));
  return to;
}

std::optional<Arm> with_rising_curves(Arm arm, Arm unfitted) {
  using enum friction::Role;
  bool any = false;
  for (int j = 0; j < arm.robot.n(); ++j) {
    double *const Fc = of_first_law(arm, j, kCoulomb), *const Fs = of_first_law(arm, j, kStatic),
                  *const vs = of_first_law(arm, j, kStribeckVelocity),
                  *const v0 = of_first_law(arm, j, kSmoothingSpeed);
    if (!Fc || !Fs || !vs || !v0 || *Fs >= *Fc) continue;
    *Fs = kRisen * *Fc;
    *vs = kSmoother * *of_first_law(unfitted, j, kStribeckVelocity);
    *v0 *= kSmoother;
    any = true;
  }
  return any ? std::optional<Arm>(std::move(arm)) : std::nullopt;
}

Arm with_stribeck_beside(Arm arm) {
  for (int j = 0; j < arm.robot.n(); ++j)
    if (const std::optional<TwoCurves> curves = two_curves(arm, j)) {
      curves->Ts_beside = std::max(curves->Ts_beside, curves->Fs - curves->Fc);
      curves->vs_beside = curves->vs;
      curves->Fs = curves->Fc;
    }
  return arm;
}

std::optional<Arm> with_curves_in_memories(Arm arm) {
  bool any = false;
  for (int j = 0; j < arm.robot.n(); ++j)
    if (const std::optional<TwoCurves> curves = two_curves(arm, j);
        curves && (curves->Fs < kDead * curves->Fc || curves->vs > kWide * curves->vs_beside)) {
      any = true;
      const friction::ParameterInfo& vs = curves->of_vs;
      curves->vs =
          std::clamp(kNarrower * curves->vs_beside, vs.lower, std::max(vs.lower, vs.typical));
      curves->Fs = std::max(curves->Fs, kRisen * curves->Fc);
    }
  return any ? std::optional<Arm>(std::move(arm)) : std::nullopt;
}

Arm with_open_gaps(Arm arm, double half) {
  for (int j = 0; j < arm.robot.n(); ++j)
    if (const int b = friction::find_parameter(arm.friction.model, j, friction::Role::kGap);
        b >= 0) {
      double& gap = arm.friction.theta[static_cast<std::size_t>(b)];
      gap = std::max(gap,
                     half * dynamics::travel_scale(arm.robot.joints[static_cast<std::size_t>(j)]));
    }
  return arm;
}

Arm with_strongest_waves_first(Arm arm) {
  std::vector<double>& theta = arm.friction.theta;
  const std::vector<std::size_t> terms = ripple_terms(arm.friction.model);
  const auto joint_of = [&](std::size_t term) {
    return arm.friction.model.parameters()[term].joint;
  };
  for (std::size_t i = 0; i < terms.size(); ++i)
    for (std::size_t k = i; k > 0 && joint_of(terms[k]) == joint_of(terms[k - 1]) &&
                            std::abs(theta[ripple_amplitude(terms[k])]) >
                                std::abs(theta[ripple_amplitude(terms[k - 1])]);
         --k)
      std::ranges::swap_ranges(std::span(theta).subspan(terms[k], kRippleSize),
                               std::span(theta).subspan(terms[k - 1], kRippleSize));
  return arm;
}

Arm joined(const std::vector<const Arm*>& of_joint, const Arm& first) {
  std::vector<friction::JointSpec> specs;
  Arm out = first;
  out.friction.theta.clear();
  for (std::size_t j = 0; j < of_joint.size(); ++j) {
    const friction::Friction& from = of_joint[j]->friction;
    const int joint = static_cast<int>(j);
    specs.push_back(from.model.joints()[j]);
    out.friction.theta.insert(out.friction.theta.end(),
                              from.theta.begin() + from.model.parameter_begin(joint),
                              from.theta.begin() + from.model.parameter_begin(joint + 1));
  }
  out.friction.model = friction::RobotFriction(std::move(specs));
  return out;
}

Arm carried_over(const Arm& from, Arm to) {
  // a law of the sum keeps its parameters wherever it stands; modifiers are told apart by their law
  const auto is_own = [](const Arm& arm, const friction::ParameterRef& p) {
    return p.owner == arm.friction.model.joints()[static_cast<std::size_t>(p.joint)]
                          .laws[static_cast<std::size_t>(p.law)]
                          .law;
  };
  const auto is_carried = [&](const friction::ParameterRef& a, const friction::ParameterRef& b) {
    return friction::is_same(a, b) || (a.joint == b.joint && a.owner == b.owner &&
                                       a.symbol == b.symbol && is_own(from, a) && is_own(to, b));
  };
  to.robot.pi = from.robot.pi;
  const auto& given = from.friction.model.parameters();
  const auto& wanted = to.friction.model.parameters();
  for (std::size_t i = 0; i < wanted.size(); ++i)
    for (std::size_t k = 0; k < given.size(); ++k)
      if (is_carried(given[k], wanted[i])) to.friction.theta[i] = from.friction.theta[k];
  return to;
}

}  // namespace fricid::estimate
