// RobotFriction for S = PackD.
#include "fricid/friction/detail/kernels.hpp"

namespace fricid::friction {

FRICID_INSTANTIATE_FRICTION(PackD)

}  // namespace fricid::friction
