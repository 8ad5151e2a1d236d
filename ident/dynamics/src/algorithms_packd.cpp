#include "fricid/base/pack.hpp"

using Scalar = fricid::PackD;

#include "instantiate.inc"
