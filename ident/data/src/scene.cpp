#include "fricid/data/scene.hpp"

#include "fricid/base/error.hpp"
#include "fricid/data/paths.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "joint_names.hpp"
#include "toml_file.hpp"
#include "toml_reader.hpp"
#include "toml_writer.hpp"

namespace fricid::data {
namespace {

namespace fs = std::filesystem;

SceneOrigin origin_of(const TomlFile& file) {
  SceneOrigin origin{.path = file.path, .files = file.files, .keys = {}};
  const auto visit = [&](const auto& self, const toml::node& node, const std::string& key) -> void {
    if (const toml::source_region& source = node.source(); source.path && source.begin.line > 0)
      origin.keys[key] = {*source.path, source.begin.line};
    if (const toml::table* table = node.as_table())
      for (auto&& [name, child] : *table)
        self(self, child,
             key.empty() ? std::string(name.str()) : key + "." + std::string(name.str()));
    if (const toml::array* array = node.as_array())
      for (std::size_t i = 0; i < array->size(); ++i)
        self(self, *array->get(i), fmt::format("{}[{}]", key, i));
  };
  for (auto&& [name, child] : file.table) visit(visit, child, std::string(name.str()));
  return origin;
}

}  // namespace

std::string SceneOrigin::place(std::string_view key) const {
  for (std::string around(key); !around.empty();) {
    if (const auto found = keys.find(around); found != keys.end())
      return fmt::format("{}:{}", found->second.file, found->second.line);
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
    return find_file(name, folder(key));
  } catch (const UserError& error) {
    throw UserError("{}: {}: {}", place(key), key, error.what());
  }
}

Scene load_scene(const fs::path& path) {
  const TomlFile file = load_toml(path);
  Scene scene;
  scene.origin = origin_of(file);
  // The robot first: its joints are how many values the other sections need.
  if (!file.table.contains("robot"))
    throw UserError("{}: robot.urdf is missing: the engine's robot", file.path);
  TomlReader(file.table, "", file.path, {}).section("robot", scene.robot, "");
  scene.joints =
      joint_names(dynamics::load_urdf(scene.origin.find(scene.robot.urdf, "robot.urdf")));
  TomlReader reader(file.table, "", file.path, scene.joints);
  scene.visit(reader);
  reader.refuse_unknown();
  if (scene.name.empty()) scene.name = path.stem().string();
  return scene;
}

std::string to_toml(const Scene& scene) {
  TomlWriter writer(false, scene.joints);
  Scene copy = scene;
  copy.visit(writer);
  return writer.text();
}

std::string scene_template() {
  Scene example;
  example.name = "example";
  example.robot.urdf = "models/kr6_r700/kr6_r700.urdf";
  example.robot.mjcf = "models/kr6_r700/kr6_r700.xml";
  example.models.emplace_back();
  example.models[0].name = "lugre";
  example.models[0].label = "LuGre";
  example.models[0].method = "conventional";
  TomlWriter writer(true, {});
  example.visit(writer);
  return "# A scene of fricid. Every key is optional unless it says required; the values are the\n"
         "# defaults. A scene may start from another: extends = \"other.toml\" (its tables merge,\n"
         "# its values and arrays are replaced), or from several, the last of which wins:\n"
         "# extends = [\"robot.toml\", \"models.toml\"]. Unknown keys are errors.\n\n" +
         writer.text();
}

}  // namespace fricid::data
