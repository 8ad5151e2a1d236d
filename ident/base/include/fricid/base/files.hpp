#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace fricid {

/// Writes `path` so that a reader sees the old file or the new one and never a torn one: `write`
/// fills a temporary file in the same folder, which is synced, renamed and the folder synced.
/// Creates missing parent folders.
/// @throws UserError naming the path and the reason (no space, no permission, a folder in the way)
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path&)>& write);
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// Whole content of a text file. @throws UserError when missing, a folder, or unreadable
std::string read_file(const std::filesystem::path& path);

/// SHA-256 of a file or a text as 64 hexadecimal digits.
std::string sha256_of_file(const std::filesystem::path& path);
std::string sha256_of_text(std::string_view text);

}  // namespace fricid
