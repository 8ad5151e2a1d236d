// Names are checked in every file where they enter.
#include <gmock/gmock.h>

#include "fricid/base/names.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/scene/problem.hpp"
#include "hostile_text.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// As a string of TOML and of JSON.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text)
    result += static_cast<unsigned char>(c) < 0x20 || c == '"' || c == '\\' || c == 0x7f
                  ? fmt::format("\\u{:04x}", static_cast<unsigned>(static_cast<unsigned char>(c)))
                  : std::string(1, c);
  return result + "\"";
}

/// Texts that no name may be, whatever it names, and that files of text can carry.
std::vector<std::string> never_names() {
  std::vector<std::string> texts;
  for (const std::string& text : hostile_texts())
    if (text != "EOD" && text != "." && text != ".." && !text.starts_with('-') &&
        !text.starts_with('/') && !text.starts_with("../"))
      texts.push_back(text);
  return texts;
}

class EntryOfNames : public FolderTest {
 protected:
  void expect_refused(const std::string& file, const std::string& text,
                      const std::function<void()>& body) const {
    const std::string said = message_of(body);
    EXPECT_THAT(said, StartsWith(file)) << printable(text);
    EXPECT_EQ(said, printable(said));
  }
};

TEST_F(EntryOfNames, Scene) {
  for (const std::string& text : never_names()) {
    const auto load = [&](const std::string& scene) {
      expect_refused("scene.toml:", text, [&] { scene::load_problem(write("scene.toml", scene)); });
    };
    load("name = " + quoted(text) + "\n" + kScene);
    load(std::string(kScene) + "[[model]]\nlaw = \"lugre\"\nname = " + quoted(text) + "\n");
  }
  for (const char* name : {"../../x", "/abs", "..", "-x", ".x"})
    expect_refused("scene.toml:1: name of a scene", name, [&] {
      scene::load_problem(write("scene.toml", fmt::format("name = \"{}\"\n{}", name, kScene)));
    });
}

TEST_F(EntryOfNames, ModelsOfASceneAreNotTheTruth) {
  for (const char* name : {"oracle", "simulator"})
    expect_refused("scene.toml:13: name of a model", name, [&] {
      scene::load_problem(write(
          "scene.toml", fmt::format("{}[[model]]\nname = \"{}\"\nlaw = \"gms\"\n", kScene, name)));
    });
}

TEST_F(EntryOfNames, LabelsOfASceneShow) {
  expect_refused("scene.toml:14: model[1].label", "label", [&] {
    scene::load_problem(
        write("scene.toml",
              std::string(kScene) + "[[model]]\nname = \"gms\"\nlabel = \"a\\u001b[1m\"\n"));
  });
  expect_refused("scene.toml:1: description", "description", [&] {
    scene::load_problem(write("scene.toml", std::string("description = \"a\\nb\"\n") + kScene));
  });
}

TEST_F(EntryOfNames, Contract) {
  for (const std::string& text : never_names())
    expect_refused("contract.toml:", text, [&] {
      load_contract(write("contract.toml", "joint_names = [" + quoted(text) +
                                               "]\n[position]\ncolumns = \"q{}\"\n[torque]\n"
                                               "columns = \"tau{}\"\n"));
    });
}

TEST_F(EntryOfNames, DataSet) {
  for (const std::string& text : never_names()) {
    if (text.find('\0') != std::string::npos) continue;  // ends a string of HDF5
    write_hdf5(path("log.h5"), "fricid.dataset/1",
               [&](H5Writer& file) { file.attribute("joint_names", std::vector{text}); });
    expect_refused("log.h5: name of a joint", text, [&] { load_dataset(path("log.h5")); });
  }
}

TEST_F(EntryOfNames, FilesOfTrajectories) {
  for (const char* name : {"-x", "a\nb", "a\\b"}) {
    write_hdf5(path(std::string(name) + ".h5"), "fricid.dataset/1", [](H5Writer& file) {
      file.attribute("joint_names", std::vector<std::string>{"a"});
      file.attribute("rate_hz", 250.0);
      file.attribute("source", "test");
    });
    EXPECT_THAT(message_of([&] { load_dataset(path(std::string(name) + ".h5")); }),
                HasSubstr("name of a trajectory"));
  }
}

TEST_F(EntryOfNames, ModelFile) {
  ModelFile model{.name = "plain", .label = "Plain", .seed = 1, .arm = {}, .budget = ""};
  model.arm.robot = dynamics::load_urdf(path("arm.urdf"));
  save_model(model, path("model.json"));
  const std::string whole = read("model.json");
  const std::vector<std::pair<std::string, std::string>> places{
      {"plain", "kModel"},   {"Plain", "label"}, {"two_link", "robot"},
      {"shoulder", "joint"}, {"upper", "link"},  {"flange", "frame"}};
  for (const auto& [value, what] : places) {
    SCOPED_TRACE(what);
    const std::string bad = replaced(whole, quoted(value), quoted("a\nsystem('touch marker')"));
    expect_refused("bad.json: ", what, [&] { load_model(write("bad.json", bad)); });
  }
  expect_refused("bad.json: name of a model", "oracle", [&] {
    load_model(write("bad.json", replaced(whole, quoted("plain"), quoted("oracle"))));
  });
}

}  // namespace
}  // namespace fricid::data
