// What a fitted arm leaves of the torque of a joint, and how much of that goes with something that
// no law of friction has.
#pragma once

#include "fricid/estimate/torque/arm_torque_data.hpp"

namespace fricid::estimate {

/// A sin(n q) + B cos(n q) in the torque of a joint, as of cogging.
struct PositionWave {
  double n = 0;  ///< periods per turn, of a joint that slides per 2 pi m
  /// Of the variance of what the arm leaves on rows that it is not taken from [1].
  double share = 0;
  bool slides = false;
};

/// The wave, of 1 to 400 periods over the joint's travel, that explains most of what an arm leaves
/// of the torque of joint j on the training rows; by linear regression, with the share that it then
/// explains on the held-out rows.
/// @return share 0 where there is none
PositionWave strongest_wave(const ArmTorqueData& training, const ArmTorqueData& held_out,
                            const Arm& arm, int j);

/// What explains more of the torque that an arm leaves of a joint: friction of the speed alone that
/// grows with the load. Relative rises of the mean square without it [1].
struct LoadedSpeed {
  double viscous = 0;   ///< by c v |l|
  double stribeck = 0;  ///< by c exp(-(v/vs)^2) |l|, against the motion
};

/// By linear regression on the training rows beside a constant, Coulomb and viscous friction, the
/// Stribeck torque itself, and friction that grows with the load l, the torque that the arm
/// predicts, and with its square; of a grid of vs (.01 to .64 rad/s, sliding a tenth in m/s) the
/// best.
LoadedSpeed loaded_speed(const ArmTorqueData& training, const Arm& arm, int j);

/// Friction that is larger at one place of a joint's travel, as of a bent shaft or a worn tooth.
struct TightSpot {
  double at = 0;     ///< its place [rad or m]
  double more = 0;   ///< friction there beside what the arm has [N m or N]
  double share = 0;  ///< as of a `PositionWave`
  bool slides = false;
};

/// What an arm leaves of the torque of joint j against the motion, in 48 stretches of the travel:
/// the mean of each on the training rows, with the share that these explain on the held-out rows.
TightSpot tightest_spot(const ArmTorqueData& training, const ArmTorqueData& held_out,
                        const Arm& arm, int j);

/// B (tau / largest)^3 in the torque of a joint, tau being what the arm predicts: as of a torque
/// constant that falls with the current.
struct TorqueBend {
  double at_largest = 0;  ///< B over the largest torque [1]
  double share = 0;       ///< as of a `PositionWave`
};

/// The bend, beside a constant, a factor, and friction in the torque and its square, which changes
/// its sign with the speed; found and judged as the
/// `strongest_wave`, by what it gains over these.
TorqueBend bend_of(const ArmTorqueData& training, const ArmTorqueData& held_out, const Arm& arm,
                   int j);

}  // namespace fricid::estimate
