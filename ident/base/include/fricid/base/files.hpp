#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace fricid {

/// Writes `path` atomically: a reader sees the old file or the new one, never a part of it. `write`
/// fills a temporary file in the same folder, which is synced and renamed; then the folder is
/// synced. Creates missing parent folders. Of a symbolic link the target is replaced. If `write`
/// fails or throws, the old file stays and the temporary file is removed. A killed process leaves
/// the temporary file ".NAME.PID.COUNT.fricid.tmp"; the next file that is written in the folder
/// removes it, once no process has that number.
/// @throws UserError naming the path and the reason (no space, no permission, a folder in the way)
/// @see Pillai et al., "All file systems are not created equal", OSDI 2014
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path&)>& write);
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// Whether a file has the name of a temporary file of `write_file_atomically`.
bool is_left_temporary(const std::filesystem::path& file);

/// Removes all temporary files from a folder and its subfolders.
/// @pre no process writes there
void remove_left_temporaries(const std::filesystem::path& folder);

/// Whole content of a text file. @throws UserError if it is missing, a folder, or unreadable
std::string read_file(const std::filesystem::path& path);

/// The file that this code runs from: the program, or the shared library (the Python module) that
/// holds it.
std::filesystem::path running_file();

/// For readers of other libraries, which would wait for ever on a pipe and read a device to no end.
/// @throws UserError if `path` is missing, a folder, a pipe or a device
void require_regular_file(const std::filesystem::path& path);

/// SHA-256 of a file or a text as 64 hexadecimal digits.
std::string sha256_of_file(const std::filesystem::path& path);
std::string sha256_of_text(std::string_view text);

/// Exclusive lock against other processes and other FileLocks: a POSIX record lock on an empty
/// file, which is created and stays. The lock ends with the object or the process; what the process
/// forked does not hold it. File systems without locks give no protection.
class FileLock {
 public:
  /// Creates missing parent folders.
  /// @throws UserError naming the folder if the lock is taken, or if `file` cannot be written
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace fricid
