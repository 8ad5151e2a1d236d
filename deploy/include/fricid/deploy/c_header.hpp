// Friction as C source for controllers and simulators.
#pragma once

#include <string>

#include "fricid/data/model_file.hpp"

namespace fricid::deploy {

/// Name of a model in code and of its files: name and seed with every other character than letters
/// of ASCII and digits as _ ("lvm_s1"); it begins with a letter.
std::string code_name(const data::ModelFile& model);

/// One C99 header NAME_friction.h: friction torque and state step of every joint, in double, or in
/// float where FRICID_FLOAT is defined before it is included. It needs <math.h> alone, allocates
/// nothing, and does operation by operation what friction::RobotFriction does on doubles, so
/// results differ by the rounding of elementary functions only. Laws are written out by evaluating
/// them on symbols: whatever the table of laws has can be exported.
///
/// Weights of networks are stored with rows and columns exchanged.
std::string c_header(const data::ModelFile& model);

}  // namespace fricid::deploy
