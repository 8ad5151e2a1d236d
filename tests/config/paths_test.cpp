#include "fricid/config/paths.hpp"

#include <cstdlib>

#include "scene_folder.hpp"
#include "source_dir.hpp"

namespace fricid::config {
namespace {

class Paths : public FolderTest {
 protected:
  ~Paths() override {
    unsetenv("FRICID_SHARE");
    unsetenv("FRICID_TEST_LOGS");
  }
};

TEST_F(Paths, BesideTheSceneComesBeforeTheShareFolder) {
  setenv("FRICID_SHARE", path("share").c_str(), 1);
  write("share/a.txt", "share");
  write("share/b.txt", "share");
  write("scene/a.txt", "scene");
  EXPECT_EQ(find_file("a.txt", path("scene")), path("scene/a.txt"));
  EXPECT_EQ(find_file("b.txt", path("scene")), path("share/b.txt"));
  EXPECT_EQ(find_file(path("scene/a.txt").string(), "/"), path("scene/a.txt"));
}

TEST_F(Paths, ShareFolderIsTheSourceTreeWhenNothingIsInstalled) {
  unsetenv("FRICID_SHARE");
  EXPECT_EQ(share_dir(), source_dir());
}

TEST_F(Paths, VariablesAreFilledIn) {
  write("logs/a.csv", "t");
  setenv("FRICID_TEST_LOGS", path("logs").c_str(), 1);
  EXPECT_EQ(find_file("$FRICID_TEST_LOGS/a.csv", "/"), path("logs/a.csv"));
}

TEST_F(Paths, ErrorsSayWhereWasLooked) {
  setenv("FRICID_SHARE", path("share").c_str(), 1);
  const auto message = [&](const char* name) {
    return message_of([&] { find_file(name, path("scene")); });
  };
  EXPECT_EQ(message("x.urdf"), "x.urdf is neither in scene nor in share");
  EXPECT_EQ(message("$FRICID_TEST_LOGS/a.csv"),
            "$FRICID_TEST_LOGS/a.csv needs the environment variable FRICID_TEST_LOGS, which is not "
            "set");
  EXPECT_EQ(message("/none/a.csv"), "/none/a.csv does not exist");
  EXPECT_EQ(message(""), "an empty file name");
}

}  // namespace
}  // namespace fricid::config
