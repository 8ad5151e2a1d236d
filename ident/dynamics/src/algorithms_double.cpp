using Scalar = double;

#include "instantiate.inc"
