// RobotFriction for S = PackF.
#include "fricid/friction/detail/kernels.hpp"

namespace fricid::friction {

FRICID_INSTANTIATE_FRICTION(PackF)

}  // namespace fricid::friction
