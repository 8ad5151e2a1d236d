// TOML text with places: parsing, `extends`, and "file:line" of every node.
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fricid::config {

/// A parsed file, merged with the files it extends; every node keeps its own file and line.
struct TomlFile {
  std::string path;  ///< as given by the user, for messages
  toml::table table;
  std::vector<std::filesystem::path> files;  ///< every file read, the outermost first
};

/// @throws UserError "file:line: ..." when missing, a folder, or not TOML
toml::table parse_toml(const std::string& text, const std::string& path);

/// Reads a file; with `extends = "other"` the other file, found beside it or in the share folder,
/// comes first: tables merge, everything else replaces. @throws UserError also on a cycle
TomlFile load_toml(const std::filesystem::path& path);

/// The same of a text that no file holds: places have `name`, such as "<scene>", and no line, and
/// file names start in the current folder.
TomlFile load_toml_text(const std::string& text, const std::string& name);

/// Whether the path of a place is the name of such a text: it begins with <.
bool is_text_alone(std::string_view path);

/// "file:line" of a node, or `fallback` when the parser recorded none.
std::string place(const toml::node& node, const std::string& fallback);

/// "file:line" of a key such as "robot.torque[0].joint", or of the nearest table around it.
std::string place_of_key(const TomlFile& file, std::string_view key);

/// Folder of the file that a node came from.
std::filesystem::path folder_of(const toml::node& node, const std::filesystem::path& fallback);

/// A number, written 3 or 3.0; nothing for any other node.
std::optional<double> as_number(const toml::node& node);

/// Description of a node for messages: 3.5, "text", an array of 3, a table.
std::string found(const toml::node& node);

/// Shortest TOML text that reads back as the same double.
std::string toml_number(double value);
std::string toml_text(std::string_view value);

}  // namespace fricid::config
