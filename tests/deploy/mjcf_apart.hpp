// How far the MJCF of a friction and its law come apart in MuJoCo.
#pragma once

#include <mujoco/mujoco.h>

#include "fricid/data/model_file.hpp"

namespace fricid::deploy::test {

/// Two flywheels of robot_with() for 4 s under torques that reverse.
struct Drive {
  double step = 1e-3;  ///< of MuJoCo [s]
  int substeps = 1;    ///< of the law, in a step of MuJoCo
  double share = 1;    ///< of torques that grow from 2 to 10 N m
  mjtIntegrator integrator = mjINT_EULER;
};

/// RMS differences [rad] of positions from those with the law.
struct Apart {
  double rms = 0;        ///< in MuJoCo
  double law_rms = 0;    ///< with the law in steps as long as MuJoCo's
  double range = 0;      ///< of the positions [rad]
  double half_step = 0;  ///< RMS of the way in half a step [rad]
};
Apart apart(const data::ModelFile& model, const Drive& drive);

/// The model gms of robot_with() with elements whose level does not depend on speed. With Fs above
/// Fc MJCF has an approximation.
data::ModelFile gms_without_stribeck();

}  // namespace fricid::deploy::test
