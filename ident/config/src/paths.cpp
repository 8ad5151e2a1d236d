#include "fricid/config/paths.hpp"

#include <cstdlib>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"

namespace fricid::config {
namespace {

namespace fs = std::filesystem;

std::string expand_variable(const std::string& name) {
  if (name.empty() || name[0] != '$') return name;
  const std::size_t end = std::min(name.find('/'), name.size());
  const std::string variable = name.substr(1, end - 1);
  const char* value = std::getenv(variable.c_str());
  if (!value || !*value)
    throw UserError("{} needs the environment variable {}, which is not set", name, variable);
  return value + name.substr(end);
}

}  // namespace

fs::path share_dir() {
  if (const char* share = std::getenv("FRICID_SHARE"); share && *share) return share;
  std::error_code error;
  const fs::path running = fs::canonical(running_file(), error);
  const fs::path installed = running.parent_path().parent_path() / "share" / "fricid";
  return !error && fs::is_directory(installed, error) ? installed : FRICID_SOURCE_SHARE;
}

fs::path mujoco_plugin() {
  const fs::path name = "libfricid_mujoco.so";
  std::error_code error;
  const fs::path running = fs::canonical(running_file(), error).parent_path();
  for (const fs::path& folder : {running, running.parent_path() / FRICID_LIBDIR / "fricid"})
    if (!error && fs::exists(folder / name, error)) return folder / name;
  return fs::path(FRICID_PLUGIN_FOLDER) / name;
}

fs::path find_file(const std::string& name, const fs::path& folder) {
  if (name.empty()) throw UserError("an empty file name");
  const fs::path path = expand_variable(name);
  std::error_code error;
  if (path.is_absolute()) {
    if (fs::exists(path, error)) return path.lexically_normal();
    throw UserError("{} does not exist", path.string());
  }
  for (const fs::path& base : {folder.empty() ? fs::path(".") : folder, share_dir()})
    if (fs::exists(base / path, error)) return fs::absolute(base / path).lexically_normal();
  throw UserError("{} is neither in {} nor in {}", name, folder.empty() ? "." : folder.string(),
                  share_dir().string());
}

fs::path named_or_shared(const fs::path& file) {
  std::error_code error;
  if (file.is_absolute() || file.empty() || fs::exists(file, error)) return file;
  const fs::path shared = share_dir() / file;
  return fs::exists(shared, error) ? shared : file;
}

}  // namespace fricid::config
