// Where files named in a scene are looked for.
#pragma once

#include <filesystem>
#include <string>

namespace fricid::data {

/// Folder that holds models/ and scenes/: the environment variable FRICID_SHARE, else
/// ../share/fricid beside the running program, else the source tree.
std::filesystem::path share_dir();

/// Absolute path of an existing file. "$NAME/rest" takes the environment variable NAME; a relative
/// name is looked for in `folder`, then in the share folder.
/// @throws UserError when the variable is not set or the file is in none of these places
std::filesystem::path find_file(const std::string& name, const std::filesystem::path& folder);

}  // namespace fricid::data
