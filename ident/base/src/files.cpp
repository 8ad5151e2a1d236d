#include "fricid/base/files.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <regex>
#include <set>
#include <utility>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/processes.hpp"
#include "fricid/base/recording_file.hpp"
#include "fricid/base/temporary_file.hpp"

namespace fricid {
namespace fs = std::filesystem;
namespace {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags)
      : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void throw_system_error(const fs::path& path, std::string_view what) {
  throw UserError("{}: {}: {}", path.string(), what, std::strerror(errno));
}

/// Waits until a file or folder is on disk; EINVAL: a file system that does not sync folders.
void sync(const fs::path& path) {
  const Descriptor file(path, O_RDONLY);
  if (file.get() < 0 || (::fsync(file.get()) != 0 && errno != EINVAL))
    throw_system_error(path, "cannot be written");
}

/// The file that a rename must replace: symbolic links are followed.
fs::path target_of(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status))
    throw UserError("{}: is a folder, a file is to be written", path.string());
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw UserError("{}: is not a regular file", path.string());
  return fs::is_symlink(fs::symlink_status(path, error)) ? fs::weakly_canonical(path) : path;
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

void create_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw UserError("{}: cannot be created: {}", folder.string(), error.message());
}

std::string hexadecimal(const unsigned char* bytes, unsigned size) {
  std::string text;
  for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", bytes[i]);
  return text;
}

/// SHA-256 fed piece by piece.
class Sha256 {
 public:
  Sha256() { EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr); }
  void add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  std::string finish() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
    unsigned size = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &size);
    return hexadecimal(digest.data(), size);
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_{EVP_MD_CTX_new(),
                                                                   &EVP_MD_CTX_free};
};

/// Calls use(piece) for the whole content of a file. Devices may never end; a pipe that nobody
/// writes to is waited for until Ctrl-C.
template <class Use>
void read_pieces(const fs::path& path, Use use) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status))
    throw UserError("{}: is a folder, a file is expected", path.string());
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_fifo(status))
    throw UserError("{}: is not a regular file", path.string());
  const bool pipe = fs::is_fifo(status);
  const Descriptor file(path, pipe ? O_RDONLY | O_NONBLOCK : O_RDONLY);
  if (file.get() < 0) throw_system_error(path, "cannot be read");
  std::vector<char> buffer(1 << 16);
  for (;;) {
    if (pipe) wait_until_readable(file.get());
    const ssize_t size = ::read(file.get(), buffer.data(), buffer.size());
    if (size < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (size < 0) throw_system_error(path, "cannot be read");
    if (size == 0) return;
    use(std::string_view(buffer.data(), static_cast<std::size_t>(size)));
  }
}

/// The process that writes a temporary file; nothing for the name of another file.
std::optional<pid_t> writer_of(const fs::path& file) {
  static const std::regex temporary(R"(\..+\.(\d+)\.\d+\.fricid\.tmp)");
  const std::string name = file.filename().string();
  std::smatch match;
  pid_t writer = 0;
  if (!name.ends_with(".fricid.tmp") || !std::regex_match(name, match, temporary) ||
      std::from_chars(&*match[1].first, &*match[1].second, writer).ec != std::errc())
    return std::nullopt;
  return writer;
}

/// Removes the temporary files of a folder whose writers are gone.
void remove_left_in(const fs::path& folder) {
  std::error_code error;  // files that cannot be listed or removed are skipped
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::optional<pid_t> writer = writer_of(at->path());
    std::error_code kept;
    if (writer && ::kill(*writer, 0) != 0 && errno == ESRCH) fs::remove(at->path(), kept);
  }
}

/// Files that this process has locked: a record lock keeps out other processes only.
class LockedFiles {
 public:
  using Id = std::pair<dev_t, ino_t>;
  static LockedFiles& of_this_process() {
    static LockedFiles files;
    return files;
  }
  bool has(const Id& file) {
    const std::scoped_lock guard(mutex_);
    return files_.contains(file);
  }
  void add(const Id& file) {
    const std::scoped_lock guard(mutex_);
    files_.insert(file);
  }
  void remove(const Id& file) {
    const std::scoped_lock guard(mutex_);
    files_.erase(file);
  }

 private:
  std::mutex mutex_;
  std::set<Id> files_;
};

}  // namespace

fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> count = 0;
  return folder_of(path) /
         fmt::format(".{}.{}.{}.fricid.tmp", path.filename().string(), ::getpid(), count++);
}

void write_file_atomically(const fs::path& path,
                           const std::function<void(const fs::path&)>& write) {
  const fs::path target = target_of(path);
  const fs::path folder = folder_of(target);
  create_folder(folder);

  remove_left_in(folder);
  const fs::path temporary = temporary_beside(target);
  std::error_code error;
  try {
    write(temporary);
    sync(temporary);
    fs::rename(temporary, target, error);
    if (error) throw UserError("{}: cannot be written: {}", path.string(), error.message());
  } catch (...) {
    fs::remove(temporary, error);
    throw;
  }
  sync(folder);
}

void write_file_atomically(const fs::path& path, std::string_view text) {
  write_file_atomically(path, [&](const fs::path& temporary) {
    const Descriptor file(temporary, O_WRONLY | O_CREAT | O_EXCL);
    if (file.get() < 0) throw_system_error(path, "cannot be written");
    while (!text.empty()) {
      const ssize_t size = ::write(file.get(), text.data(), text.size());
      if (size < 0 && errno == EINTR) continue;
      if (size < 0) throw_system_error(path, "cannot be written");
      text.remove_prefix(static_cast<std::size_t>(size));
    }
  });
}

bool is_left_temporary(const fs::path& file) { return writer_of(file).has_value(); }

void remove_left_temporaries(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;  // files that cannot be listed or removed are skipped
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error))
    if (at->is_regular_file(error) && is_left_temporary(at->path())) found.push_back(at->path());
  for (const fs::path& file : found) fs::remove(file, error);
}

std::string read_file(const fs::path& path) {
  std::string text;
  read_pieces(path, [&](std::string_view piece) {
    text += piece;
    require_within(limits::kTextBytes, text.size(), path.string());
  });
  return text;
}

void require_regular_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status))
    throw UserError("{}: cannot be read: {}", path.string(),
                    error ? error.message() : "No such file or directory");
  if (fs::is_directory(status))
    throw UserError("{}: is a folder, a file is expected", path.string());
  if (!fs::is_regular_file(status)) throw UserError("{}: is not a regular file", path.string());
}

std::string read_recording(const fs::path& path) {
  std::error_code error;
  if (const auto size = fs::file_size(path, error); !error)
    require_memory(static_cast<double>(size), path.string(), "its content");
  std::string text;
  const double budget = memory_budget();
  read_pieces(path, [&](std::string_view piece) {
    text += piece;
    if (static_cast<double>(text.size()) > budget)
      require_memory(static_cast<double>(text.size()), path.string(), "its content");
  });
  return text;
}

fs::path running_file() {
  Dl_info info;
  void* map = nullptr;
  const bool found =
      ::dladdr1(reinterpret_cast<const void*>(&running_file), &info, &map, RTLD_DL_LINKMAP) != 0;
  const std::string_view name = found ? static_cast<const link_map*>(map)->l_name : "";
  return name.empty() ? fs::path("/proc/self/exe") : fs::path(name);  // the program has no name
}

std::string sha256_of_file(const fs::path& path) {
  Sha256 hash;
  read_pieces(path, [&](std::string_view piece) { hash.add(piece); });
  return hash.finish();
}

std::string sha256_of_text(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hash.finish();
}

FileLock::FileLock(const fs::path& file) {
  const fs::path folder = folder_of(file);
  create_folder(folder);
  const auto refuse = [&] {
    throw UserError("{}: another run is writing here; wait for it or name another folder",
                    folder.string());
  };
  // Before opening: a process that closes any descriptor of a file loses its lock on it.
  struct stat status;
  LockedFiles& locked = LockedFiles::of_this_process();
  if (::stat(file.c_str(), &status) == 0 && locked.has({status.st_dev, status.st_ino})) refuse();

  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw_system_error(file, "cannot be written");
  struct flock whole = {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  if (::fcntl(descriptor_, F_SETLK, &whole) != 0 && (errno == EACCES || errno == EAGAIN)) {
    ::close(descriptor_);
    refuse();
  }
  ::fstat(descriptor_, &status);
  locked.add({status.st_dev, status.st_ino});
}

FileLock::~FileLock() {
  struct stat status;
  ::fstat(descriptor_, &status);
  LockedFiles::of_this_process().remove({status.st_dev, status.st_ino});
  ::close(descriptor_);
}

}  // namespace fricid
