// Where a scene came from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fricid::scene {

/// Place of a key of a scene.
struct Place {
  std::string file;        ///< as the user named it
  std::uint64_t line = 0;  ///< 0: a text that no file holds
};

/// For messages, and for the files a scene names. Empty for a scene made in code.
struct SceneOrigin {
  std::string path;                          ///< as the user named it
  std::vector<std::filesystem::path> files;  ///< read for it, itself first, then what it extends
  std::map<std::string, Place> keys;         ///< "robot.torque[0].joint" and so on, and tables

  /// "file:line" of a key or of the nearest table around it that was written, for messages.
  std::string place(std::string_view key) const;
  /// Folder of the file in which a key stands: relative file names start there.
  std::filesystem::path folder(std::string_view key) const;
  /// Absolute path of the file that a key names. @throws UserError when it is not there
  std::filesystem::path find(const std::string& name, std::string_view key) const;
};

}  // namespace fricid::scene
