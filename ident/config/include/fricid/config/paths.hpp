// Search path of the files named in a scene.
#pragma once

#include <filesystem>
#include <string>

namespace fricid::config {

/// Folder that holds models/ and scenes/: the environment variable FRICID_SHARE, else
/// ../share/fricid beside the program or Python module that runs, else
/// the source tree.
std::filesystem::path share_dir();

/// The engine plugin for MuJoCo: beside the Python module, installed, or in the build tree.
std::filesystem::path mujoco_plugin();

/// Absolute path of an existing file. "$NAME/rest" starts at the environment variable NAME; a
/// relative name is searched in `folder`, then in the share folder.
/// @throws UserError if the variable is not set or the file is not found
std::filesystem::path find_file(const std::string& name, const std::filesystem::path& folder);

/// The file as it is named; where there is none and the name is relative, that of the share folder
/// if there is one.
std::filesystem::path named_or_shared(const std::filesystem::path& file);

}  // namespace fricid::config
