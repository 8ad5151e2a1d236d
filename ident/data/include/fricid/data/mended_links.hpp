// What reports say of `dynamics::RobotModel::mended_links`.
#pragma once

#include "fricid/base/field.hpp"

namespace fricid::data {

inline constexpr Field kMendedLinks =
    text("links whose inertia in the robot's file no body has: the nearest was taken");

}  // namespace fricid::data
