#include "fricid/system/arm.hpp"

#include "arm_pullback.hpp"

namespace fricid {

template class ArmStepper<double>;
template class ArmStepper<PackD>;
template class ArmStepper<PackF>;

}  // namespace fricid
