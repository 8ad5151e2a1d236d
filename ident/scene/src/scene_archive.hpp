// The archives of a scene: those of fricid::config, and [friction].
#pragma once

#include "fricid/config/toml_reader.hpp"
#include "fricid/config/toml_writer.hpp"
#include "friction_toml.hpp"

namespace fricid::scene {

class SceneReader : public config::TomlReader {
 public:
  using TomlReader::section;
  using TomlReader::TomlReader;

  void section(std::string_view key, std::optional<friction::Friction>& friction,
               std::string_view /*meaning*/) {
    if (const toml::table* table = find_table(key))
      friction = read_friction(*table, place_of(key), joint_names());
  }
};

class SceneWriter : public config::TomlWriter {
 public:
  using TomlWriter::section;
  using TomlWriter::TomlWriter;

  void section(std::string_view key, std::optional<friction::Friction>& friction,
               std::string_view meaning) {
    if (commented()) {
      const std::string around = open("[", key, "]", meaning);
      append("# load of load-dependent laws; motor_torque\nload = \"motor_torque\"\n");
      append(friction_template());
      close(around);
    } else if (friction) {
      append(write_friction(*friction, joint_names()));
    }
  }
};

}  // namespace fricid::scene
