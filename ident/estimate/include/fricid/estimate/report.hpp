#pragma once

#include "fricid/data/fit_file.hpp"

namespace fricid::estimate {

using data::GearSide;
using data::Outcome;

}  // namespace fricid::estimate
