#define FRICID_INSTANCE template

#include "fricid/base/eigen_instances.hpp"
