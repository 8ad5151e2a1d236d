// Torque that goes with a joint's own position, as of cogging, which no law of friction has.
#pragma once

#include "fricid/estimate/torque/arm_torque_data.hpp"

namespace fricid::estimate {

/// A sin(n q) + B cos(n q) in the torque of a joint.
struct PositionWave {
  double n = 0;  ///< periods per 2 pi (sliding: per 2 pi m)
  double share =
      0;  ///< of the variance of what the arm leaves on rows that it is not taken from [1]
};

/// The wave, of those that repeat within the joint's travel and of up to 30 periods, that explains
/// most of what an arm leaves of the torque of joint j on the training rows; by linear regression,
/// with the share that it then explains on the held-out rows.
/// @return share 0 where there is none
PositionWave strongest_wave(const ArmTorqueData& training, const ArmTorqueData& held_out,
                            const Arm& arm, int j);

}  // namespace fricid::estimate
