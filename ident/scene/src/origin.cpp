#include "fricid/scene/origin.hpp"

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/config/paths.hpp"

namespace fricid::scene {

namespace fs = std::filesystem;

std::string SceneOrigin::place(std::string_view key) const {
  for (std::string around(key); !around.empty();) {
    if (const auto found = keys.find(around); found != keys.end())
      return found->second.line == 0 ? found->second.file
                                     : fmt::format("{}:{}", found->second.file, found->second.line);
    const std::size_t dot = around.rfind('.');
    around.resize(dot == std::string::npos ? 0 : dot);
  }
  return path.empty() ? "scene" : path;
}

fs::path SceneOrigin::folder(std::string_view key) const {
  const auto found = keys.find(std::string(key));
  return fs::path(found != keys.end() ? found->second.file : path).parent_path();
}

fs::path SceneOrigin::find(const std::string& name, std::string_view key) const {
  try {
    const fs::path file = config::find_file(name, folder(key));
    require_regular_file(file);
    return file;
  } catch (const UserError& error) {
    throw UserError("{}: {}: {}", place(key), key, error.what());
  }
}

}  // namespace fricid::scene
