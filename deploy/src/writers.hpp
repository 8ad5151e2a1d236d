// One function per format.
#pragma once

#include "fricid/deploy/export.hpp"

namespace fricid::deploy {

/// NAME_friction.csv: steady friction torque over speed, joint by joint.
Exported write_csv(const data::ModelFile& model);

/// NAME.urdf: the rigid body. @throws UserError when an inertia is not physical
Exported write_urdf(const data::ModelFile& model);

/// NAME.xml: the rigid body as MJCF. @throws UserError when an inertia is not physical
Exported write_mjcf(const data::ModelFile& model);

}  // namespace fricid::deploy
