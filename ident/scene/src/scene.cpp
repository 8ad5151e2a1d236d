#include "fricid/scene/scene.hpp"

#include "fricid/base/error.hpp"
#include "fricid/config/paths.hpp"
#include "fricid/config/toml_file.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "scene_archive.hpp"
#include "welds.hpp"

namespace fricid::scene {
namespace {

namespace fs = std::filesystem;

SceneOrigin origin_of(const config::TomlFile& file) {
  SceneOrigin origin{.path = file.path, .files = file.files, .keys = {}};
  const auto visit = [&](const auto& self, const toml::node& node, const std::string& key) -> void {
    if (const toml::source_region& source = node.source(); source.path && source.begin.line > 0)
      origin.keys[key] = {*source.path,
                          config::is_text_alone(*source.path) ? 0 : source.begin.line};
    if (const toml::table* table = node.as_table())
      for (auto&& [name, child] : *table) self(self, child, fmt::format("{}.{}", key, name.str()));
    if (const toml::array* array = node.as_array())
      for (std::size_t i = 0; i < array->size(); ++i)
        self(self, *array->get(i), fmt::format("{}[{}]", key, i));
  };
  for (auto&& [name, child] : file.table) visit(visit, child, std::string(name.str()));
  return origin;
}

Scene read_scene(const config::TomlFile& file) {
  Scene scene;
  scene.origin = origin_of(file);
  // The robot first: its joints are how many values the other sections need.
  if (!file.table.contains("robot"))
    throw UserError("{}: robot.urdf is missing: the engine's robot", file.path);
  config::TomlReader(file.table, "", file.path, {}).section("robot", scene.robot, "");
  scene.joints =
      dynamics::load_urdf(scene.origin.find(scene.robot.urdf, "robot.urdf"),
                          Eigen::Matrix3d::Identity(), welds_of(scene), scene.robot.mend_inertia)
          .joint_names();
  SceneReader reader(file.table, "", file.path, scene.joints);
  scene.visit(reader);
  reader.refuse_unknown();
  if (scene.name.empty())
    scene.name = config::is_text_alone(file.path) ? "scene" : fs::path(file.path).stem().string();
  return scene;
}

}  // namespace

Scene load_scene(const fs::path& path) {
  return read_scene(config::load_toml(config::named_or_shared(path)));
}

Scene load_scene_text(const std::string& text) {
  return read_scene(config::load_toml_text(text, "<scene>"));
}

std::string to_toml(const Scene& scene) {
  SceneWriter writer(false, scene.joints);
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
  example.models[0].method = estimate::Method::kConventional;
  SceneWriter writer(true, {});
  example.visit(writer);
  return "# A scene of fricid. Every key is optional unless it says required; the values are the\n"
         "# defaults. A scene may start from another: extends = \"other.toml\" (its tables merge,\n"
         "# its values and arrays are replaced), or from several, the last of which wins:\n"
         "# extends = [\"robot.toml\", \"models.toml\"]. Unknown keys are errors.\n\n" +
         writer.text();
}

}  // namespace fricid::scene
