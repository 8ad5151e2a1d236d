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

/// Files, or parts of them, and words.
struct Lists {
  std::vector<std::string> files, words;

  template <class Archive>
  void visit(Archive& archive) {
    archive("files", files, files_or_parts("to read"));
    archive("words", words, text("in them"));
  }
};

template <class Config>
Config read(const std::string& text) {
  const toml::table table = parse_toml(text, "paint.toml");
  const std::vector<std::string> no_joints;
  TomlReader reader(table, "", "paint.toml", no_joints);
  Config config;
  config.visit(reader);
  reader.refuse_unknown();
  return config;
}
constexpr auto paint_of = read<Paint>;
constexpr auto lists_of = read<Lists>;

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

TEST_F(Toml, APartOfAFileIsATextOrATable) {
  EXPECT_THAT(
      lists_of("files = ['a', 'a[:2]', {file = 'a', from = 1.5, to = 20}, {file = 'a', to = 3}]")
          .files,
      testing::ElementsAre("a", "a[:2]", "a[1.5:20]", "a[:3]"));
  EXPECT_THAT(lists_of("files = {file = 'a', from = 7}").files, testing::ElementsAre("a[7:]"));
  for (const std::string part : {"{from = 1}", "{file = 1}", "{file = 'a', begin = 1}", "{}"})
    EXPECT_EQ(message_of([&] { lists_of("\nfiles = ['a', " + part + "]"); }),
              "paint.toml:2: files[2] = a table; allowed: a text or an array of texts, each "
              "\"FILE\", \"FILE[FROM:TO]\" or {file = \"FILE\", from = FROM, to = TO} [s]")
        << part;
  EXPECT_EQ(message_of([] { lists_of("words = [{file = 'a', to = 3}]"); }),
            "paint.toml:1: words[1] = a table; allowed: a text or an array of texts");
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
