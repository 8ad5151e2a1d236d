// The C source of an FMU, around the exported header.
#pragma once

#include <string>

namespace fricid::deploy {

/// The functions of FMI 3.0 for co-simulation, around NAME_friction.h. Without the headers of the
/// standard, whose types are repeated.
/// @param name   of the model in code
/// @param token  what an importer must say to instantiate it
std::string fmu_source(const std::string& name, const std::string& token);

}  // namespace fricid::deploy
