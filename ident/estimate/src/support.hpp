// Small things that the sources of estimate share.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <span>
#include <vector>

#include "fricid/data/scene.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::estimate {

/// The modifiers that a scene asks for, each of the first order.
inline std::vector<friction::ModifierSpec> modifiers_of(const data::ModelConfig& config) {
  std::vector<friction::ModifierSpec> modifiers;
  for (const std::string& name : config.modifiers) modifiers.push_back({name, 1});
  return modifiers;
}

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
