// Joints whose friction has the same laws, sizes and modifiers differ in their parameters alone.
#pragma once

#include <algorithm>

#include "fricid/friction/robot_friction.hpp"

namespace fricid::friction {

/// Whether theta and z of two joints have the same layout and meaning.
inline bool same_structure(const JointSpec& a, const JointSpec& b) {
  return std::ranges::equal(a.laws, b.laws, [](const LawSpec& x, const LawSpec& y) {
    return x.law == y.law && x.elements == y.elements &&
           std::ranges::equal(x.modifiers, y.modifiers, [](const auto& m, const auto& n) {
             return m.name == n.name && m.order == n.order;
           });
  });
}

}  // namespace fricid::friction
