// Friction as C source for controllers and simulators.
#pragma once

#include <string>

#include "fricid/data/model_file.hpp"

namespace fricid::deploy {

/// Name of a model in code and of its files: name and seed, with _ for every character that is not
/// an ASCII letter or digit ("lvm_s1"); begins with a letter.
std::string code_name(const data::ModelFile& model);

/// One C99 header NAME_friction.h: friction torque and state step of every joint, in double, or in
/// float if FRICID_FLOAT is defined before it is included. It needs only <math.h>, does not
/// allocate, and repeats the operations of friction::RobotFriction on doubles, so results differ
/// only by the rounding of elementary functions. Laws are written out by evaluating them on
/// symbols, so every law of the table can be exported.
///
/// Weights of networks are stored column by column.
std::string c_header(const data::ModelFile& model);

}  // namespace fricid::deploy
