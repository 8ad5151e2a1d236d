#pragma once

#include "fricid/data/fit_file.hpp"

namespace fricid::estimate {

using data::Outcome;
using data::to_string;

}  // namespace fricid::estimate
