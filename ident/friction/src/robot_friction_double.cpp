// RobotFriction for S = double.
#include "fricid/friction/detail/kernels.hpp"

namespace fricid::friction {

FRICID_INSTANTIATE_FRICTION(double)

}  // namespace fricid::friction
