// Small things that the sources of estimate share.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <span>
#include <vector>

#include "fricid/estimate/options/model.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::estimate {

/// Modifiers by name, each of the first order.
inline std::vector<friction::ModifierSpec> modifiers_of(const std::vector<std::string>& names) {
  std::vector<friction::ModifierSpec> modifiers;
  for (const std::string& name : names) modifiers.push_back({name, 1});
  return modifiers;
}

/// The friction of one joint that a scene asks for: a sum, a law of the table or its short name.
/// @throws UserError on a name that is no law
friction::JointSpec joint_spec_of(const ModelOptions& options);

inline double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

inline std::span<const double> view(const Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}
inline std::span<double> view(Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

}  // namespace fricid::estimate
