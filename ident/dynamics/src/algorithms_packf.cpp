#include "fricid/base/pack.hpp"

using Scalar = fricid::PackF;

#include "instantiate.inc"
