// Structs that name their fields, read from and written as TOML.
#include <gmock/gmock.h>

#include "fricid/config/toml_file.hpp"
#include "fricid/config/toml_reader.hpp"
#include "fricid/config/toml_writer.hpp"
#include "scene_folder.hpp"

namespace fricid::config {
namespace {

enum class Colour { kRed, kGreen };
constexpr std::string_view names(Colour) { return "red|green"; }

struct Paint {
  Colour colour = Colour::kGreen;
  std::optional<Colour> edge;
  std::array<double, 2> size{1, 2};

  template <class Archive>
  void visit(Archive& archive) {
    archive("colour", colour, choice("of the face"));
    archive("edge", edge, choice("none: as the face"));
    archive("size", size, number("m", 0, 10, "width and height"));
  }
};

Paint paint_of(const std::string& text) {
  const toml::table table = parse_toml(text, "paint.toml");
  const std::vector<std::string> no_joints;
  TomlReader reader(table, "", "paint.toml", no_joints);
  Paint paint;
  paint.visit(reader);
  reader.refuse_unknown();
  return paint;
}

std::string written(Paint paint, bool commented) {
  TomlWriter writer(commented, {});
  paint.visit(writer);
  return writer.text();
}

class Toml : public FolderTest {};

TEST_F(Toml, EnumsAreTheirNames) {
  EXPECT_EQ(paint_of("").colour, Colour::kGreen);
  EXPECT_EQ(paint_of("colour = \"red\"").colour, Colour::kRed);
  EXPECT_FALSE(paint_of("").edge);
  EXPECT_EQ(paint_of("edge = \"green\"").edge, Colour::kGreen);
  EXPECT_EQ(message_of([] { paint_of("size = [1, 2]\nedge = \"blue\""); }),
            "paint.toml:2: edge = \"blue\"; allowed: red or green");
  EXPECT_EQ(message_of([] { paint_of("colour = 1"); }),
            "paint.toml:1: colour = 1; allowed: red or green");
}

TEST_F(Toml, WhatIsUnsetIsLeftOut) {
  EXPECT_EQ(written({}, false), "colour = \"green\"\nsize = [1.0, 2.0]\n");
  EXPECT_EQ(written({.edge = Colour::kRed}, true),
            "# of the face; red or green\ncolour = \"green\"\n"
            "# none: as the face; red or green\nedge = \"red\"\n"
            "# width and height; an array, each a number from 0 to 10 m\nsize = [1.0, 2.0]\n");
}

TEST_F(Toml, AnUnknownKeyIsToldFromAnOptionalOne) {
  EXPECT_EQ(message_of([] { paint_of("edgy = \"red\""); }),
            "paint.toml:1: unknown key edgy; nearest known key: edge");
}

}  // namespace
}  // namespace fricid::config
