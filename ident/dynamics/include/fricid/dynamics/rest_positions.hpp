// Where the joints of a robot rest that nobody logs.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace fricid::dynamics {

/// Moving joints of a URDF but those that <mimic> another, and where each would rest: at zero, or
/// at its limit nearest to zero [rad or m]. @throws UserError as load_urdf, for what is read so far
std::map<std::string, double> rest_positions(const std::filesystem::path& path);

}  // namespace fricid::dynamics
