// Known torques that are linear in one parameter.
#pragma once

#include <span>

#include "fricid/base/math.hpp"
#include "fricid/dynamics/workspace.hpp"
#include "motors.hpp"

namespace fricid::dynamics::detail {

template <class S>
struct LinearTorques {
  using Real = typename ConstantOf<S>::type;

  static size_t joint(const LinearTorque& torque) { return static_cast<size_t>(torque.joint); }

  /// phi(q) and its derivative.
  static S shape(const LinearTorque& torque, const S& q) {
    switch (torque.shape) {
      case LinearTorque::Shape::kConstant:
        return S(1);
      case LinearTorque::Shape::kSin:
        return sincos(S(Real(torque.k)) * q).sin;
      case LinearTorque::Shape::kCos:
        return sincos(S(Real(torque.k)) * q).cos;
      case LinearTorque::Shape::kLinear:
        return q;
    }
    return S(0);
  }

  static S slope(const LinearTorque& torque, const S& q) {
    const S k(Real(torque.k));
    switch (torque.shape) {
      case LinearTorque::Shape::kConstant:
        return S(0);
      case LinearTorque::Shape::kSin:
        return k * sincos(k * q).cos;
      case LinearTorque::Shape::kCos:
        return -k * sincos(k * q).sin;
      case LinearTorque::Shape::kLinear:
        return S(1);
    }
    return S(0);
  }

  /// @param q    at the joints
  /// @param tau  at the motors
  static void add(const RobotModel& model, const Workspace<S>& ws, std::span<const S> pi,
                  std::span<const S> q, std::span<S> tau) {
    for (size_t k = 0; k < model.linear_torques.size(); ++k) {
      const LinearTorque& torque = model.linear_torques[k];
      const size_t i = joint(torque);
      Motors<S>::add(ws, i, pi[static_cast<size_t>(model.linear_begin()) + k] * shape(torque, q[i]),
                     tau);
    }
  }
};

}  // namespace fricid::dynamics::detail
