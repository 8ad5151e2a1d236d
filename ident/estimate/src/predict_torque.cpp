#include "fricid/estimate/predict_torque.hpp"

#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/filter.hpp"
#include "fricid/system/driven_friction.hpp"
#include "fricid/system/initial_state.hpp"

namespace fricid::estimate {

RowMatrix predict_torque(const Arm& arm, const signals::Recording& measured, double cutoff_hz) {
  const std::vector<double> z0 =
      initial_friction_state(arm, measured.dt, measured.wide.q, measured.wide.v,
                             measured.filtered_tau, measured.temperature);
  const signals::ZeroPhaseButterworth low_pass(cutoff_hz, 1 / measured.dt);
  const RowMatrix rigid = rigid_body_torque(arm.robot, arm.robot.pi, measured);
  return rigid + drive_under_own_load(arm.friction, measured.dt, measured.wide.q, measured.wide.v,
                                      rigid, measured.temperature, z0,
                                      [&](RowMatrix& tau_f) { low_pass.apply(tau_f); })
                     .tau_f;
}

}  // namespace fricid::estimate
