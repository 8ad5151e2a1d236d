#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace fricid {

/// Writes `path` so that a reader sees the old file or the new one and never a torn one: `write`
/// fills a temporary file in the same folder, which is synced, renamed and the folder synced.
/// Creates missing parent folders; a symbolic link stays one and its target is replaced. After a
/// failure or an exception of `write` the old file is untouched and the temporary removed; after a
/// kill the temporary
/// ".NAME.PID.COUNT.tmp" stays.
/// @throws UserError naming the path and the reason (no space, no permission, a folder in the way)
/// @see Pillai et al., "All file systems are not created equal", OSDI 2014
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path&)>& write);
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// Whether a file is one that a killed writer left.
bool is_left_temporary(const std::filesystem::path& file);

/// Removes what killed writers left in a folder and below: files ".NAME.PID.COUNT.tmp".
/// @pre no process writes there
void remove_left_temporaries(const std::filesystem::path& folder);

/// Whole content of a text file. @throws UserError when missing, a folder, or unreadable
std::string read_file(const std::filesystem::path& path);

/// SHA-256 of a file or a text as 64 hexadecimal digits.
std::string sha256_of_file(const std::filesystem::path& path);
std::string sha256_of_text(std::string_view text);

/// Keeps other processes (and other FileLocks) out for as long as it lives, whatever ends the
/// process: an exclusive flock on an empty file that is made for it and stays. On file systems
/// without locks it keeps nobody out.
class FileLock {
 public:
  /// Creates missing parent folders.
  /// @throws UserError naming the folder when it is held already, or `file` cannot be written
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace fricid
