// Cables have a search of their own: a spring that begins stiff and slipping never becomes soft.
#pragma once

#include "fricid/estimate/torque/arm_torque_fit.hpp"

namespace fricid::estimate {

/// A spring that follows the joint over `length` before it slips, F = K clamp(q - q0, +-length).
struct Cable {
  double length = 0;  ///< [rad], sliding [m]
  double K = 0;       ///< [N m/rad], sliding [N/m]
  double gain = 0;    ///< relative rise of the mean square without it [1]
};

/// The cable that explains most of what an arm leaves of the torque of joint j, by linear
/// regression on the motion z of a spring of each length of a grid (.1 to 3.2 rad; sliding a tenth
/// in m), less what the rigid body can explain of z.
Cable strongest_cable(const ArmTorqueData& data, const Arm& arm, int j);

}  // namespace fricid::estimate
